//! What every way to bring terrain to the GPU and to draw it promises: one table of cases, run on each
//! strategy, with the reason where one is excepted. What only some promise has files of its own.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

mod at_rest;
mod budgets;
mod drawn;
mod failing_tiles;
mod heights;
mod in_step;
mod limits;
mod places;
mod same_picture;
mod settings;

use terrain_tests::cases;

cases! {
    at_rest::a_still_camera_costs_nothing_but_its_picture {}
    at_rest::a_view_of_the_sky_is_a_state {}
    at_rest::drawing_beside_the_frames_leaves_no_trace {}
    at_rest::where_tiles_and_view_feed_each_other_the_camera_still_comes_to_rest {}

    same_picture::ten_thousand_kilometres_away_it_is_the_same {}
    same_picture::it_does_not_depend_on_the_way_there {
        CpuMesh: "triangles are joined only below 0.6 of the error they are cut at: some of the way stay",
    }
    same_picture::both_lookups_draw_the_same {
        Clipmap: "where a window holds a place follows by arithmetic, without a lookup",
    }
    same_picture::after_jumps_across_the_earth_it_is_what_it_was {}

    places::a_plane_is_met_near_and_far_and_at_far_origins {
        CpuMesh: "its triangles may look 1.5 pixels off, which its own cases bound",
    }
    places::a_cone_is_met_within_a_part_of_a_pixel {
        CpuMesh: "its triangles may look 1.5 pixels off, which its own cases bound",
    }
    places::ground_without_data_is_left_out_and_no_other {}

    failing_tiles::ground_shows_from_any_height {}
    failing_tiles::while_tiles_are_late_the_coarser_ones_show_and_no_frame_waits_for_them {}
    failing_tiles::tiles_that_cannot_be_loaded_are_named_and_leave_no_hole {}
    failing_tiles::a_damaged_level_without_imagery_leaves_no_hole {}
    failing_tiles::a_lost_device_is_an_error_not_a_panic {}

    budgets::the_budget_bounds_the_bytes_of_a_frame {}
    budgets::the_smallest_cache_and_no_budget_still_draw {}

    in_step::frames_in_step_are_the_same_on_every_run_and_late_tiles_come_late {}

    settings::a_new_cache_is_counted {
        Clipmap: "its windows are as large as the view asks, whatever the cache's size",
    }
    settings::a_cache_larger_than_a_texture_is_refused_and_the_old_one_stays {
        Clipmap: "its windows are as large as the view asks, whatever the cache's size",
    }
    settings::every_view_of_the_ground_can_be_drawn {}
    settings::exaggeration_up_to_a_thousandfold_and_what_is_none {}

    limits::cameras_at_the_limits {}
    limits::views_that_are_none_are_refused_and_leave_the_renderer_as_it_was {}
    limits::any_camera_at_all {}

    heights::heights_at_the_limits_of_their_types {}
    heights::a_dem_full_of_numbers_that_are_no_heights {}
}

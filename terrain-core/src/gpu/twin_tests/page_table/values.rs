//! Places, levels, requests and colours, point by point.

use glam::{DVec2, IVec2, Vec2, dvec2, vec2};

use super::{
    ATLAS_COLUMNS, MOST_TAPS, PageProbePoint, SIZE_TEXELS, Stage, TILE, between, bilinear,
    globe_layout, layout, mix, size_of_data, trilinear,
};
use crate::gpu::twin_tests::gpu;
use crate::gpu::twin_tests::random_field::Random;
use crate::residency::page_table::{
    Footprint, PageEntry, PageId, PageLayout, PageRequest, TexturePlace,
};

/// Points all over the texture and on its edges, and some turns beyond them where it goes round, with footprints of
/// all sizes and shapes.
fn points(layout: &PageLayout) -> Vec<PageProbePoint> {
    let mut random = Random(17);
    let mut coordinate = || match random.next() % 12 {
        0 => 0.0,
        1 => 1.0,
        _ => random.unit() as f32,
    };
    let mut places = (0..4_000).map(|_| vec2(coordinate(), coordinate())).collect::<Vec<_>>();
    if layout.round_texels > 0 {
        places.iter_mut().step_by(3).for_each(|place| place.x = 4.0 * place.x - 1.5);
        // Whole turns, and beside the date line.
        places.iter_mut().step_by(5).for_each(|place| place.x = place.x.round());
        places.iter_mut().step_by(7).for_each(|place| place.x *= 1.0e-3);
    }
    let mut span = || {
        let length = (9.0 * random.unit() - 3.0).exp2();
        let angle = std::f64::consts::TAU * random.unit();
        (DVec2::from_angle(angle) * length).as_vec2()
    };
    let point = |st| PageProbePoint { st, span_x: span(), span_y: span(), padding: Vec2::ZERO };
    places.into_iter().map(point).collect()
}

/// Whether a value within rounding of this one may fall into another step of a level.
fn is_between_steps(level: f32) -> bool {
    let steps = level * PageRequest::STEPS as f32;
    (steps - steps.round()).abs() < 1.0e-3
}

#[test]
fn places_levels_and_requests_are_the_same_on_both() {
    compare_places(layout());
}

#[test]
fn places_that_go_round_are_the_same_on_both() {
    compare_places(globe_layout());
}

fn compare_places(layout: PageLayout) {
    let Some(gpu) = gpu() else { return };
    let bias = 0.3;
    let stage = Stage::new(gpu, layout, bias, true);
    let layout = &stage.layout;
    let points = points(layout);
    let mut uncertain = 0;
    for (point, answer) in points.iter().zip(stage.probe(&points)) {
        let exact = point.st.as_dvec2() * size_of_data(layout);
        let texel = Vec2::from(answer.part).as_dvec2() + IVec2::from(answer.texel).as_dvec2();
        assert!(between(layout, texel, exact).length() < 1.0e-3, "{answer:?}");
        let in_turn =
            layout.round_texels == 0 || (0..layout.round_texels).contains(&answer.texel[0]);
        assert!(in_turn, "{answer:?}");
        let place = TexturePlace { texel: answer.texel.into(), part: answer.part.into() };
        let footprint = Footprint::new(point.span_x, point.span_y, MOST_TAPS);
        let ratio = {
            let squares = [point.span_x, point.span_y].map(|span| span.length_squared());
            (squares[0].max(squares[1]) / squares[0].min(squares[1]).max(1.0)).sqrt()
        };
        // Where the sides' ratio is all but whole, either number of taps is right.
        if (ratio - ratio.round()).abs() < 1.0e-4 || is_between_steps(footprint.level + bias) {
            uncertain += 1;
            continue;
        }
        assert_eq!(answer.taps, footprint.taps, "{answer:?}");
        assert!((answer.level - footprint.level).abs() < 1.0e-4, "{answer:?} {footprint:?}");
        let request = footprint.request(layout, place, bias).unwrap_or(PageRequest::NONE);
        assert_eq!(answer.request, request);
        let wanted = (footprint.level + bias).floor().clamp(0.0, f32::from(layout.coarsest_level));
        let mut pages =
            (wanted as u8..=layout.coarsest_level).map(|level| place.page(layout, level));
        let there = |page: &PageId| matches!(stage.stream.on_gpu(*page), PageEntry::At(_));
        let page = pages.find(there).unwrap();
        assert_eq!(answer.found_level, u32::from(page.level), "the finest that is there");
        let word = answer.found_word;
        let slot = PageEntry::At((word & 0xff) + ATLAS_COLUMNS * (word >> 8 & 0xff));
        assert_eq!(stage.stream.on_gpu(page), slot, "{page:?}");
        let within = place.in_page(layout, page);
        assert!((Vec2::from(answer.in_page) - within).length() < 1.0e-3, "{answer:?}");
    }
    println!("{uncertain} of {} points within rounding of two answers", points.len());
    assert!(uncertain < points.len() / 20);
}

/// The noise is white, so that a texel beside the right one is another colour altogether.
#[test]
fn colours_are_those_of_an_f64_evaluation_of_the_same_filter() {
    compare_colours(layout());
}

#[test]
fn colours_go_round_as_if_the_texture_had_no_edge() {
    compare_colours(globe_layout());
}

fn compare_colours(layout: PageLayout) {
    let Some(gpu) = gpu() else { return };
    let bias = 0.3;
    let stage = Stage::new(gpu, layout, bias, true);
    let points = points(&stage.layout);
    let (mut compared, mut across, mut anisotropic) = (0, 0, 0);
    for (point, answer) in points.iter().zip(stage.probe(&points)) {
        let size = size_of_data(&stage.layout);
        let place = point.st.as_dvec2() * size;
        let to_edges = place.min(size - place);
        let goes_round = stage.layout.round_texels > 0;
        let to_edge = if goes_round { to_edges.y } else { to_edges.min_element() };
        let reach = point.span_x.length().max(point.span_y.length());
        let (expected, coarsest) = stage.filtered(point, &answer, bias);
        // At the edges the outermost texels go on.
        if to_edge < f64::from(reach) + 3.0 * f64::from(coarsest).exp2() {
            continue;
        }
        let worst = (0..3).map(|i| (f64::from(answer.colour[i]) - expected[i]).abs());
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 0.02, "{worst}: {answer:?}, expected {expected:?}");
        compared += 1;
        anisotropic += usize::from(answer.taps > 1.0);
        let within = Vec2::from(answer.in_page).min(TILE as f32 - Vec2::from(answer.in_page));
        across += usize::from(within.min_element() < 1.0);
    }
    println!("{compared} colours, {anisotropic} of several taps, {across} beside a page's border");
    assert!(anisotropic > 500 && compared > anisotropic + 200 && across > 50);
}

#[test]
fn at_the_far_edges_the_outermost_texels_show() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::new(gpu, layout(), 0.0, true);
    let still = vec2(0.0, 0.0);
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
    let point = |&(s, t): &(f32, f32)| PageProbePoint {
        st: vec2(s, t),
        span_x: still,
        span_y: still,
        padding: still,
    };
    let points = corners.iter().map(point).collect::<Vec<_>>();
    for ((s, t), answer) in corners.iter().zip(stage.probe(&points)) {
        let level = answer.found_level as u8;
        let texels = SIZE_TEXELS.map(|size| f64::from(size) / f64::from(level).exp2());
        let edge = |far: f32, texels: f64| if far > 0.0 { texels - 0.5 } else { 0.5 };
        let place = dvec2(edge(*s, texels[0]), edge(*t, texels[1])) * f64::from(level).exp2();
        let expected = bilinear(&stage.layout, level, 0, place);
        let worst = (0..3).map(|i| (f64::from(answer.colour[i]) - expected[i]).abs());
        assert!(worst.fold(0.0, f64::max) < 0.02, "{answer:?}, expected {expected:?}");
    }
}

#[test]
fn a_page_that_fades_in_shows_a_part_of_itself_over_what_was_there() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::new(gpu, layout(), 0.0, false);
    let points = points(&stage.layout);
    let mut compared = 0;
    for (point, answer) in points.iter().zip(stage.probe(&points)) {
        let place = point.st.as_dvec2() * dvec2(1_900.0, 1_150.0);
        let found_level = answer.found_level as u8;
        let coarsest = stage.layout.coarsest_level;
        let to_edge = place.min(dvec2(1_900.0, 1_150.0) - place).min_element();
        if answer.taps > 1.0 || found_level + 1 >= coarsest || to_edge < 200.0 {
            continue;
        }
        let on_gpu = TexturePlace { texel: answer.texel.into(), part: answer.part.into() };
        let mut coarser =
            (found_level + 1..=coarsest).map(|level| on_gpu.page(&stage.layout, level));
        let there = |page: &PageId| matches!(stage.stream.on_gpu(*page), PageEntry::At(_));
        let below =
            trilinear(&stage.layout, coarser.find(there).unwrap().level, answer.level, place);
        let expected = mix(below, trilinear(&stage.layout, found_level, answer.level, place), 0.25);
        let worst = (0..3).map(|i| (f64::from(answer.colour[i]) - expected[i]).abs());
        assert!(worst.fold(0.0, f64::max) < 0.02, "{answer:?}, expected {expected:?}");
        compared += 1;
    }
    assert!(compared > 50, "{compared}");
}

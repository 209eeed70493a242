//! The circular mesh against what a disc of triangles must be, and its culling against projection.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::{DVec2, dvec2, dvec3};
use proptest::prelude::*;

use super::{CircularMesh, CircularMeshSettings};
use crate::CameraView;
use crate::tiling::Extent;

/// Fine and coarse, narrow and wide, with every `base` of segments, and one of a single block.
const SETTINGS: [(f64, f64); 8] = [
    (0.02, 300.0),
    (0.03, 20.0),
    (0.045, 1000.0),
    (0.07, 50.0),
    (0.11, 8.0),
    (0.2, 1.0e6),
    (0.3, 1.0),
    (0.5, 40.0),
];

fn build((spacing_ratio, rho_max): (f64, f64)) -> CircularMesh {
    CircularMesh::build(&CircularMeshSettings { spacing_ratio, rho_max })
}

fn offset(mesh: &CircularMesh, index: u32) -> DVec2 {
    let [east, north] = mesh.vertices[index as usize].offset;
    dvec2(f64::from(east), f64::from(north))
}

fn triangles(mesh: &CircularMesh) -> impl Iterator<Item = [u32; 3]> + '_ {
    mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]])
}

/// For each vertex the first one with the same bits.
fn welded(mesh: &CircularMesh) -> Vec<usize> {
    let mut first = HashMap::new();
    let bits = |offset: [f32; 2]| offset.map(f32::to_bits);
    (0..).zip(&mesh.vertices).map(|(i, v)| *first.entry(bits(v.offset)).or_insert(i)).collect()
}

#[test]
fn it_is_one_disc_without_cracks() {
    for settings in SETTINGS {
        let mesh = build(settings);
        let weld = welded(&mesh);
        let mut directed = HashMap::new();
        for triangle in triangles(&mesh) {
            for side in 0..3 {
                let from = weld[triangle[side] as usize];
                let to = weld[triangle[(side + 1) % 3] as usize];
                assert_ne!(from, to, "{settings:?}: a triangle without area");
                *directed.entry((from, to)).or_insert(0) += 1;
            }
        }
        assert!(directed.values().all(|&count| count == 1), "{settings:?}: an edge used twice");
        let rim: Vec<_> =
            directed.keys().filter(|(a, b)| !directed.contains_key(&(*b, *a))).collect();
        let outermost = mesh.vertices.iter().map(|v| v.offset[0]).fold(0.0, f32::max);
        for &&(a, b) in &rim {
            for vertex in [a, b] {
                let rho = offset(&mesh, vertex as u32).length() as f32;
                assert!((rho / outermost - 1.0).abs() < 1e-6, "{settings:?}: a crack at {rho}");
            }
        }
        let vertices = weld.iter().enumerate().filter(|&(i, &first)| i == first).count() as i64;
        let edges = ((directed.len() + rim.len()) / 2) as i64;
        let faces = (mesh.indices.len() / 3) as i64;
        assert_eq!(vertices - edges + faces, 1, "{settings:?}: not a disc");
    }
}

#[test]
fn triangles_face_up_and_fill_the_rim_polygon() {
    for settings in SETTINGS {
        let mesh = build(settings);
        let mut area = 0.0;
        for [a, b, c] in triangles(&mesh).map(|t| t.map(|index| offset(&mesh, index))) {
            let twice = (b - a).perp_dot(c - a);
            assert!(twice > 0.0, "{settings:?}: {a} {b} {c} is clockwise");
            area += 0.5 * twice;
        }
        let rho = mesh.vertices.iter().map(|v| f64::from(v.offset[0])).fold(0.0, f64::max);
        let on_rim = |v: DVec2| v.length() > rho * (1.0 - 1e-6);
        let mut rim: Vec<_> = mesh.vertices.iter().map(|v| v.offset.map(f32::to_bits)).collect();
        rim.sort_unstable();
        rim.dedup();
        let vertex = |bits: &[u32; 2]| {
            dvec2(f64::from(f32::from_bits(bits[0])), f64::from(f32::from_bits(bits[1])))
        };
        let segments = rim.iter().map(vertex).filter(|&v| on_rim(v)).count() as f64;
        let polygon = 0.5 * segments * rho * rho * (TAU / segments).sin();
        assert!((area / polygon - 1.0).abs() < 1e-5, "{settings:?}: {area} of {polygon}");
    }
}

#[test]
fn it_reaches_the_radius_asked_for_and_not_a_ring_further() {
    for (spacing_ratio, rho_max) in SETTINGS {
        let mesh = build((spacing_ratio, rho_max));
        let rho = mesh.vertices.iter().map(|v| f64::from(v.offset[0])).fold(0.0, f64::max);
        assert!(rho >= rho_max * (1.0 - 1e-6), "{rho} < {rho_max}");
        assert!(rho.asinh() < rho_max.asinh() + spacing_ratio * 1.001, "{rho} > {rho_max}");
    }
}

#[test]
fn edges_and_the_stated_spacing_follow_the_distance() {
    for (spacing_ratio, rho_max) in SETTINGS {
        let mesh = build((spacing_ratio, rho_max));
        let target = |rho: f64| spacing_ratio * rho.hypot(1.0);
        for vertex in &mesh.vertices {
            let [east, north] = vertex.offset.map(f64::from);
            let ratio = f64::from(vertex.spacing) / target(east.hypot(north));
            assert!((0.7..=2.0).contains(&ratio), "{spacing_ratio}: spacing {ratio} of target");
        }
        for triangle in triangles(&mesh) {
            let corners = triangle.map(|index| offset(&mesh, index));
            for side in 0..3 {
                let (a, b) = (corners[side], corners[(side + 1) % 3]);
                let ratio = (b - a).length() / target((0.5 * (a + b)).length());
                // Diagonals are the longest; alpha this large bends a ring's spacing itself.
                let longest = 2.0 * (1.0 + spacing_ratio);
                assert!((0.5..longest).contains(&ratio), "{spacing_ratio}: edge {ratio} of target");
            }
        }
    }
}

#[test]
fn blocks_own_their_vertices_and_state_their_bounds() {
    for settings in SETTINGS {
        let mesh = build(settings);
        let (mut next_vertex, mut next_index) = (0, 0);
        for block in &mesh.blocks {
            assert_eq!((block.vertex_start, block.index_start), (next_vertex, next_index));
            next_vertex += block.vertex_count;
            next_index += block.index_count;
            assert!(block.index_count <= 3 * 2 * 17 * 17, "{settings:?}: {block:?}");
            let own = block.vertex_start..next_vertex;
            let indices = &mesh.indices[block.index_start as usize..next_index as usize];
            assert!(indices.iter().all(|index| own.contains(index)), "{settings:?}: {block:?}");
            for index in own {
                let point = offset(&mesh, index);
                let slack = 1e-6 * point.length() + 1e-12;
                assert!(point.length() <= f64::from(block.rho_max) + slack, "{point} {block:?}");
                assert!(point.length() >= f64::from(block.rho_min) - slack, "{point} {block:?}");
                let middle = 0.5 * f64::from(block.angle_min_rad + block.angle_max_rad);
                let half = 0.5 * f64::from(block.angle_max_rad - block.angle_min_rad);
                let off_middle = DVec2::from_angle(middle).angle_to(point).abs();
                assert!(half > 3.0 || off_middle <= half + 1e-6, "{point} {block:?}");
            }
        }
        assert_eq!(next_vertex as usize, mesh.vertices.len());
        assert_eq!(next_index as usize, mesh.indices.len());
    }
}

#[test]
fn absurd_settings_still_make_a_mesh() {
    for (spacing_ratio, rho_max) in
        [(f64::NAN, 1.0), (0.5, f64::NAN), (f64::INFINITY, 2.0), (-1.0, 0.0), (1.0, -5.0)]
    {
        let mesh = build((spacing_ratio, rho_max));
        assert!(mesh.indices.len() >= 3 && mesh.indices.len().is_multiple_of(3));
    }
}

fn level_view(heading_deg: f64) -> CameraView {
    CameraView {
        eye: dvec3(3.0e5, 7.0e6, 1_500.0),
        heading_deg,
        pitch_deg: -10.0,
        fov_y_deg: 36.0,
        viewport_px: [1280, 720],
    }
}

/// Triangles drawn, in parts of all.
fn drawn_part(mesh: &CircularMesh, visible: &[u32]) -> f64 {
    let drawn: u32 = visible.iter().map(|&i| mesh.blocks[i as usize].index_count).sum();
    f64::from(drawn) / mesh.indices.len() as f64
}

#[test]
fn a_view_of_sixty_degrees_draws_a_quarter_of_the_mesh() {
    let mesh = build((0.02, 300.0));
    let everywhere = Extent::new(DVec2::splat(-1.0e9), DVec2::splat(1.0e9));
    for heading_deg in [0.0, 37.0, 90.0, 200.0] {
        let view = level_view(heading_deg);
        let visible = mesh.visible_blocks(&view, 500.0, DVec2::ZERO, 0.0, 1_000.0, &everywhere);
        let part = drawn_part(&mesh, &visible);
        assert!((0.10..0.26).contains(&part), "{heading_deg}: {part}");
    }
}

#[test]
fn blocks_beyond_the_data_and_views_of_the_sky_draw_nothing() {
    let mesh = build((0.05, 300.0));
    let view = level_view(0.0);
    let eye = view.eye.truncate();
    let count = |view: &CameraView, extent: Extent| {
        mesh.visible_blocks(view, 500.0, DVec2::ZERO, 0.0, 1_000.0, &extent).len()
    };
    let far_away = Extent::new(DVec2::ZERO, dvec2(1.0e5, 1.0e5));
    assert_eq!(count(&view, far_away), 0);
    let everywhere = Extent::new(eye - 1.0e9, eye + 1.0e9);
    let nearby = Extent::new(eye - 20_000.0, eye + 20_000.0);
    assert!(count(&view, nearby) > 0 && count(&view, nearby) < count(&view, everywhere));
    let up = CameraView { pitch_deg: 40.0, ..view };
    assert_eq!(count(&up, everywhere), 0, "all ground is below the eye");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_block_with_a_point_in_the_picture_is_culled(
        (settings, heading_deg, pitch_deg, fov_y_deg) in
            (0..4usize, -180.0..180.0, -90.0..90.0, 20.0..120.0f64),
        (east_m, north_m, scale_m) in (-900.0..900.0, -900.0..900.0, 10.0..2000.0),
        (low_m, range_m, extent_m) in (-500.0..500.0, 0.0..2500.0, 100.0..1.0e6),
        points in prop::collection::vec(
            (0.0..1.0, 0.0..1.0, 0.0..1.0, 0.0..1.0f64), 200),
    ) {
        let mesh = build([(0.07, 50.0), (0.11, 8.0), (0.3, 1.0), (0.2, 1000.0)][settings]);
        let view = CameraView { heading_deg, pitch_deg, fov_y_deg, ..level_view(0.0) };
        let centre_offset = dvec2(east_m, north_m);
        let eye = view.eye.truncate();
        let extent = Extent::new(eye - extent_m, eye + extent_m);
        let high_m = low_m + range_m;
        let visible = mesh.visible_blocks(&view, scale_m, centre_offset, low_m, high_m, &extent);
        for (number, u, v, w) in points {
            let first = 3 * (number * (mesh.indices.len() / 3) as f64) as usize;
            let [a, b, c] = [0, 1, 2].map(|side| offset(&mesh, mesh.indices[first + side]));
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let normalised = a + u * (b - a) + v * (c - a);
            let ground: DVec2 = eye + centre_offset + scale_m * normalised;
            let point = ground.extend(low_m + w * range_m);
            let is_in_picture = view.pixel_from_world(point).is_some_and(|[x, y]| {
                (0.0..=1280.0).contains(&x) && (0.0..=720.0).contains(&y)
            });
            if is_in_picture && extent.contains(ground) {
                let block = mesh.blocks.iter().rposition(|b| b.index_start as usize <= first);
                prop_assert!(visible.contains(&(block.unwrap() as u32)), "{point} of {block:?}");
            }
        }
    }
}

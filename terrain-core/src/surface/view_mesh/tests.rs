//! The mesh against what a triangulation of the ground must be, by arithmetic of the tests' own.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{DVec2, DVec3, IVec2, dvec2};
use proptest::prelude::*;

use super::{HeightPatch, PatchFrame, RefineSettings, Refined, Sight, ViewMesh};
use crate::CameraView;
use crate::dataset::{HeightRange, HeightSamples, HeightTile};
use crate::tiling::{Extent, LayerLayout, TileId, TilingScheme};

const ROOT_M: f64 = 8_192.0;
const LEVELS: u8 = 4;
const SETTINGS: RefineSettings = RefineSettings { tolerance_px: 2.0, most_triangles: 100_000 };

fn frame() -> PatchFrame {
    let scheme = TilingScheme { origin: dvec2(500_000.0, 4_000_000.0), root_size_m: ROOT_M };
    let layout = LayerLayout { tile_size_texels: 32, gutter_texels: 4, level_count: LEVELS };
    // Data that ends within tiles on every side.
    let root = scheme.root_extent();
    let data_extent = Extent::new(root.min + dvec2(0.0, 900.0), root.max - dvec2(700.0, 0.0));
    PatchFrame { scheme, data_extent, layout }
}

type Ground = fn(DVec2) -> f64;

/// Rough at every scale; x and y from the root's corner in metres.
fn hills(p: DVec2) -> f64 {
    250.0 * (p.x / 900.0).sin() * (p.y / 1_100.0).cos()
        + 40.0 * (p.x / 130.0 + p.y / 210.0).sin()
        + 6.0 * (p.x / 37.0).cos() * (p.y / 29.0).sin()
}

/// [`hills`] with a round lake of no data.
fn lake(p: DVec2) -> f64 {
    if p.distance(dvec2(3_000.0, 4_000.0)) < 800.0 { f64::NAN } else { hills(p) }
}

fn patch(tile: TileId, ground: Ground) -> Arc<HeightPatch> {
    let frame = frame();
    let size = frame.layout.stored_size_texels();
    let corner = frame.layout.stored_extent(&frame.scheme, tile);
    let texel_m = frame.layout.texel_size_m(&frame.scheme, tile.level);
    let height_m = |index: u32| {
        let place = dvec2(f64::from(index % size) + 0.5, f64::from(index / size) + 0.5) * texel_m;
        let world = dvec2(corner.min.x + place.x, corner.max.y - place.y);
        let from_root = world - frame.scheme.origin;
        ground(dvec2(from_root.x, -from_root.y)) as f32
    };
    let samples = HeightSamples::Metres((0..size * size).map(height_m).collect());
    let range = Some(HeightRange { min_m: -300.0, max_m: 300.0 });
    let tile = HeightTile { id: tile, stored_size_texels: size, samples, range };
    let is_finest = tile.id.level + 1 == LEVELS;
    Arc::new(HeightPatch::new(tile, frame, is_finest))
}

fn tiles_of(level: u8) -> impl Iterator<Item = TileId> {
    (0..1_u32 << level)
        .flat_map(move |row| (0..1_u32 << level).map(move |column| TileId::new(level, row, column)))
}

/// A mesh with the tiles of all levels up to this one in use.
fn mesh_to(level: u8, ground: Ground) -> ViewMesh {
    let mut mesh = ViewMesh::new(frame(), patch(TileId::ROOT, ground), 1.0);
    for tile in (1..=level).flat_map(tiles_of) {
        mesh.use_patch(patch(tile, ground));
    }
    mesh
}

fn view(heading_deg: f64) -> CameraView {
    CameraView {
        eye: DVec3::new(500_000.0 + 4_100.0, 4_000_000.0 - 4_300.0, 420.0),
        heading_deg,
        pitch_deg: -20.0,
        fov_y_deg: 50.0,
        viewport_px: [640, 360],
    }
}

fn settle(mesh: &mut ViewMesh, view: &CameraView, settings: RefineSettings) -> Refined {
    let sight = Sight::new(view);
    for _ in 0..1_000 {
        let refined = mesh.refine(&sight, settings, 5_000);
        if refined.is_done && refined.cuts + refined.joins == 0 {
            return refined;
        }
    }
    panic!("the mesh does not come to rest");
}

/// Corners of every triangle, in units.
fn shapes(mesh: &ViewMesh) -> Vec<[IVec2; 3]> {
    mesh.triangles().map(|t| t.map(|number| mesh.vertex(number).position)).collect()
}

fn sorted_shapes(mesh: &ViewMesh) -> Vec<[[i32; 2]; 3]> {
    let mut shapes: Vec<_> =
        shapes(mesh).into_iter().map(|shape| shape.map(|point| point.to_array())).collect();
    shapes.sort_unstable();
    shapes
}

/// Panics unless the triangles cover the root once and share whole edges.
fn check_whole(mesh: &ViewMesh) {
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    let mut doubled_area = 0_i64;
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.map(|number| mesh.vertex(number).position.as_i64vec2());
        let (ab, ac) = (b - a, c - a);
        // y runs south: counter-clockwise from above is negative.
        let area = ac.x * ab.y - ac.y * ab.x;
        assert!(area > 0, "{triangle:?} is turned over or empty");
        doubled_area += area;
        for i in 0..3 {
            let edge = (triangle[i], triangle[(i + 1) % 3]);
            assert!(edges.insert(edge, 1).is_none(), "two triangles on one side of {edge:?}");
        }
    }
    assert_eq!(doubled_area, 1_i64 << 61, "the root is not covered once");
    let side = 1 << 30;
    for &(from, to) in edges.keys() {
        if edges.contains_key(&(to, from)) {
            continue;
        }
        let [p, q] = [from, to].map(|number| mesh.vertex(number).position);
        let on_border = [p.x, p.y].into_iter().zip([q.x, q.y]);
        let on_border = on_border.into_iter().any(|(p, q)| p == q && (p == 0 || p == side));
        assert!(on_border, "a crack along {p} to {q}");
    }
    let positions: HashSet<_> = mesh.triangles().flatten().collect();
    let places: HashSet<_> = positions.iter().map(|&number| mesh.vertex(number).position).collect();
    assert_eq!(places.len(), positions.len(), "two vertices in one place");
}

fn world(point: IVec2) -> DVec2 {
    let unit_m = ROOT_M / f64::from(1 << 30);
    frame().scheme.origin + dvec2(f64::from(point.x), -f64::from(point.y)) * unit_m
}

/// Largest error in pixels of the mesh from the ground of the tiles in use, at every texel centre of a
/// level, of ground in the picture.
fn worst_error_px(mesh: &ViewMesh, view: &CameraView, level: u8) -> f64 {
    let frame = frame();
    let texels = f64::from(frame.layout.tile_size_texels << level);
    let texel_m = ROOT_M / texels;
    let mut worst = 0.0_f64;
    for triangle in mesh.triangles() {
        let corners = triangle.map(|number| {
            let vertex = mesh.vertex(number);
            world(vertex.position).extend(f64::from(vertex.height_m))
        });
        let [a, b, c] = corners;
        let low = a.min(b).min(c);
        let high = a.max(b).max(c);
        let first = ((low.truncate() - frame.scheme.origin) / texel_m).floor();
        let last = ((high.truncate() - frame.scheme.origin) / texel_m).ceil();
        for row in first.y as i64..=last.y as i64 {
            for column in first.x as i64..=last.x as i64 {
                let place =
                    frame.scheme.origin + dvec2(column as f64 + 0.5, row as f64 + 0.5) * texel_m;
                let (u, v) = parts(a.truncate(), b.truncate(), c.truncate(), place);
                let inner = frame.data_extent.grown(-texel_m).contains(place);
                if u < 0.0 || v < 0.0 || u + v > 1.0 || !inner {
                    continue;
                }
                let Some(height_m) = mesh.height_at_m(place) else { continue };
                let drawn_m = a.z + u * (b.z - a.z) + v * (c.z - a.z);
                let point = place.extend(height_m);
                let [x, y] = view.pixel_from_world(point).unwrap_or([-1.0; 2]);
                if (0.0..640.0).contains(&x) && (0.0..360.0).contains(&y) {
                    let angle = (height_m - drawn_m).abs() / view.eye.distance(point);
                    worst = worst.max(angle / view.pixel_angle_rad());
                }
            }
        }
    }
    worst
}

/// Barycentric parts of b and c at a point.
fn parts(a: DVec2, b: DVec2, c: DVec2, point: DVec2) -> (f64, f64) {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let area = ab.perp_dot(ac);
    (ap.perp_dot(ac) / area, ab.perp_dot(ap) / area)
}

#[test]
fn at_rest_no_ground_in_the_picture_is_farther_off_than_the_tolerance() {
    let mut counts = Vec::new();
    for tolerance_px in [1.0, 4.0] {
        let settings = RefineSettings { tolerance_px, ..SETTINGS };
        let mut mesh = mesh_to(2, hills);
        for heading_deg in [0.0, 130.0] {
            let view = view(heading_deg);
            settle(&mut mesh, &view, settings);
            check_whole(&mesh);
            let worst = worst_error_px(&mesh, &view, 2);
            println!("{tolerance_px} px: {} triangles, worst {worst} px", mesh.triangle_count());
            assert!(worst <= 1.001 * tolerance_px, "{worst} px");
            assert!(worst > 0.4 * tolerance_px, "far too fine: {worst} px");
        }
        counts.push(mesh.triangle_count());
    }
    assert!(counts[0] > 2 * counts[1], "{counts:?}");
}

#[test]
fn a_still_or_trembling_camera_changes_nothing() {
    let mut mesh = mesh_to(3, hills);
    settle(&mut mesh, &view(20.0), SETTINGS);
    mesh.take_changes();
    let still = mesh.refine(&Sight::new(&view(20.0)), SETTINGS, 5_000);
    assert_eq!(still, Refined { cuts: 0, joins: 0, is_done: true });
    // Forth and back: what a step forth cuts, the step back does not join.
    let mut there = view(20.0);
    there.eye += DVec3::new(3.0, 2.0, -1.0);
    settle(&mut mesh, &there, SETTINGS);
    mesh.take_changes();
    for _ in 0..6 {
        for view in [view(20.0), there] {
            let refined = mesh.refine(&Sight::new(&view), SETTINGS, 5_000);
            assert_eq!((refined.cuts, refined.joins), (0, 0));
        }
    }
    assert_eq!(mesh.changed(), (0, 0));
}

#[test]
fn a_turn_and_back_costs_nothing_the_second_time() {
    let mut mesh = mesh_to(3, hills);
    for heading_deg in (0..360).step_by(15) {
        settle(&mut mesh, &view(f64::from(heading_deg)), SETTINGS);
    }
    mesh.take_changes();
    for heading_deg in (0..360).step_by(5) {
        settle(&mut mesh, &view(f64::from(heading_deg)), SETTINGS);
    }
    let (vertices, _) = mesh.changed();
    assert!(vertices * 20 < mesh.vertex_capacity(), "{vertices} vertices changed");
}

/// Every change carried out on a copy gives the mesh, whatever the way.
struct Copy {
    vertices: HashMap<u32, (IVec2, f32)>,
    triangles: Vec<[u32; 3]>,
}

impl Copy {
    fn follow(&mut self, mesh: &mut ViewMesh) {
        let changes = mesh.take_changes();
        for (number, vertex) in changes.vertices {
            self.vertices.insert(number, (vertex.position, vertex.height_m));
        }
        self.triangles.resize(mesh.triangle_count(), [u32::MAX; 3]);
        for (place, corners) in changes.triangles {
            self.triangles[place as usize] = corners;
        }
        for (copied, corners) in self.triangles.iter().zip(mesh.triangles()) {
            let is_point = copied.iter().all(|&number| number == copied[0]);
            assert!(*copied == corners || is_point, "{copied:?} is not {corners:?}");
            for number in copied {
                let vertex = mesh.vertex(*number);
                assert_eq!(self.vertices[number], (vertex.position, vertex.height_m));
            }
        }
    }
}

#[test]
fn tiles_that_come_and_go_leave_the_mesh_whole_and_every_change_told() {
    let mut mesh = mesh_to(0, hills);
    let mut copy = Copy { vertices: HashMap::new(), triangles: Vec::new() };
    let some = [(1, 0, 1), (1, 1, 1), (2, 1, 2), (3, 3, 4), (2, 3, 3), (3, 2, 5)];
    let some = some.map(|(level, row, column)| TileId::new(level, row, column));
    for (step, tile) in some.into_iter().enumerate() {
        mesh.use_patch(patch(tile, hills));
        settle(&mut mesh, &view(40.0 * step as f64), SETTINGS);
        check_whole(&mesh);
        copy.follow(&mut mesh);
    }
    assert_eq!(mesh.patch_count(), 7);
    for tile in some.into_iter().rev() {
        mesh.drop_patch(tile);
        check_whole(&mesh);
        settle(&mut mesh, &view(40.0), SETTINGS);
        check_whole(&mesh);
        copy.follow(&mut mesh);
    }
    assert_eq!(mesh.patch_count(), 1);
    mesh.drop_patch(TileId::ROOT);
    mesh.drop_patch(some[0]);
    assert_eq!(mesh.patch_count(), 1, "level 0 stays");
    mesh.use_patch(patch(TileId::new(2, 0, 0), hills));
    assert_eq!(mesh.patch_count(), 1, "nothing without the tile above it");
}

#[test]
fn every_vertex_has_the_height_of_the_finest_tile_in_use() {
    let mut mesh = mesh_to(1, hills);
    let tile = TileId::new(2, 1, 1);
    mesh.use_patch(patch(tile, hills));
    settle(&mut mesh, &view(300.0), SETTINGS);
    let finest = patch(tile, hills);
    let extent = frame().scheme.tile_extent(tile);
    let mut seen = 0;
    for number in mesh.triangles().flatten().collect::<HashSet<_>>() {
        let vertex = mesh.vertex(number);
        if extent.contains(world(vertex.position)) {
            let expected = finest.height_at_m(world(vertex.position)).unwrap();
            assert!((f64::from(vertex.height_m) - expected).abs() < 1.0e-3);
            seen += 1;
        }
    }
    assert!(seen > 50, "{seen}");
}

#[test]
fn the_way_to_a_view_does_not_matter_but_for_what_lies_between_the_thresholds() {
    let all_round = |tolerance_px: f64| {
        let mut mesh = mesh_to(2, hills);
        settle(&mut mesh, &view(0.0), RefineSettings { tolerance_px, ..SETTINGS });
        mesh
    };
    let fresh = all_round(2.0);
    let mut travelled = mesh_to(2, hills);
    for step in 0..20 {
        let mut view = view(0.0);
        view.eye += DVec3::new(-40.0, -60.0, 8.0) * f64::from(19 - step);
        settle(&mut travelled, &view, SETTINGS);
    }
    let vertices = |mesh: &ViewMesh| -> HashSet<[i32; 2]> {
        shapes(mesh).into_iter().flatten().map(|point| point.to_array()).collect()
    };
    let missing = vertices(&fresh).difference(&vertices(&travelled)).count();
    assert_eq!(missing, 0, "what the view wants is there whatever the way");
    // The same way twice gives the same mesh.
    let again = all_round(2.0);
    assert_eq!(sorted_shapes(&fresh), sorted_shapes(&again));
}

#[test]
fn a_mesh_too_large_becomes_coarser_and_comes_to_rest() {
    let mut mesh = mesh_to(3, hills);
    let settings = RefineSettings { tolerance_px: 0.5, most_triangles: 3_000 };
    for heading_deg in [0.0, 90.0, 180.0] {
        settle(&mut mesh, &view(heading_deg), settings);
        assert!(mesh.triangle_count() <= 3_000, "{}", mesh.triangle_count());
        assert!(mesh.triangle_count() > 1_200, "{}", mesh.triangle_count());
        check_whole(&mesh);
    }
    settle(&mut mesh, &view(180.0), SETTINGS);
    let mut steps = 0;
    while mesh.coarsening > 1.0 && steps < 100 {
        settle(&mut mesh, &view(180.0 + f64::from(steps)), SETTINGS);
        steps += 1;
    }
    assert!(steps < 100, "the tolerance never comes back");
}

#[test]
fn the_shore_of_ground_without_data_is_cut_fine() {
    let mut mesh = mesh_to(3, lake);
    let mut view = view(250.0);
    view.eye.x += 600.0;
    settle(&mut mesh, &view, SETTINGS);
    check_whole(&mesh);
    let centre = frame().scheme.origin + dvec2(3_000.0, -4_000.0);
    for triangle in mesh.triangles() {
        let corners = triangle.map(|number| mesh.vertex(number));
        let coverage = corners.map(|vertex| vertex.coverage);
        assert!(coverage.iter().all(|part| (0.0..=1.0).contains(part)));
        for vertex in corners {
            let from_shore_m = world(vertex.position).distance(centre) - 800.0;
            if from_shore_m.abs() > 70.0 && frame().data_extent.contains(world(vertex.position)) {
                assert_eq!(vertex.coverage > 0.5, from_shore_m > 0.0, "{from_shore_m} m");
            }
        }
        let places = corners.map(|vertex| world(vertex.position));
        let middle = (places[0] + places[1] + places[2]) / 3.0;
        let pixel = view.pixel_from_world(middle.extend(0.0));
        let in_view =
            pixel.is_some_and(|[x, y]| (50.0..590.0).contains(&x) && (50.0..310.0).contains(&y));
        if in_view && coverage.contains(&0.0) && coverage.contains(&1.0) {
            let longest_m = places[1].distance(places[2]);
            // A cell of the finest tiles here, 32 m, and its diagonal.
            assert!(longest_m < 50.0, "{longest_m} m across the shore");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn any_flight_leaves_the_mesh_whole(
        steps in prop::collection::vec((0.0..8_192.0_f64, 0.0..8_192.0_f64, 10.0..4_000.0_f64, 0.0..360.0_f64, 0..21_usize, any::<bool>()), 1..12)
    ) {
        let mut mesh = mesh_to(0, hills);
        let mut copy = Copy { vertices: HashMap::new(), triangles: Vec::new() };
        let tiles: Vec<_> = (1..=2).flat_map(tiles_of).collect();
        for (x, y, z, heading_deg, tile, comes) in steps {
            let tile = tiles[tile % tiles.len()];
            if comes { mesh.use_patch(patch(tile, hills)) } else { mesh.drop_patch(tile) }
            let eye = DVec3::new(500_000.0 + x, 4_000_000.0 - y, z);
            let view = CameraView { eye, heading_deg, ..view(0.0) };
            mesh.refine(&Sight::new(&view), RefineSettings { most_triangles: 2_000, ..SETTINGS }, 300);
            check_whole(&mesh);
            copy.follow(&mut mesh);
        }
    }
}

use std::collections::HashMap;

use glam::{DVec2, dvec2};
use proptest::prelude::*;

use super::*;
use crate::CameraView;
use crate::tiling::{Extent, TilingScheme};

const SCHEME: TilingScheme =
    TilingScheme { origin: DVec2::new(-5_000.0, 70_000.0), root_size_m: 65_536.0 };

fn mesh(eye: DVec2, clearance_m: f64) -> ClipMesh {
    ClipMesh::new(&ClipMeshView {
        scheme: &SCHEME,
        data_extent: &SCHEME.root_extent(),
        eye,
        clearance_m,
        triangle_rad: 4.0 / 32.0,
        least_spacing_m: 32.0,
    })
}

/// A vertex's place in units, as the vertex stage finds it.
fn vertex(block: &ClipBlock, column: u32, row: u32) -> [i64; 2] {
    let [columns, rows] = block.size();
    let has = |flag: u32| block.ring_and_flags & flag != 0;
    let mut cell = [i64::from(column), i64::from(row)];
    let is_outer = !has(ClipBlock::OUTERMOST);
    let on_column =
        (has(ClipBlock::WEST) && column == 0) || (has(ClipBlock::EAST) && column == columns);
    let on_row = (has(ClipBlock::NORTH) && row == 0) || (has(ClipBlock::SOUTH) && row == rows);
    let odd = [
        (i64::from(column) + i64::from(has(ClipBlock::ODD_COLUMN))) & 1,
        (i64::from(row) + i64::from(has(ClipBlock::ODD_ROW))) & 1,
    ];
    if is_outer && on_row {
        cell[0] -= odd[0];
    }
    if is_outer && on_column {
        cell[1] -= odd[1];
    }
    [0, 1].map(|axis| i64::from(block.corner[axis]) + (cell[axis] << block.ring()))
}

/// Triangles of a block, each turning the same way, those shrunk to a line left out.
fn triangles(block: &ClipBlock) -> Vec<[[i64; 2]; 3]> {
    let [columns, rows] = block.size();
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let [nw, ne] = [vertex(block, column, row), vertex(block, column + 1, row)];
            let [sw, se] = [vertex(block, column, row + 1), vertex(block, column + 1, row + 1)];
            triangles.extend([[nw, sw, se], [nw, se, ne]]);
        }
    }
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    triangles
}

/// Twice the area, positive where the triangle turns anticlockwise as seen from above.
fn doubled_area([a, b, c]: &[[i64; 2]; 3]) -> i64 {
    // Rows run south.
    (b[0] - a[0]) * -(c[1] - a[1]) + (b[1] - a[1]) * (c[0] - a[0])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Every inner edge belongs to two triangles, once in each direction, and the edges of one triangle
    /// alone make up the outermost border: no crack, no overlap, wherever the eye is.
    #[test]
    fn the_rings_are_one_closed_surface(
        x in -80_000.0f64..120_000.0, y in -60_000.0f64..140_000.0, clearance_m in 1.0f64..30_000.0,
    ) {
        let mesh = mesh(dvec2(x, y), clearance_m);
        let mut edges: HashMap<([i64; 2], [i64; 2]), i32> = HashMap::new();
        let mut doubled = 0;
        for block in &mesh.blocks {
            let most = mesh.block_cells();
            prop_assert!(block.size().iter().all(|&size| size >= 1 && size <= most), "{block:?}");
            for triangle in triangles(block) {
                prop_assert!(doubled_area(&triangle) > 0, "{triangle:?} of {block:?}");
                doubled += doubled_area(&triangle);
                let [a, b, c] = triangle;
                for edge in [(a, b), (b, c), (c, a)] {
                    *edges.entry(edge).or_default() += 1;
                }
            }
        }
        let side = i64::from(mesh.cells) << (mesh.rings - 1);
        prop_assert_eq!(doubled, 2 * side * side);
        let alone = edges.iter().filter(|((a, b), _)| !edges.contains_key(&(*b, *a)));
        prop_assert_eq!(alone.count() as u32, 4 * mesh.cells);
        prop_assert!(edges.values().all(|&count| count == 1));
    }

    #[test]
    fn the_mesh_reaches_all_data_and_the_eye_is_near_the_middle_of_every_ring(
        x in -80_000.0f64..120_000.0, y in -60_000.0f64..140_000.0, clearance_m in 1.0f64..30_000.0,
    ) {
        let eye = dvec2(x, y);
        let mesh = mesh(eye, clearance_m);
        prop_assert!(mesh.reference_from_eye_m.abs().max_element() <= 0.5 * mesh.unit_m + 1.0e-9);
        for ring in 0..mesh.rings {
            let spacing_m = mesh.unit_m * f64::from(ring).exp2();
            let blocks = mesh.blocks.iter().filter(|block| block.ring() == ring);
            let first = blocks.map(|block| block.corner).reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])]);
            let [west, north] = first.unwrap().map(f64::from);
            let half_m = 0.5 * f64::from(mesh.cells) * spacing_m;
            let middle = mesh.reference_from_eye_m
                + dvec2(west * mesh.unit_m + half_m, -north * mesh.unit_m - half_m);
            prop_assert!(middle.abs().max_element() <= spacing_m * 1.0001, "ring {ring}: {middle}");
        }
        let reach_m = (0.5 * f64::from(mesh.cells) - 1.0) * mesh.unit_m * f64::from(mesh.rings - 1).exp2();
        let root = SCHEME.root_extent();
        let far = (root.min - eye).abs().max((root.max - eye).abs()).max_element();
        prop_assert!(reach_m >= far);
        // Straight below, a triangle has the wanted size or half of it, or the least there is.
        let wanted_m = clearance_m * 4.0 / 32.0;
        let is_wanted = (0.5..=1.0).contains(&(mesh.unit_m / wanted_m));
        prop_assert!(is_wanted || mesh.unit_m == 32.0, "{} for {wanted_m}", mesh.unit_m);
    }
}

#[test]
fn blocks_in_view_are_those_that_hold_a_point_in_view() {
    let eye = dvec2(20_000.0, 30_000.0);
    let mesh = mesh(eye, 500.0);
    let extent: Extent = SCHEME.root_extent();
    for (heading_deg, pitch_deg) in [(0.0, -10.0), (130.0, -40.0), (250.0, 5.0), (0.0, -90.0)] {
        let view = CameraView {
            eye: eye.extend(900.0),
            heading_deg,
            pitch_deg,
            fov_y_deg: 50.0,
            viewport_px: [320, 180],
        };
        let visible = mesh.visible_blocks(&view, [0.0, 400.0], &extent);
        assert!(
            visible.len() < mesh.blocks.len() * 3 / 4,
            "{} of {}",
            visible.len(),
            mesh.blocks.len()
        );
        let in_view = |point: glam::DVec3| {
            view.pixel_from_world(point)
                .is_some_and(|[x, y]| (0.0..320.0).contains(&x) && (0.0..180.0).contains(&y))
        };
        for block in &mesh.blocks {
            let place = |column: u32, row: u32| {
                let [x, y] = vertex(block, column, row).map(|at| at as f64 * mesh.unit_m);
                eye + mesh.reference_from_eye_m + dvec2(x, -y)
            };
            let [columns, rows] = block.size();
            let is_seen = (0..=rows)
                .flat_map(|row| (0..=columns).map(move |column| (column, row)))
                .any(|(column, row)| {
                    let point = place(column, row);
                    extent.contains(point)
                        && [0.0, 200.0, 400.0].iter().any(|&z| in_view(point.extend(z)))
                });
            assert!(!is_seen || visible.contains(block), "{block:?} at heading {heading_deg}");
        }
    }
}

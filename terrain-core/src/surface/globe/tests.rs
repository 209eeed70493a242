use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec2, DVec3, dvec2};
use proptest::prelude::*;

use super::*;
use crate::CameraView;
use crate::dataset::{HeightSamples, HeightTile};
use crate::geodesy::{Geodetic, PlateCarree, Wgs84};
use crate::tiling::{LayerLayout, TileId, TilingScheme};

fn scheme() -> TilingScheme {
    PlateCarree::scheme()
}

const LAYOUT: LayerLayout = LayerLayout { tile_size_texels: 64, gutter_texels: 4, level_count: 2 };

/// Mountains with no pattern that anything else has.
fn height_at_m(point: DVec2) -> f32 {
    (4_000.0 * (point.x / 3.1e5).sin() * (point.y / 2.3e5).cos()) as f32
}

fn tile(id: TileId) -> Arc<HeightTile> {
    let size = LAYOUT.stored_size_texels();
    let corner = LAYOUT.stored_extent(&scheme(), id);
    let texel_m = LAYOUT.texel_size_m(&scheme(), id.level);
    let heights = (0..size * size).map(|index| {
        let place = dvec2(f64::from(index % size), f64::from(index / size)) + 0.5;
        height_at_m(dvec2(corner.min.x, corner.max.y) + dvec2(place.x, -place.y) * texel_m)
    });
    Arc::new(HeightTile {
        id,
        stored_size_texels: size,
        range: None,
        samples: HeightSamples::Metres(heights.collect()),
    })
}

fn level_ground() -> GlobeGround {
    GlobeGround::new(scheme(), LAYOUT, [0.0; 2])
}

/// Ground whose western half is known finer.
fn mountains() -> GlobeGround {
    let mut ground = GlobeGround::new(scheme(), LAYOUT, [-4_000.0, 4_000.0]);
    ground.show(tile(TileId::ROOT));
    ground.show(tile(TileId::new(1, 0, 0)));
    ground
}

fn view(longitude_deg: f64, latitude_deg: f64, height_m: f64, pitch_deg: f64) -> CameraView {
    CameraView {
        eye: PlateCarree::metres_from_degrees(dvec2(longitude_deg, latitude_deg)).extend(height_m),
        heading_deg: 37.0,
        pitch_deg,
        fov_y_deg: 50.0,
        viewport_px: [320, 180],
    }
}

const SETTINGS: CoverSettings =
    CoverSettings { cell_px: 8.0, curve_px: 0.25, most_triangles: 150_000, most_made: usize::MAX };

/// The vertices of all triangles of some patches, as the GPU places them.
fn triangles(
    store: &mut PatchStore,
    ground: &GlobeGround,
    cover: &GlobeCover,
) -> Vec<[SplitPlace; 3]> {
    let lists = PatchTriangles::new();
    let mut triangles = Vec::new();
    for covered in &cover.patches {
        let (patch, _) = store.get(covered.id, ground);
        let range = lists.range(covered.coarse_edges);
        let indices = &lists.indices[range.start as usize..range.end as usize];
        let place = |index: u16| patch.vertices[usize::from(index)].split_place();
        triangles.extend(indices.chunks_exact(3).map(|t| [place(t[0]), place(t[1]), place(t[2])]));
    }
    triangles
}

/// How often each edge is gone along in its direction less how often against it; all 0 for a closed surface.
fn open_edges(triangles: &[[SplitPlace; 3]]) -> Vec<[SplitPlace; 2]> {
    type Key = ([i32; 3], [i32; 3]);
    let key = |place: SplitPlace| -> Key { (place.coarse.to_array(), place.fine.to_array()) };
    let mut edges: HashMap<(Key, Key), ([SplitPlace; 2], i32)> = HashMap::new();
    for triangle in triangles {
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let ends = [triangle[from], triangle[to]];
            let [from, to] = ends.map(key);
            let (ordered, step) = if from < to { ((from, to), 1) } else { ((to, from), -1) };
            edges.entry(ordered).or_insert((ends, 0)).1 += step;
        }
    }
    edges.into_values().filter(|(_, count)| *count != 0).map(|(ends, _)| ends).collect()
}

fn check_surface(view: &CameraView, ground: &GlobeGround) -> Result<(), TestCaseError> {
    let sight = GlobeSight::new(view, ground.lowest_m());
    let mut store = PatchStore::default();
    let mut cover = cover(&mut store, ground, &sight, &SETTINGS);
    prop_assert!(!cover.is_unfinished);
    prop_assert!(cover.patches.len() * 512 <= SETTINGS.most_triangles);
    let in_view = triangles(&mut store, ground, &cover);
    // All patches, those out of view as well, are one closed surface.
    let bits = |id: PatchId, all: &[PatchId]| {
        let coarser =
            |edge: PatchEdge| id.neighbour(edge).parent().is_some_and(|p| all.contains(&p));
        (0..).zip(PatchEdge::ALL).map(|(bit, edge)| u8::from(coarser(edge)) << bit).sum()
    };
    let all = cover.all.clone();
    let seen: HashMap<PatchId, u8> = cover.patches.iter().map(|p| (p.id, p.coarse_edges)).collect();
    cover.patches =
        all.iter().map(|&id| CoveredPatch { id, coarse_edges: bits(id, &all) }).collect();
    for patch in &cover.patches {
        if let Some(coarse_edges) = seen.get(&patch.id) {
            prop_assert_eq!(*coarse_edges, patch.coarse_edges, "{:?}", patch.id);
        }
    }
    let everywhere = triangles(&mut store, ground, &cover);
    let open = open_edges(&everywhere);
    prop_assert!(open.is_empty(), "{} open edges, {:?}", open.len(), open.first());
    let eye = sight.eye;
    // What is left out is not in view: no vertex of it, but where the globe hides it.
    let shown: std::collections::HashSet<_> =
        in_view.iter().flatten().map(|p| (p.coarse.to_array(), p.fine.to_array())).collect();
    for place in everywhere.iter().flatten() {
        if shown.contains(&(place.coarse.to_array(), place.fine.to_array())) {
            continue;
        }
        let place = place.place();
        let on_picture = pixel_of(view, place)
            .is_some_and(|[x, y]| (0.0..=320.0).contains(&x) && (0.0..=180.0).contains(&y));
        prop_assert!(
            !on_picture || is_hidden(eye, place, ground.lowest_m()),
            "{place} is left out"
        );
    }
    Ok(())
}

fn pixel_of(view: &CameraView, place: DVec3) -> Option<[f64; 2]> {
    let eye = Geodetic::from_plate_carree(view.eye);
    let local = eye.ecef_from_local().transpose() * (place - Wgs84::ecef_from_geodetic(&eye));
    view.pixel_from_world(view.eye + local)
}

/// Whether the segment between the two goes through the ellipsoid sunk by the lowest ground.
fn is_hidden(eye: DVec3, place: DVec3, lowest_m: f64) -> bool {
    let (a, b) = (Wgs84::EQUATOR_RADIUS_M, Wgs84::POLAR_RADIUS_M);
    let axes = glam::dvec3(a, a, b) * (1.0 + lowest_m / b);
    let (from, to) = (eye / axes, place / axes);
    let along = to - from;
    let nearest = (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (from + nearest * along).length() < 1.0 + 1.0e-6
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn the_surface_has_no_crack_and_leaves_out_nothing_in_view(
        longitude in -180.0..180.0,
        latitude in -90.0..90.0,
        exponent in 0.0..8.0,
        pitch in -90.0..0.0,
    ) {
        let height_m = 10.0_f64.powf(exponent);
        check_surface(&view(longitude, latitude, height_m, pitch), &level_ground())?;
        check_surface(&view(longitude, latitude, height_m + 4_000.0, pitch), &mountains())?;
    }
}

#[test]
fn poles_date_line_and_corners_of_the_cube_have_no_crack() {
    for (longitude, latitude) in
        [(0.0, 90.0), (10.0, -90.0), (180.0, 0.0), (-180.0, 65.0), (45.0, 35.264)]
    {
        for height_m in [2.0, 3.0e4, 1.0e7] {
            check_surface(&view(longitude, latitude, height_m, -60.0), &mountains()).unwrap();
        }
    }
}

#[test]
fn the_budget_holds_and_is_used() {
    let sight = |px: u32| {
        let viewport_px = [px * 16 / 9, px];
        GlobeSight::new(&CameraView { viewport_px, ..view(8.0, 47.0, 8_000.0, -15.0) }, 0.0)
    };
    let count = |px: u32| {
        let cover = cover(&mut PatchStore::default(), &level_ground(), &sight(px), &SETTINGS);
        cover.patches.len() * 512
    };
    let [small, large, huge] = [180, 1080, 4320].map(count);
    println!("{small} triangles at 180 lines, {large} at 1080, {huge} at 4320");
    assert!(small < large && large > 100_000 && huge > 140_000, "{small} {large} {huge}");
    assert!(huge <= SETTINGS.most_triangles);
}

#[test]
fn the_mesh_follows_the_curve_to_a_part_of_a_pixel() {
    let ground = level_ground();
    let mut worst_px = 0.0_f64;
    for exponent in 0..=8 {
        for pitch in [-90.0, -30.0, -5.0] {
            let view = CameraView {
                viewport_px: [1920, 1080],
                ..view(-70.0, -33.0, 10.0_f64.powi(exponent), pitch)
            };
            let sight = GlobeSight::new(&view, 0.0);
            let mut store = PatchStore::default();
            for covered in cover(&mut store, &ground, &sight, &SETTINGS).patches {
                let (patch, _) = store.get(covered.id, &ground);
                let vertex = |index: usize| patch.vertices[index].split_place().place();
                for corner in [0, 8 * 17 + 8, 15 * 17 + 15] {
                    let middle = 0.5 * (vertex(corner) + vertex(corner + 18));
                    let off_m = Wgs84::geodetic_from_ecef(middle).height_m.abs();
                    let angle_rad = off_m / middle.distance(sight.eye);
                    worst_px = worst_px.max(angle_rad / view.pixel_angle_rad());
                }
            }
        }
    }
    println!("the mesh lies within {worst_px:.3} px of the ellipsoid");
    assert!(worst_px < 0.25, "{worst_px}");
}

#[test]
fn with_few_patches_allowed_it_comes_to_the_same_cover_bit_by_bit() {
    let ground = mountains();
    let sight = GlobeSight::new(&view(100.0, 30.0, 20_000.0, -20.0), ground.lowest_m());
    let whole = cover(&mut PatchStore::default(), &ground, &sight, &SETTINGS);
    let mut store = PatchStore::default();
    let settings = CoverSettings { most_made: 24, ..SETTINGS };
    let mut frames = 0;
    let last = loop {
        let next = cover(&mut store, &ground, &sight, &settings);
        frames += 1;
        assert!(!next.patches.is_empty() && frames < 100);
        if !next.is_unfinished {
            break next;
        }
    };
    assert!(frames > 5, "{frames}");
    assert_eq!(last.patches, whole.patches);
}

#[test]
fn slopes_are_those_of_the_ground() {
    let mut ground = GlobeGround::new(scheme(), LAYOUT, [-4_000.0, 4_000.0]);
    ground.show(tile(TileId::ROOT));
    ground.exaggerate(3.0);
    let at = Geodetic::from_plate_carree(dvec2(2.1e6, 3.4e6).extend(0.0));
    let id = PatchId::holding(at.normal(), 8);
    let patch = GlobePatch::new(id, &ground);
    for index in [20, 100, 200, 288] {
        let vertex = patch.vertices[index];
        let here = Wgs84::geodetic_from_ecef(vertex.split_place().place());
        let step_m = 0.5 * patch.cell_m;
        let sin_lat = here.latitude_rad.sin();
        let east_m = Wgs84::normal_radius_m(sin_lat) * here.latitude_rad.cos();
        let north_m = Wgs84::meridian_radius_m(sin_lat);
        let at = |east: f64, north: f64| {
            let moved = dvec2(east * step_m / east_m, north * step_m / north_m);
            ground.height_m(here.plate_carree() + moved * PlateCarree::RADIUS_M).unwrap()
        };
        let expected = [at(1.0, 0.0) - at(-1.0, 0.0), at(0.0, 1.0) - at(0.0, -1.0)]
            .map(|rise| rise / (2.0 * step_m));
        let slope = vertex.slope.map(|bits| half::f16::from_bits(bits).to_f64());
        for (found, expected) in slope.into_iter().zip(expected) {
            // A tenth of the steepest there is: samples lie 600 km apart and the surface bends at them.
            assert!((found - expected).abs() < 2.0e-4, "{slope:?} {expected:?}");
        }
        let height_m = 3.0 * ground.height_m(here.plate_carree()).unwrap();
        assert!((here.height_m - height_m).abs() < 0.01, "{} {height_m}", here.height_m);
        assert!((f64::from(vertex.height_m) - height_m).abs() < 0.01);
    }
}

#[test]
fn patches_are_made_anew_where_their_ground_changes_and_only_there() {
    let mut store = PatchStore::default();
    let ground = mountains();
    let serial =
        |normal: DVec3, store: &mut PatchStore| store.get(PatchId::holding(normal, 6), &ground).1;
    let west = Geodetic { longitude_rad: -0.5 * PI, latitude_rad: 0.3, height_m: 0.0 }.normal();
    let east = Geodetic { longitude_rad: 0.5 * PI, latitude_rad: 0.3, height_m: 0.0 }.normal();
    let before = [serial(west, &mut store), serial(east, &mut store)];
    assert_eq!([serial(west, &mut store), serial(east, &mut store)], before);
    store.ground_changed(&[ground.extent(TileId::new(1, 0, 0))]);
    assert_ne!(serial(west, &mut store), before[0]);
    assert_eq!(serial(east, &mut store), before[1]);
}

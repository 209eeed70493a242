//! Ground read back from a file, at its place.

use std::path::Path;

use glam::{DVec2, dvec2};

use super::super::{GlbPlace, SampleGrid, Tin, TinGround, tin_of_grid, write_glb};
use super::height_in_m;
use crate::dataset::{Crs, Shape};
use crate::surface::models::Model;
use crate::tiling::Extent;

const FIRST: DVec2 = dvec2(463_000.25, 6_820_000.5);

/// Rolling ground, 40 by 30 samples 10 m apart.
fn tin() -> Tin {
    let height_m = |index: u32| {
        let (x, y) = (f64::from(index % 40), f64::from(index / 40));
        (600.0 + 40.0 * (0.3 * x).sin() * (0.2 * y).cos()) as f32
    };
    let heights_m = (0..1_200).map(height_m).collect::<Vec<_>>();
    let step = DVec2::splat(10.0);
    let grid = SampleGrid { columns: 40, rows: 30, heights_m: &heights_m, first: FIRST, step };
    tin_of_grid(&grid, 1.0, &[], &mut |_, _| true).unwrap()
}

fn read(metres_per_unit: DVec2) -> Result<TinGround, String> {
    let extent = Extent::new(FIRST - dvec2(0.0, 290.0), FIRST + dvec2(390.0, 0.0));
    let place = GlbPlace { crs: Some("EPSG:32632".to_owned()), metres_per_unit, extent };
    let file = write_glb(&tin(), &place).unwrap();
    TinGround::of_model(&Model::from_bytes(&file, Path::new("ground.glb")).unwrap())
}

#[test]
fn ground_comes_back_to_its_place_and_its_height_is_that_of_the_triangles() {
    let ground = read(DVec2::ONE).unwrap();
    let tin = tin();
    assert_eq!(ground.indices.len(), 3 * tin.triangles.len());
    let crs = |epsg| Crs { epsg: Some(epsg), name: String::new() };
    assert!(ground.check_place(&crs(32_632), Shape::Plane).is_ok());
    assert!(ground.check_place(&crs(3_395), Shape::Plane).is_err());
    assert!(ground.check_place(&crs(32_632), Shape::Globe).is_err());
    for index in 0..2_000_u32 {
        let part = dvec2(super::noise(u64::from(index)), super::noise(u64::from(index + 9_000)));
        let at = FIRST + dvec2(-20.0, -310.0) + part * dvec2(430.0, 330.0);
        let of = |triangle: &[u32; 3]| {
            height_in_m(triangle.map(|index| tin.vertices[index as usize]), at.x, at.y)
        };
        let expected = tin.triangles.iter().find_map(of);
        match (ground.height_m(at), expected) {
            (Some(found), Some(expected)) => assert!((found - expected).abs() < 1e-3, "{at}"),
            (found, expected) => assert_eq!(found.is_some(), expected.is_some(), "{at}"),
        }
    }
    // Slopes are those of the sines as well as so few triangles can tell.
    let off = ground.vertices.iter().map(|vertex| {
        let place = ground.origin + vertex.position_m.as_dvec3();
        let [x, y] = [(place.x - FIRST.x) / 10.0, (FIRST.y - place.y) / 10.0];
        let east = 1.2 * (0.3 * x).cos() * (0.2 * y).cos();
        let north = 0.8 * (0.3 * x).sin() * (0.2 * y).sin();
        (vertex.slope.as_dvec2() - dvec2(east, north)).length()
    });
    let mean = off.sum::<f64>() / ground.vertices.len() as f64;
    assert!(mean < 0.25, "{mean} of slopes up to 1.2");
}

#[test]
fn ground_that_does_not_say_where_it_lies_is_refused() {
    let told = read(dvec2(111_000.0, 50_000.0)).unwrap_err();
    assert!(told.contains("not in metres"), "{told}");
    let told = TinGround::of_model(&Model::default()).unwrap_err();
    assert!(told.contains("does not say where it lies"), "{told}");
}

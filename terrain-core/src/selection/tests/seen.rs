//! The tiles that pixels saw, against a search of all tiles for all pixels.

use glam::dvec2;
use proptest::prelude::{
    Just, ProptestConfig, Strategy, prop, prop_assert, prop_assert_eq, prop_oneof, proptest,
};

use super::cases::{Case, SCHEME, cases, low_over_the_middle, tree};
use super::invariants::finest_at;
use super::{List, all_tiles, distance_m, listed};
use crate::selection::eye_units::EyeUnits;
use crate::selection::ground_units::GroundUnits;
use crate::selection::seen_tiles::SeenTiles;
use crate::selection::{
    CoordinateImage, SeenGround, SelectionConfig, TileList, subdivide, visible_region,
};
use crate::tiling::{FixedPosition, TileId};

const WIDTH: usize = 9;
const HEIGHT: usize = 7;

/// Where pixels look, in parts of the root: rows of ground near each other, some far away, some sky.
fn pixels() -> impl Strategy<Value = Vec<Option<(f64, f64)>>> {
    let row = (0.0..1.0f64, 0.0..1.0f64, prop_oneof![Just(0.001), Just(0.02), Just(0.3)]);
    let kinds = prop::collection::vec(0u8..10, WIDTH * HEIGHT);
    (prop::collection::vec(row, HEIGHT), kinds).prop_map(|(rows, kinds)| {
        let pixel = |(i, kind): (usize, u8)| {
            let (east, north, step) = rows[i / WIDTH];
            let east = (east + step * (i % WIDTH) as f64).min(0.999);
            match kind {
                0 => None,
                1 => Some((1.0 - east, north)),
                _ => Some((east, north)),
            }
        };
        kinds.into_iter().enumerate().map(pixel).collect()
    })
}

fn image_of(case: &Case, pixels: &[Option<(f64, f64)>]) -> CoordinateImage {
    let root = SCHEME.root_extent();
    let origin = case.view.eye.truncate();
    let offset = |&(east, north): &(f64, f64)| {
        (root.min + dvec2(east, north) * root.size_m() - origin).as_vec2().to_array()
    };
    CoordinateImage {
        width: WIDTH as u32,
        height: HEIGHT as u32,
        origin,
        offsets: pixels.iter().map(|p| p.as_ref().map_or([f32::NAN; 2], offset)).collect(),
        frame: 0,
        view: case.view,
    }
}

/// Columns and rows, first and last, of the level's tiles that hold the positions.
fn tiles_round(positions: &[FixedPosition], level: u8) -> Option<[[u32; 2]; 2]> {
    let tiles: Vec<_> = positions.iter().filter_map(|position| position.tile_at(level)).collect();
    let columns = [tiles.iter().map(|t| t.column).min()?, tiles.iter().map(|t| t.column).max()?];
    let rows = [tiles.iter().map(|t| t.row).min()?, tiles.iter().map(|t| t.row).max()?];
    Some([columns, rows])
}

/// Every tile of the tree's levels that a pixel or the ground between neighbours lies on and whose
/// parent is split, tile by tile.
fn seen_by_hand(case: &Case, image: &CoordinateImage) -> List {
    let units = GroundUnits::new(&SCHEME, image.origin);
    let position = |x: usize, y: usize| {
        let offset = *image.offsets.get(y * WIDTH + x).filter(|_| x < WIDTH)?;
        (!offset[0].is_nan()).then(|| units.unit_at(offset))
    };
    let mut grounds = Vec::new();
    for i in 0..WIDTH * HEIGHT {
        let (x, y) = (i % WIDTH, i / WIDTH);
        let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        grounds.push(corners.iter().filter_map(|&(x, y)| position(x, y)).collect::<Vec<_>>());
        grounds.extend(position(x, y).map(|own| vec![own]));
    }
    let is_narrow = |ground: &[FixedPosition], level: u8| {
        tiles_round(ground, level)
            .is_some_and(|ranges| ranges.iter().all(|[first, last]| last - first < 3))
    };
    let split_px = case.config.texel_px * case.view.pixel_angle_rad();
    let is_split =
        |tile: TileId| case.tree.texel_size_m(tile.level) > split_px * distance_m(case, tile);
    let is_seen = |tile: TileId| {
        grounds.iter().any(|ground| {
            let reaches = (1..=tile.level).all(|level| is_narrow(ground, level));
            reaches
                && tiles_round(ground, tile.level).is_some_and(|[columns, rows]| {
                    (columns[0]..=columns[1]).contains(&tile.column)
                        && (rows[0]..=rows[1]).contains(&tile.row)
                })
        })
    };
    let below_root = all_tiles(&case.tree).filter(|tile| tile.level > 0);
    below_root.filter(|tile| tile.parent().is_some_and(is_split) && is_seen(*tile)).collect()
}

fn subdivided(case: &Case, image: &CoordinateImage, is_exact: bool) -> TileList {
    let region = visible_region(image);
    let seen =
        region.as_ref().map(|region| SeenGround { region, image: is_exact.then_some(image) });
    subdivide(&case.tree, seen, &case.view, &case.config)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn seen_is_what_pixels_and_the_ground_between_them_lie_on(case in cases(), pixels in pixels()) {
        let image = image_of(&case, &pixels);
        let eye = EyeUnits::new(&case.tree, case.view.eye, case.config.vertical_exaggeration);
        let split_px = case.config.texel_px * case.view.pixel_angle_rad();
        let below = eye.split_below(&case.tree, split_px);
        let seen = SeenTiles::of_image(&image, &case.tree, &eye, &below).unwrap();
        let by_hand = seen_by_hand(&case, &image);
        for tile in all_tiles(&case.tree).filter(|tile| tile.level > 0) {
            prop_assert_eq!(seen.contains(tile), by_hand.contains(&tile), "{}", tile);
        }
        prop_assert_eq!(seen.len() as usize, by_hand.len());
    }

    #[test]
    fn exactly_the_hidden_tiles_of_the_box_are_left_out_and_no_pixel_loses_detail(
        case in cases(),
        pixels in pixels(),
    ) {
        let image = image_of(&case, &pixels);
        let (exact, boxed) = (subdivided(&case, &image, true), subdivided(&case, &image, false));
        prop_assert_eq!((boxed.hidden(), exact.len() + exact.hidden()), (0, boxed.len()));
        let (exact, boxed) = (listed(&exact), listed(&boxed));
        prop_assert!(exact.is_subset(&boxed));
        for (east, north) in pixels.into_iter().flatten() {
            let root = SCHEME.root_extent();
            let leaf = SCHEME
                .tile_at(case.tree.finest_level(), root.min + dvec2(east, north) * root.size_m());
            let Some(leaf) = leaf else { continue };
            prop_assert_eq!(finest_at(&exact, leaf), finest_at(&boxed, leaf), "{}", leaf);
        }
    }
}

#[test]
fn where_too_many_tiles_were_seen_all_of_the_box_counts() {
    let mut case = low_over_the_middle(tree(1, 8, None, 130), SelectionConfig::default());
    // Every tile is split; the finest are 128 x 128.
    case.config.texel_px = 1.0e-9;
    let root = SCHEME.root_extent();
    // A pixel a tile, but for a strip in the middle that no pixel sees.
    let image = |side: u32, strip: u32| {
        let offset = |i: u32| {
            let beyond = if i % side < side / 2 { 0 } else { strip };
            let tile = dvec2(f64::from(i % side + beyond), f64::from(i / side));
            let place = root.min + (tile + 0.5) / 128.0 * root.size_m();
            (place - case.view.eye.truncate()).as_vec2().to_array()
        };
        let offsets = (0..side * side).map(offset).collect();
        CoordinateImage { width: side, height: side, offsets, ..image_of(&case, &[]) }
    };
    let hidden = |image: &CoordinateImage| subdivided(&case, image, true).hidden();
    assert!(hidden(&image(60, 40)) > 60 * 35);
    // The same places in finer and finer rows of pixels are the same tiles.
    let eye = EyeUnits::new(&case.tree, case.view.eye, 1.0);
    let deep = super::tree(1, 10, None, 130);
    let below = eye.split_below(&deep, 0.0);
    let many = image(128, 0);
    let seen = SeenTiles::of_image(&many, &deep, &eye, &below);
    assert!(seen.is_none(), "512 x 512 tiles and more are too many to keep");
}

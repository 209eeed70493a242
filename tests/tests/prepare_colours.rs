//! Pictures through the whole of preparing and back, and how they lie on the heights.

#![expect(clippy::unwrap_used, reason = "a case fails by panicking")]

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use terrain_core::dataset::{ColourEncoding, ColourFormat, Dataset, TileSource};
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::tiling::TileId;
use terrain_tests::RasterFixture;

const ORIGIN: [f64; 2] = [432_000.0, 6_850_000.0];

fn open(request: &PrepareRequest) -> Dataset {
    prepare(request, &NoProgress, &AtomicBool::new(false)).unwrap();
    Dataset::open(&request.out).unwrap()
}

/// Flat heights of 64 x 64 cells of 30 m, in tiles of 32, and colour tiles of 96: at the level of the
/// heights a colour texel is 10 m.
fn request(folder: &Path) -> PrepareRequest {
    let heights = RasterFixture::utm([64, 64], ORIGIN, 30.0);
    heights.write_i16(&folder.join("dem.tif"), &[7; 64 * 64]).unwrap();
    PrepareRequest {
        height_tile_texels: 32,
        colour_tile_texels: 96,
        colour_encoding: ColourEncoding::Rgba8,
        ..PrepareRequest::new(
            vec![folder.join("dem.tif")],
            vec![folder.join("dom.tif")],
            folder.join("out"),
        )
    }
}

/// One level as a whole, without gutters; absent tiles are clear.
fn level_of(dataset: &Dataset, level: u8) -> (Vec<[u8; 4]>, usize) {
    let layout = dataset.manifest().colours.as_ref().unwrap().layout;
    let (tile_size, gutter) = (layout.tile_size_texels as usize, layout.gutter_texels as usize);
    let width = tile_size << level;
    let mut texels = vec![[0; 4]; width * width];
    for id in dataset.colours_present().iter().filter(|tile| tile.level == level) {
        let tile = dataset.load_colours(id).unwrap().tile;
        assert_eq!(tile.format, ColourFormat::Rgba8);
        let stored = tile.stored_size_texels as usize;
        for y in 0..tile_size {
            for x in 0..tile_size {
                let from = ((y + gutter) * stored + x + gutter) * 4;
                let to =
                    (id.row as usize * tile_size + y) * width + id.column as usize * tile_size + x;
                texels[to].copy_from_slice(&tile.data[from..from + 4]);
            }
        }
    }
    (texels, width)
}

#[test]
fn a_picture_at_the_texels_own_scale_is_kept_and_cut_to_the_heights() {
    let folder = tempfile::tempdir().unwrap();
    // Texels of 10 m: 20 to the west of the heights' corner, 30 to the north, reaching far beyond.
    let (width, height) = (300_u32, 280_u32);
    let colour = |x: u32, y: u32| [(x % 251) as u8, (y % 241) as u8, ((x * y) % 239) as u8];
    let rgb: Vec<u8> =
        (0..width * height).flat_map(|index| colour(index % width, index / width)).collect();
    let tie = [ORIGIN[0] - 200.0, ORIGIN[1] + 300.0];
    RasterFixture::utm([width, height], tie, 10.0)
        .write_rgb(&folder.path().join("dom.tif"), &rgb)
        .unwrap();
    let dataset = open(&request(folder.path()));
    let layout = dataset.manifest().colours.as_ref().unwrap().layout;
    assert_eq!(layout.level_count, 2);
    let (texels, stride) = level_of(&dataset, 1);
    for y in 0..192 {
        for x in 0..192 {
            let [r, g, b] = colour(x + 20, y + 30);
            let texel = texels[y as usize * stride + x as usize];
            assert_eq!(texel, [r, g, b, 255], "texel {x} {y}");
        }
    }
    // Gutters repeat the neighbours, and end with the heights.
    let east = dataset.load_colours(TileId::new(1, 0, 1)).unwrap().tile;
    let gutter_texel = |x: usize, y: usize| {
        let at = (y * east.stored_size_texels as usize + x) * 4;
        [east.data[at], east.data[at + 1], east.data[at + 2], east.data[at + 3]]
    };
    let [r, g, b] = colour(20 + 95, 30 + 6);
    assert_eq!(gutter_texel(3, 4 + 6), [r, g, b, 255]);
    assert_eq!(gutter_texel(4 + 96, 4 + 6)[3], 0);
}

#[test]
fn a_picture_with_coverage_keeps_it_and_the_colours_under_it() {
    let folder = tempfile::tempdir().unwrap();
    // Texels of 10 m, as many as the heights' level has; every third column is covered in part.
    // Colours weigh by their coverage: of what is hardly covered little is left.
    let side = 192_u32;
    let texel = |index: u32| {
        let (x, y) = (index % side, index / side);
        let coverage = if x.is_multiple_of(3) { 128 + (y % 128) as u8 } else { 255 };
        [(x % 251) as u8, (y % 241) as u8, ((x * y) % 239) as u8, coverage]
    };
    let rgba = (0..side * side).map(texel).collect::<Vec<_>>();
    RasterFixture::utm([side; 2], ORIGIN, 10.0)
        .write_rgba(&folder.path().join("dom.tif"), &rgba)
        .unwrap();
    let dataset = open(&request(folder.path()));
    let (texels, stride) = level_of(&dataset, 1);
    for (index, expected) in rgba.iter().enumerate() {
        let (x, y) = (index % side as usize, index / side as usize);
        let texel = texels[y * stride + x];
        let off = (0..4).map(|channel| texel[channel].abs_diff(expected[channel])).max().unwrap();
        let most = u8::from(expected[3] < 255);
        assert!(off <= most && texel[3] == expected[3], "{x} {y}: {texel:?}, not {expected:?}");
    }
}

#[test]
fn coarser_levels_average_light_and_coverage() {
    let folder = tempfile::tempdir().unwrap();
    // Covers a part only: 61 x 45 texels of 10 m from the middle of the heights.
    let (width, height) = (61_u32, 45_u32);
    let grey = |x: u32, y: u32| if (x / 3 + y / 5).is_multiple_of(2) { 20 } else { 250 };
    let rgb: Vec<u8> =
        (0..width * height).flat_map(|index| [grey(index % width, index / width); 3]).collect();
    let tie = [ORIGIN[0] + 510.0, ORIGIN[1] - 430.0];
    RasterFixture::utm([width, height], tie, 10.0)
        .write_rgb(&folder.path().join("dom.tif"), &rgb)
        .unwrap();
    let dataset = open(&request(folder.path()));
    let (coarse, stride) = level_of(&dataset, 0);
    let linear = |code: f64| -> f64 {
        let part: f64 = code / 255.0;
        if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
    };
    let encoded = |light: f64| -> f64 {
        255.0
            * if light <= 0.003_130_8 {
                12.92 * light
            } else {
                1.055 * light.powf(1.0 / 2.4) - 0.055
            }
    };
    for y in 0..96_u32 {
        for x in 0..96_u32 {
            let held: Vec<f64> = [(0, 0), (1, 0), (0, 1), (1, 1)]
                .iter()
                .filter_map(|(dx, dy)| {
                    let (x, y) = ((2 * x + dx).checked_sub(51)?, (2 * y + dy).checked_sub(43)?);
                    (x < width && y < height).then(|| linear(f64::from(grey(x, y))))
                })
                .collect();
            let [r, _, _, coverage] = coarse[y as usize * stride + x as usize];
            let want_coverage = 255.0 * held.len() as f64 / 4.0;
            assert!((f64::from(coverage) - want_coverage).abs() <= 1.0, "{x} {y} {coverage}");
            if !held.is_empty() {
                let want = encoded(held.iter().sum::<f64>() / held.len() as f64);
                assert!((f64::from(r) - want).abs() <= 1.0, "{x} {y}: {r} {want}");
            }
        }
    }
}

#[test]
fn uncovered_tiles_are_not_stored() {
    let folder = tempfile::tempdir().unwrap();
    let tie = [ORIGIN[0] + 100.0, ORIGIN[1] - 100.0];
    RasterFixture::utm([40, 40], tie, 10.0)
        .write_rgb(&folder.path().join("dom.tif"), &[99; 40 * 40 * 3])
        .unwrap();
    let dataset = open(&request(folder.path()));
    let present: Vec<TileId> = dataset.colours_present().iter().collect();
    assert_eq!(present, [TileId::ROOT, TileId::new(1, 0, 0)]);
    assert!(dataset.load_colours(TileId::new(1, 1, 1)).is_err());
}

/// Lakes are flat, and the map shows where they are: where a cell of the heights lies wholly under
/// the map's lake colour, its slope is next to nothing. Shifted by a cell, it is not.
#[test]
fn the_map_of_jotunheimen_lies_where_its_heights_are() {
    let data = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let heights = data.join("jotunheimen_dem_512.tif");
    if !heights.is_file() {
        println!("skipped: {} is not here", heights.display());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let request = PrepareRequest {
        colour_encoding: ColourEncoding::Rgba8,
        ..PrepareRequest::new(
            vec![heights],
            vec![data.join("jotunheimen_map_4096.jpg")],
            folder.path().join("out"),
        )
    };
    let dataset = open(&request);
    // Level 2 holds the heights' own cells of 117 m, level 3 colours at a sixth of that.
    let (colours, width) = level_of(&dataset, 3);
    let is_lake = |x: i64, y: i64| {
        (0..36).all(|part| {
            let (px, py) = (6 * x + part % 6, 6 * y + part / 6);
            let inside = (0..width as i64).contains(&px) && (0..width as i64).contains(&py);
            let near = |texel: [u8; 4]| {
                [180, 211, 231].iter().zip(texel).all(|(a, b)| b.abs_diff(*a) < 16)
            };
            inside && near(colours[(py * width as i64 + px) as usize])
        })
    };
    let mean_slope = |shift: (i64, i64)| {
        let (mut sum, mut count) = (0.0, 0);
        for id in dataset.heights_present().iter().filter(|tile| tile.level == 2) {
            let tile = dataset.load_heights(id).unwrap().tile;
            let height = |x: i64, y: i64| {
                let index = (y + 4) * i64::from(tile.stored_size_texels) + x + 4;
                tile.samples.height_m(index as usize).map_or(f64::NAN, f64::from)
            };
            for index in 0..128 * 128_i64 {
                let (x, y) = (index % 128, index / 128);
                let (column, row) = (128 * i64::from(id.column) + x, 128 * i64::from(id.row) + y);
                let slope_x = (height(x + 1, y) - height(x - 1, y)) / 234.375;
                let slope_y = (height(x, y + 1) - height(x, y - 1)) / 234.375;
                let slope = slope_x.hypot(slope_y);
                if !slope.is_nan() && is_lake(column + shift.0, row + shift.1) {
                    sum += slope;
                    count += 1;
                }
            }
        }
        assert!(count > 5_000, "only {count} cells of lake");
        sum / f64::from(count)
    };
    let fitting = mean_slope((0, 0));
    assert!(fitting < 0.006, "mean slope under lakes {fitting}");
    for shift in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
        let shifted = mean_slope(shift);
        assert!(shifted > 2.0 * fitting, "shift {shift:?}: {shifted}, without {fitting}");
    }
}

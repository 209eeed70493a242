use std::collections::HashMap;

use super::*;
use crate::dataset::{
    ColourEncoding, ColourFormat, Crs, HeightEncoding, HeightLayer, HeightRange, HeightRanges,
    Shape,
};
use crate::geodesy::PlateCarree;
use crate::srgb::LINEAR_FROM_CODE;
use crate::synth::noise::hash;

const TILE: u32 = 32;
const REAL_LEVELS: u8 = 3;

/// Imagery of noise on the northern half, of one colour on the southern. Gutters hold nonsense, which nobody may read:
/// every texel is to come from its own tile.
struct Imagery {
    manifest: Manifest,
    present: TileSet,
    encoding: ColourEncoding,
}

fn own_colour(x: i64, y: i64) -> [u8; 4] {
    const ROUGH_ROWS: i64 = 32;
    if y >= ROUGH_ROWS {
        return [20, 60, 120, 255];
    }
    let bits = hash(x as i32, y as i32, 5);
    [60 + (bits & 63) as u8, 90 + (bits >> 8 & 63) as u8, 40 + (bits >> 16 & 31) as u8, 255]
}

impl Imagery {
    fn new(shape: Shape, encoding: ColourEncoding) -> Self {
        let layout =
            LayerLayout { tile_size_texels: TILE, gutter_texels: 4, level_count: REAL_LEVELS };
        let range = HeightRange { min_m: 0.0, max_m: 0.0 };
        let format = match encoding {
            ColourEncoding::Rgba8 => ColourFormat::Rgba8,
            _ => ColourFormat::Bc7,
        };
        let mut present = TileSet::new();
        for level in 0..REAL_LEVELS {
            let rows = if shape == Shape::Globe { (1 << level) / 2 } else { 1 << level };
            for row in 0..rows.max(1) {
                present.insert_run(level, row, (0, (1 << level) - 1));
            }
        }
        let manifest = Manifest {
            version: Manifest::VERSION,
            crs: Crs { epsg: None, name: "local".to_owned() },
            shape,
            scheme: PlateCarree::scheme(),
            data_extent: PlateCarree::extent(),
            heights: HeightLayer {
                layout,
                encoding: HeightEncoding::Float,
                step_m: 1.0,
                has_voids: false,
                range,
                ranges: HeightRanges { levels: Vec::new() },
            },
            colours: Some(ColourLayer { layout, encoding, format }),
            sources: Vec::new(),
            notes: Vec::new(),
        };
        Self { manifest, present, encoding }
    }

    fn detailed(self, levels: u8, seed: u32) -> DetailedSource {
        DetailedSource::new(Arc::new(self), levels, seed).unwrap()
    }
}

impl TileSource for Imagery {
    fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    fn heights_present(&self) -> &TileSet {
        &self.present
    }

    fn colours_present(&self) -> &TileSet {
        &self.present
    }

    fn load_heights(&self, tile: TileId) -> Result<Loaded<HeightTile>, LoadError> {
        Err(LoadError::Absent { path: PathBuf::new(), tile })
    }

    fn load_colours(&self, tile: TileId) -> Result<Loaded<ColourTile>, LoadError> {
        let stored = i64::from(TILE) + 8;
        let texel = |index: i64| {
            let (x, y) = (index % stored - 4, index / stored - 4);
            let inside = (0..i64::from(TILE)).contains(&x) && (0..i64::from(TILE)).contains(&y);
            let corner = [tile.column, tile.row].map(|index| i64::from(index * TILE));
            if inside { own_colour(corner[0] + x, corner[1] + y) } else { [255, 0, 255, 255] }
        };
        let rgba: Vec<u8> = (0..stored * stored).flat_map(texel).collect();
        let payload = encode_colours(&rgba, stored as u32, self.encoding).unwrap();
        let format = self.manifest.colours.as_ref().unwrap().format;
        let decoded = decode_colours(&payload, tile, stored as u32, format).unwrap();
        Ok(Loaded { tile: decoded, disk_bytes: payload.len() as u64 })
    }
}

fn whole(side: i64, shape: Shape) -> TexelWindow {
    let height = if shape == Shape::Globe { side / 2 } else { side };
    TexelWindow { column: 0, row: 0, width: side as usize, height: height as usize }
}

#[test]
fn the_mean_of_four_texels_is_the_texel_above_them() {
    for shape in [Shape::Globe, Shape::Plane] {
        let source = Imagery::new(shape, ColourEncoding::Rgba8).detailed(7, 1);
        let side = i64::from(TILE) << (REAL_LEVELS - 1);
        let (mut above, _) = source.patch(whole(side, shape), 0).unwrap();
        for (index, texel) in above.texels.iter().enumerate() {
            let [r, g, b, _] = own_colour(index as i64 % side, index as i64 / side);
            let light = [r, g, b].map(|code| LINEAR_FROM_CODE[usize::from(code)]);
            assert_eq!(texel[..3], light);
        }
        for depth in 1..=3 {
            let (patch, _) = source.patch(whole(side << depth, shape), depth).unwrap();
            let width = above.window.width;
            for (index, texel) in above.texels.iter().enumerate() {
                let at = 2 * (index / width) * 2 * width + 2 * (index % width);
                let four = [at, at + 1, at + 2 * width, at + 2 * width + 1];
                for (part, value) in texel.iter().enumerate().take(3) {
                    let mean = four.iter().map(|at| patch.texels[*at][part]).sum::<f32>() / 4.0;
                    assert!((mean - value).abs() < 1.0e-6, "{shape:?} {depth} {index}");
                }
            }
            above = patch;
        }
    }
}

#[test]
fn gutters_are_the_neighbours_texels_round_the_globe_and_over_its_poles() {
    // Blocks of colours lose something, so that gutters of the real tiles would not do.
    for (shape, encoding) in [
        (Shape::Globe, ColourEncoding::Rgba8),
        (Shape::Globe, ColourEncoding::Bc7),
        (Shape::Plane, ColourEncoding::Bc7),
    ] {
        let source = Imagery::new(shape, encoding).detailed(REAL_LEVELS + 2, 9);
        for level in REAL_LEVELS..REAL_LEVELS + 2 {
            let side = i64::from(TILE) << level;
            let grid = TexelGrid { shape, side };
            let mut texels = HashMap::new();
            let tiles = || source.present.iter().filter(|tile| tile.level == level);
            let mut gutters = Vec::new();
            for tile in tiles() {
                let (window, rgba) = (source.window(tile), source.rgba(tile).unwrap());
                for (index, texel) in rgba.as_chunks::<4>().0.iter().enumerate() {
                    let column = window.column + (index % window.width) as i64;
                    let row = window.row + (index / window.width) as i64;
                    let own = (column.div_euclid(32), row.div_euclid(32));
                    if own == (i64::from(tile.column), i64::from(tile.row)) {
                        texels.insert((column, row), *texel);
                    } else {
                        gutters.push((column, row, *texel));
                    }
                }
            }
            let mut compared = 0;
            for (column, row, texel) in gutters {
                let is_beyond = !(0..side).contains(&column) || !(0..side).contains(&row);
                if shape == Shape::Plane && is_beyond {
                    continue;
                }
                assert_eq!(texels[&grid.own(column, row)], texel, "{shape:?} {column} {row}");
                compared += 1;
            }
            assert!(compared > 1_000);
        }
    }
}

#[test]
fn rough_ground_gets_detail_of_every_octave_and_smooth_ground_none() {
    let source = Imagery::new(Shape::Globe, ColourEncoding::Rgba8).detailed(8, 3);
    for depth in 1..=4_u8 {
        let side = i64::from(TILE) << (REAL_LEVELS - 1 + depth);
        let band = |first_real_row: i64| {
            let row = first_real_row << depth;
            let window = TexelWindow { column: 0, row, width: side as usize, height: 16 };
            let (patch, _) = source.patch(window, depth).unwrap();
            let light = |index: usize| f64::from(patch.texels[index][1]);
            // What four texels under one differ by is this octave's own.
            let quads = (0..8).flat_map(|row| {
                (0..side as usize / 2).map(move |column| 4 * row * (side as usize / 2) + 2 * column)
            });
            let spread = quads.map(|at| (light(at) - light(at + 1)).powi(2)).sum::<f64>();
            (spread / (8.0 * side as f64 / 2.0)).sqrt()
        };
        let (rough, smooth) = (band(12), band(44));
        println!("{depth} levels down: {rough:.4} on rough ground, {smooth:.6} on smooth");
        assert!(rough > 0.004, "{depth}: {rough}");
        assert_eq!(smooth, 0.0);
    }
}

#[test]
fn a_tile_is_always_the_same_and_depends_on_the_seed() {
    let tile = TileId::new(6, 9, 63);
    let source = Imagery::new(Shape::Globe, ColourEncoding::Bc7).detailed(7, 1);
    let first = source.load_colours(tile).unwrap();
    assert!(first.disk_bytes > 0 && first.tile.format == ColourFormat::Bc7);
    for column in 0..40 {
        source.load_colours(TileId::new(5, 3, column % 32)).unwrap();
    }
    assert_eq!(source.load_colours(tile).unwrap(), first);
    let other = Imagery::new(Shape::Globe, ColourEncoding::Bc7).detailed(7, 2);
    assert_ne!(other.load_colours(tile).unwrap().tile.data, first.tile.data);
}

#[test]
fn real_levels_and_real_gaps_stay() {
    let mut imagery = Imagery::new(Shape::Plane, ColourEncoding::Rgba8);
    let hole = TileId::new(2, 1, 1);
    imagery.present = imagery.present.iter().filter(|tile| *tile != hole).collect();
    let real = imagery.load_colours(TileId::new(2, 0, 1)).unwrap();
    let source = imagery.detailed(5, 1);
    assert_eq!(source.load_colours(TileId::new(2, 0, 1)).unwrap(), real);
    assert_eq!(source.manifest().colours.as_ref().unwrap().layout.level_count, 5);
    let is_in_hole = |tile: TileId| hole.covers(tile);
    for level in 3..5 {
        for row in 0..1 << level {
            for column in 0..1 << level {
                let tile = TileId::new(level, row, column);
                assert_eq!(source.present.contains(tile), !is_in_hole(tile), "{tile}");
            }
        }
    }
    let lost = source.load_colours(TileId::new(3, 2, 2)).unwrap_err();
    assert!(matches!(lost, LoadError::Absent { .. }));
    // Beside the hole: covered inside, not beyond, and no darker for it.
    let tile = source.load_colours(TileId::new(3, 2, 1)).unwrap().tile;
    let texel = |x: usize| &tile.data[(20 * 40 + x) * 4..][..4];
    assert_eq!(texel(36)[3], 0);
    assert_eq!(texel(35), [20, 60, 120, 255]);
}

#[test]
fn what_cannot_be_continued_is_refused() {
    let refused = |levels, change: fn(&mut Imagery)| {
        let mut imagery = Imagery::new(Shape::Globe, ColourEncoding::Rgba8);
        change(&mut imagery);
        DetailedSource::new(Arc::new(imagery), levels, 0).err().unwrap()
    };
    assert_eq!(refused(9, |imagery| imagery.manifest.colours = None), DetailError::NoImagery);
    for levels in [0, REAL_LEVELS, DetailedSource::MOST_LEVELS + 1] {
        let error = refused(levels, |_| {});
        assert_eq!(error, DetailError::Levels { asked: levels, real: REAL_LEVELS });
    }
}

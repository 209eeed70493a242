use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use std::time::Duration;

use glam::{DVec2, dvec2};
use proptest::prelude::*;

use super::*;
use crate::dataset::{LoadError, Loaded};
use crate::residency::Loading;
use crate::selection::LayerTree;
use crate::tiling::{LayerLayout, TileId, TilingScheme};

const LAYOUT: LayerLayout = LayerLayout { tile_size_texels: 32, gutter_texels: 4, level_count: 5 };
const CLIP: u32 = 64;
const SCHEME: TilingScheme =
    TilingScheme { origin: DVec2::new(1_000.0, 9_000.0), root_size_m: 512.0 };

/// A number no two texels share.
fn texel_value(level: u8, column: u32, row: u32) -> u64 {
    (u64::from(level) << 48) | (u64::from(row) << 24) | u64::from(column)
}

/// A tile as its texels' values, gutter counted; beyond the level whatever the numbers wrap to.
fn tile_values(tile: TileId) -> Vec<u64> {
    let (size, gutter) = (LAYOUT.tile_size_texels, LAYOUT.gutter_texels);
    let stored = LAYOUT.stored_size_texels();
    let at = |tile: u32, index: u32| (tile * size + index).wrapping_sub(gutter);
    (0..stored * stored)
        .map(|index| {
            let (column, row) = (at(tile.column, index % stored), at(tile.row, index / stored));
            texel_value(tile.level, column, row)
        })
        .collect()
}

/// The textures of all levels as plain arrays, and what has been written to them.
struct Textures {
    levels: Vec<Vec<Option<u64>>>,
    written: u64,
}

impl Textures {
    fn new() -> Self {
        let empty = vec![None; (CLIP * CLIP) as usize];
        Self { levels: vec![empty; usize::from(LAYOUT.level_count)], written: 0 }
    }

    fn write(&mut self, strip: &ClipStrip, tile: impl Fn(TileId) -> Option<Vec<u64>>) {
        let stored = LAYOUT.stored_size_texels();
        for piece in pieces(&strip.rect, &LAYOUT, strip.level, CLIP) {
            let values = tile(piece.tile).expect("a strip's tiles are in memory");
            for row in 0..piece.size[1] {
                for column in 0..piece.size[0] {
                    let from = (piece.source[1] + row) * stored + piece.source[0] + column;
                    let to = (piece.target[1] + row) * CLIP + piece.target[0] + column;
                    self.levels[usize::from(strip.level)][to as usize] =
                        Some(values[from as usize]);
                    self.written += 1;
                }
            }
        }
    }

    /// Whether every texel of the rectangle is the source's.
    fn holds(&self, level: u8, rect: &TexelRect) -> bool {
        (rect.north..rect.south).all(|row| {
            (rect.west..rect.east).all(|column| {
                let place = (row % CLIP) * CLIP + column % CLIP;
                let held = self.levels[usize::from(level)][place as usize];
                held == Some(texel_value(level, column, row))
            })
        })
    }
}

fn texel_in_root(level: u8) -> impl Strategy<Value = [f64; 2]> {
    let size = f64::from(level_size_texels(&LAYOUT, level));
    let near = 0.4 * size..0.6 * size;
    let any = -1.5 * size..2.5 * size;
    prop_oneof![
        (near.clone(), near).prop_map(|(x, y)| [x, y]),
        (any.clone(), any).prop_map(|(x, y)| [x, y])
    ]
}

proptest! {
    #[test]
    fn a_window_lies_in_the_level_with_the_eye_near_its_middle(
        (level, eye) in (0u8..5).prop_flat_map(|level| (Just(level), texel_in_root(level))),
    ) {
        let size = level_size_texels(&LAYOUT, level);
        let window = window_around(eye, size, CLIP);
        prop_assert!(window.east <= size && window.south <= size);
        prop_assert_eq!([window.width(), window.height()], [CLIP.min(size); 2]);
        let step = WINDOW_STEP_TEXELS;
        prop_assert!(window.west.is_multiple_of(step) && window.north.is_multiple_of(step));
        let half = f64::from(CLIP / 2);
        if eye.iter().all(|&at| at >= half && at <= f64::from(size) - half) {
            let middle = f64::from(window.west) + half;
            prop_assert!((middle - eye[0]).abs() <= f64::from(step / 2), "{window:?} for {eye:?}");
        }
    }

    /// The two textures of a level that has moved and of one that has not are the same, texel by texel,
    /// and nothing was sent twice.
    #[test]
    fn after_any_moves_every_texel_is_the_source_s_and_only_new_ones_were_sent(
        moves in prop::collection::vec(texel_in_root(4), 1..12),
        most_texels in prop_oneof![Just(64u64), Just(1_000), Just(u64::MAX)],
    ) {
        let level = 4;
        let size = level_size_texels(&LAYOUT, level);
        let mut fill = LevelFill::default();
        let mut textures = Textures::new();
        for eye in moves {
            let before = fill.filled();
            fill.move_to(window_around(eye, size, CLIP), eye);
            let kept = fill.filled();
            let shared = before.intersection(&fill.window());
            prop_assert!(kept == shared || kept.is_empty(), "all that is shared, or a new beginning");
            let sent_before = textures.written;
            while let Some(rect) = fill.next_strip(LAYOUT.tile_size_texels, most_texels, |_| true) {
                prop_assert!(!rect.is_empty() && fill.window().covers(&rect));
                let tiles = tiles_under(&rect, &LAYOUT, level).count() as u32;
                prop_assert!(tiles <= CLIP / LAYOUT.tile_size_texels + 1, "one row of tiles");
                fill.take(&rect);
                textures.write(&ClipStrip { level, rect, filled: fill.filled() }, |tile| Some(tile_values(tile)));
            }
            prop_assert!(fill.is_complete());
            prop_assert!(textures.holds(level, &fill.window()));
            prop_assert_eq!(textures.written - sent_before, fill.window().area() - kept.area());
        }
    }

    #[test]
    fn pieces_tile_the_rectangle_once_and_never_cross_a_border(
        west in 0u32..400, north in 0u32..400, width in 1u32..64, height in 1u32..64,
    ) {
        let rect = TexelRect::new([west, north], [width, height]);
        let mut seen = HashSet::new();
        for piece in pieces(&rect, &LAYOUT, 4, CLIP) {
            for axis in 0..2 {
                prop_assert!(piece.target[axis] + piece.size[axis] <= CLIP);
                let end = piece.source[axis] + piece.size[axis];
                prop_assert!(piece.source[axis] >= 4 && end <= 4 + LAYOUT.tile_size_texels);
            }
            let column = piece.tile.column * LAYOUT.tile_size_texels + piece.source[0] - 4;
            let row = piece.tile.row * LAYOUT.tile_size_texels + piece.source[1] - 4;
            prop_assert_eq!([column % CLIP, row % CLIP], piece.target);
            for y in row..row + piece.size[1] {
                for x in column..column + piece.size[0] {
                    prop_assert!(rect.holds([x, y]) && seen.insert((x, y)));
                }
            }
        }
        prop_assert_eq!(seen.len() as u64, rect.area());
    }
}

#[test]
fn a_window_that_stands_still_or_turns_asks_for_nothing() {
    let mut fill = LevelFill::default();
    let eye = [212.0, 300.0];
    let window = window_around(eye, 512, CLIP);
    fill.move_to(window, eye);
    while let Some(strip) = fill.next_strip(32, u64::MAX, |_| true) {
        fill.take(&strip);
    }
    // Within a step of the window nothing moves.
    let aside = [eye[0] + 0.9, eye[1] - 0.9];
    fill.move_to(window_around(aside, 512, CLIP), aside);
    assert_eq!((fill.filled(), fill.next_strip(32, u64::MAX, |_| true)), (window, None));
}

#[test]
fn a_step_sends_an_l_of_the_step_s_width() {
    let mut fill = LevelFill::default();
    let eye = [200.0, 200.0];
    fill.move_to(window_around(eye, 512, CLIP), eye);
    while let Some(strip) = fill.next_strip(32, u64::MAX, |_| true) {
        fill.take(&strip);
    }
    let eye = [204.0, 196.0];
    fill.move_to(window_around(eye, 512, CLIP), eye);
    let mut sent = 0;
    while let Some(strip) = fill.next_strip(32, u64::MAX, |_| true) {
        fill.take(&strip);
        sent += strip.area();
    }
    assert_eq!(sent, u64::from(4 * CLIP + 4 * (CLIP - 4)));
}

#[test]
fn what_cannot_be_had_ends_the_level_before_it() {
    let mut fill = LevelFill::default();
    let eye = [100.0, 100.0];
    fill.move_to(window_around(eye, 512, CLIP), eye);
    // Everything east of column 128 is missing.
    let is_ready = |rect: &TexelRect| rect.east <= 128;
    while let Some(strip) = fill.next_strip(32, u64::MAX, is_ready) {
        fill.take(&strip);
    }
    assert_eq!(fill.filled(), TexelRect { east: 128, ..fill.window() });
    assert!(!fill.is_complete());
}

type Values = Vec<u64>;

fn layer(
    absent: &[TileId],
    load: impl Fn(TileId) -> Result<Loaded<Values>, LoadError> + Send + Sync + 'static,
) -> ClipLayer<Values> {
    let present = (0..LAYOUT.level_count)
        .flat_map(|level| {
            let side = 1u32 << level;
            (0..side * side).map(move |index| TileId::new(level, index / side, index % side))
        })
        .filter(|tile| !absent.contains(tile))
        .collect();
    let layer = LayerTree { layout: LAYOUT, present };
    let loading = Loading { threads: 2, delay_frames: 0 };
    let mut layer =
        ClipLayer::new(SCHEME, layer, (CLIP, TileKeeping::Border, 32), loading, Arc::new(load))
            .unwrap();
    layer.supply(TileId::ROOT, tile_values(TileId::ROOT));
    layer
}

fn loaded(tile: TileId) -> Result<Loaded<Values>, LoadError> {
    Ok(Loaded { tile: tile_values(tile), disk_bytes: 100 })
}

/// Runs frames until nothing is missing; returns them.
fn settle(layer: &mut ClipLayer<Values>, textures: &mut Textures, eye: DVec2, budget: u64) -> u32 {
    for frame in 0..1_000 {
        let update = layer.update(eye, 5, budget);
        for strip in &update.strips {
            textures.write(strip, |tile| layer.tile(tile).cloned());
        }
        layer.drop_tiles();
        if layer.missing() == 0 {
            return frame;
        }
        layer.wait(Duration::from_secs(30));
    }
    panic!("it never comes to rest");
}

#[test]
fn a_layer_fills_its_windows_coarsest_first_within_the_budget_and_rests() {
    let mut layer = layer(&[], loaded);
    let mut textures = Textures::new();
    let eye = SCHEME.origin + dvec2(301.0, -222.0);
    let first = layer.update(eye, 5, 0);
    assert_eq!(first.strips.len(), 1, "one strip whatever the budget");
    assert_eq!((first.strips[0].level, first.strips[0].rect.area()), (0, 32 * 32));
    textures.write(&first.strips[0], |tile| layer.tile(tile).cloned());
    settle(&mut layer, &mut textures, eye, 1_000);
    let shown = layer.shown(2);
    assert_eq!(shown.len(), 5);
    for (level, rect) in (0u8..).zip(&shown) {
        assert!(textures.holds(level, rect), "level {level}");
        let side = CLIP.min(level_size_texels(&LAYOUT, level));
        assert_eq!([rect.width(), rect.height()], [side; 2], "level {level}");
    }
    let sent = textures.written;
    assert_eq!(settle(&mut layer, &mut textures, eye, 1_000), 0, "nothing is left to do");
    assert_eq!(textures.written, sent);
    // Tiles wholly in the textures are not kept, those at the windows' borders are.
    assert!(layer.tile_count() > 4 && layer.tile_count() < 40, "{}", layer.tile_count());
    let next = eye + dvec2(3.0, 1.0);
    settle(&mut layer, &mut textures, next, u64::MAX);
    assert!(layer.shown(2).iter().zip(0u8..).all(|(rect, level)| textures.holds(level, rect)));
    assert!(textures.written - sent < sent / 4, "{} after {sent}", textures.written - sent);
}

#[test]
fn a_finer_level_never_shows_beyond_a_coarser_one() {
    let mut layer = layer(&[], |tile| {
        // The second level has a gap that no load ever fills.
        let is_gap = tile == TileId::new(2, 1, 2);
        if is_gap { Err(LoadError::Absent { path: "a".into(), tile }) } else { loaded(tile) }
    });
    let mut textures = Textures::new();
    let eye = SCHEME.origin + dvec2(240.0, -200.0);
    settle(&mut layer, &mut textures, eye, u64::MAX);
    let shown = layer.shown(2);
    let gap = TexelRect::new([64, 32], [32, 32]);
    assert!(shown[2].intersection(&gap).is_empty() && !shown[2].is_empty(), "{shown:?}");
    for pair in shown.windows(2) {
        let [coarser, finer] = pair else { unreachable!() };
        assert!(finer.is_empty() || finer.west >= 2 * coarser.west);
        assert!(finer.east <= 2 * coarser.east && finer.south <= 2 * coarser.south);
    }
}

#[test]
fn ground_without_a_tile_is_no_gap() {
    let absent = TileId::new(4, 6, 9);
    let mut layer = layer(&[absent], loaded);
    let eye = SCHEME.origin + dvec2(310.0, -210.0);
    let mut asked = HashMap::new();
    for _ in 0..1_000 {
        let update = layer.update(eye, 5, u64::MAX);
        for strip in &update.strips {
            for piece in pieces(&strip.rect, &LAYOUT, strip.level, CLIP) {
                *asked.entry(piece.tile).or_insert(0) += 1;
            }
        }
        if layer.missing() == 0 {
            break;
        }
        layer.wait(Duration::from_secs(30));
    }
    assert!(asked.contains_key(&absent), "its texels are written too");
    assert_eq!(layer.shown(2)[4].width(), CLIP);
}

#[test]
fn a_window_covers_the_ground_that_its_texels_size_asks_for() {
    use crate::selection::TileTree;
    let layout =
        |tile_size_texels| LayerLayout { tile_size_texels, gutter_texels: 4, level_count: 7 };
    let tree = |colours: Option<u32>| TileTree {
        scheme: SCHEME,
        data_extent: SCHEME.root_extent(),
        shape: crate::dataset::Shape::Plane,
        heights: LayerTree { layout: layout(128), present: [TileId::ROOT].into_iter().collect() },
        colours: colours.map(|size| LayerTree {
            layout: layout(size),
            present: [TileId::ROOT].into_iter().collect(),
        }),
        height_ranges: crate::dataset::HeightRanges { levels: Vec::new() },
    };
    // 50 degrees over 720 rows.
    let texel_rad = 2.0 * 25.0_f64.to_radians().tan() / 720.0;
    assert_eq!(
        clip_sizes(&tree(Some(384)), texel_rad, 1.0),
        ClipSizes { heights: 1024, colours: 3072 }
    );
    assert_eq!(clip_sizes(&tree(None), texel_rad, 1.0), ClipSizes { heights: 1536, colours: 0 });
    assert_eq!(
        clip_sizes(&tree(Some(384)), 4.0 * texel_rad, 1.0),
        ClipSizes { heights: 256, colours: 768 }
    );
    // Never less than level 0, nor more than the finest level or what memory bears.
    assert_eq!(clip_sizes(&tree(Some(384)), 1.0, 1.0), ClipSizes { heights: 128, colours: 384 });
    assert_eq!(clip_sizes(&tree(Some(128)), 0.0, 1.0), ClipSizes { heights: 1536, colours: 4096 });
    // The level is left out where straight below its parent's texels would do.
    assert!(is_level_wanted(10.0, 19.0 / texel_rad, texel_rad));
    assert!(!is_level_wanted(10.0, 20.0 / texel_rad, texel_rad));
}

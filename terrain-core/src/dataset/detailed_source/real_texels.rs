use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::detail_patch::{DetailPatch, ROUGHNESS};
use super::texel_grid::{TexelGrid, TexelWindow};
use crate::dataset::{LoadError, TileSource};
use crate::srgb::LINEAR_FROM_CODE;
use crate::tiling::{LayerLayout, TileId};

/// Decoded tiles of the finest real level that are kept: those round two places of four tiles each, and some more for
/// loads that overlap. Of 520 texels a side they take 13 MB.
const MOST_KEPT: usize = 12;
/// Times that colours spread by a texel into what no imagery covers: as far as interpolation reaches, twice.
const SPREAD_TEXELS: usize = 4;
/// Light so dark that contrasts in it are of no account.
const DARK: f32 = 0.02;
/// Contrast up to which ground is smooth, be it beside the roughest: the noise of pictures and the rounding of codes.
/// So the sea is smooth up to the shore.
const SMOOTH_CONTRAST: f32 = 0.006;
/// From so much more on it is as rough as what is round it.
const ROUGH_CONTRAST: f32 = 0.02;
/// Contrast that counts at the most: an edge is not rough.
const MOST_CONTRAST: f32 = 0.35;
/// Texels to either side over which the roughness of ground is averaged.
const REACH: usize = 3;

/// Where there is imagery: 255 a texel of a window, 0 where not.
pub struct Coverage {
    window: TexelWindow,
    values: Vec<u8>,
}

impl Coverage {
    /// Of a texel of the window.
    pub fn at(&self, column: i64, row: i64) -> u8 {
        let (x, y) = (column - self.window.column, row - self.window.row);
        self.values[y as usize * self.window.width + x as usize]
    }
}

type Rgba = Arc<Vec<[u8; 4]>>;

/// Texels of the finest real level of a source's imagery, each from the tile that it belongs to.
pub struct RealTexels {
    layout: LayerLayout,
    grid: TexelGrid,
    /// The latest used last.
    kept: Mutex<VecDeque<(TileId, Rgba)>>,
}

impl RealTexels {
    /// Of imagery with this layout.
    pub fn new(layout: LayerLayout, grid: TexelGrid) -> Self {
        Self { layout, grid, kept: Mutex::default() }
    }

    /// All texels of the level.
    pub fn grid(&self) -> TexelGrid {
        self.grid
    }

    /// A window's texels in linear light with their roughness, and their coverage.
    ///
    /// # Errors
    /// Where a tile cannot be loaded.
    pub fn patch(
        &self,
        window: TexelWindow,
        source: &dyn TileSource,
    ) -> Result<(DetailPatch, Coverage), LoadError> {
        let around = window.grown(REACH + 1);
        let mut rgba = self.gather(around, source)?;
        let coverage = Coverage { window, values: inner(around, REACH + 1, |at| rgba[at][3]) };
        spread(&mut rgba, around.width);
        let light = |code: u8| LINEAR_FROM_CODE[usize::from(code)];
        let luminance: Vec<f32> = rgba
            .iter()
            .map(|&[r, g, b, _]| 0.2126 * light(r) + 0.7152 * light(g) + 0.0722 * light(b))
            .collect();
        let contrasts = inner(around, 1, |at| contrast(&luminance, at, around.width));
        let roughness = roughness(&contrasts, window.grown(REACH));
        let mut texels = inner(around, REACH + 1, |at| {
            let [r, g, b, _] = rgba[at];
            [light(r), light(g), light(b), 0.0]
        });
        for (texel, roughness) in texels.iter_mut().zip(roughness) {
            texel[ROUGHNESS] = roughness;
        }
        Ok((DetailPatch { window, texels }, coverage))
    }

    /// sRGB colours and coverage; none of either where there is no tile.
    fn gather(
        &self,
        window: TexelWindow,
        source: &dyn TileSource,
    ) -> Result<Vec<[u8; 4]>, LoadError> {
        let tile_texels = i64::from(self.layout.tile_size_texels);
        let stored = self.layout.stored_size_texels() as usize;
        let gutter = self.layout.gutter_texels as usize;
        let mut found: Option<(TileId, Option<Rgba>)> = None;
        let mut rgba = Vec::with_capacity(window.len());
        for row in window.row..window.row + window.height as i64 {
            for column in window.column..window.column + window.width as i64 {
                let (x, y) = self.grid.own(column, row);
                let id = TileId::new(
                    self.layout.finest_level(),
                    (y / tile_texels) as u32,
                    (x / tile_texels) as u32,
                );
                let tile = match &found {
                    Some((held, tile)) if *held == id => tile,
                    _ => &found.insert((id, self.tile(id, source)?)).1,
                };
                let place = |texel: i64| (texel % tile_texels) as usize + gutter;
                let texel = tile.as_ref().map(|texels| texels[place(y) * stored + place(x)]);
                rgba.push(texel.unwrap_or_default());
            }
        }
        Ok(rgba)
    }

    /// A tile's texels with its gutter, decoded; `None` where there is none.
    fn tile(&self, id: TileId, source: &dyn TileSource) -> Result<Option<Rgba>, LoadError> {
        if !source.colours_present().contains(id) {
            return Ok(None);
        }
        // What a panicking thread left is whole: entries are moved in and out as they are.
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut kept = kept();
            if let Some(entry) = kept.iter().position(|(held, _)| *held == id)
                && let Some(entry) = kept.remove(entry)
            {
                kept.push_back(entry.clone());
                return Ok(Some(entry.1));
            }
        }
        let tile = source.load_colours(id)?.tile.into_rgba8();
        let texels: Rgba = Arc::new(tile.data.as_chunks::<4>().0.to_vec());
        let mut kept = kept();
        if kept.len() >= MOST_KEPT {
            kept.pop_front();
        }
        kept.push_back((id, Arc::clone(&texels)));
        Ok(Some(texels))
    }
}

/// What `value` makes of the indices of a window's texels, those of its margin left out.
fn inner<T>(window: TexelWindow, margin: usize, value: impl Fn(usize) -> T) -> Vec<T> {
    let (width, height) = (window.width, window.height);
    (margin..height - margin)
        .flat_map(|row| (margin..width - margin).map(move |column| row * width + column))
        .map(value)
        .collect()
}

/// How rough the ground is round each texel of a window but those of its margin, of the contrasts in the window: their
/// mean over a square, and 0 where the texel itself has none.
fn roughness(contrasts: &[f32], window: TexelWindow) -> Vec<f32> {
    let width = window.width;
    let counted: Vec<f32> = contrasts.iter().map(|contrast| contrast.min(MOST_CONTRAST)).collect();
    let along = |values: &[f32], at: usize, step: usize| {
        let pairs = (1..=REACH).map(|away| values[at - away * step] + values[at + away * step]);
        pairs.sum::<f32>() + values[at]
    };
    let by_rows = (0..window.len()).map(|at| match at % width {
        column if column < REACH || column + REACH >= width => 0.0,
        _ => along(&counted, at, 1),
    });
    let by_rows: Vec<f32> = by_rows.collect();
    let area = ((2 * REACH + 1) * (2 * REACH + 1)) as f32;
    inner(window, REACH, |at| {
        let own = ((contrasts[at] - SMOOTH_CONTRAST) / ROUGH_CONTRAST).clamp(0.0, 1.0);
        own * along(&by_rows, at, width) / area
    })
}

/// How much the light varies round a texel: its deviation over nine texels, in parts of their mean.
///
/// Sums are taken so that mirrored windows give the same to the bit; so they are in [`roughness`].
fn contrast(luminance: &[f32], at: usize, width: usize) -> f32 {
    let over_nine = |value: &dyn Fn(f32) -> f32| {
        let line = |at: usize| {
            let [west, middle, east] = [at - 1, at, at + 1].map(|at| value(luminance[at]));
            (west + east) + middle
        };
        ((line(at - width) + line(at + width)) + line(at)) / 9.0
    };
    let mean = over_nine(&|light| light);
    let deviation = over_nine(&|light| (light - mean) * (light - mean)).sqrt();
    deviation / (mean + DARK)
}

/// Lends colours to texels that nothing covers, from those beside them.
fn spread(rgba: &mut [[u8; 4]], width: usize) {
    let mut known: Vec<bool> = rgba.iter().map(|texel| texel[3] > 0).collect();
    if known.iter().all(|known| *known) {
        return;
    }
    for _ in 0..SPREAD_TEXELS {
        let before = known.clone();
        for at in (0..rgba.len()).filter(|&at| !before[at]) {
            let column = at % width;
            let beside = [
                (column > 0).then(|| at - 1),
                (column + 1 < width).then(|| at + 1),
                at.checked_sub(width),
                Some(at + width).filter(|&below| below < before.len()),
            ];
            if let Some(from) = beside.into_iter().flatten().find(|&from| before[from]) {
                let [r, g, b, _] = rgba[from];
                rgba[at] = [r, g, b, 0];
                known[at] = true;
            }
        }
    }
}

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::detail_patch::{DetailPatch, DetailTexel, ROUGHNESS};
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
/// Contrast that counts as none: noise and the rounding of codes.
const LEAST_CONTRAST: f32 = 0.012;

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
        let around = window.grown(1);
        let mut rgba = self.gather(around, source)?;
        let coverage = Coverage { window, values: inner(around, |at| rgba[at][3]) };
        spread(&mut rgba, around.width);
        let light = |code: u8| LINEAR_FROM_CODE[usize::from(code)];
        let luminance: Vec<f32> = rgba
            .iter()
            .map(|&[r, g, b, _]| 0.2126 * light(r) + 0.7152 * light(g) + 0.0722 * light(b))
            .collect();
        let texels = inner(around, |at| {
            let [r, g, b, _] = rgba[at];
            let mut texel: DetailTexel = [light(r), light(g), light(b), 0.0];
            texel[ROUGHNESS] = roughness(&luminance, at, around.width);
            texel
        });
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

/// What `value` makes of the indices of a window's texels, its outermost ones left out.
fn inner<T>(window: TexelWindow, value: impl Fn(usize) -> T) -> Vec<T> {
    let (width, height) = (window.width, window.height);
    (1..height - 1)
        .flat_map(|row| (1..width - 1).map(move |column| row * width + column))
        .map(value)
        .collect()
}

/// How much the light varies round a texel: its deviation over nine texels, in parts of their mean.
///
/// Sums are taken so that mirrored windows give the same to the bit.
fn roughness(luminance: &[f32], at: usize, width: usize) -> f32 {
    let over_nine = |value: &dyn Fn(f32) -> f32| {
        let line = |at: usize| {
            let [west, middle, east] = [at - 1, at, at + 1].map(|at| value(luminance[at]));
            (west + east) + middle
        };
        ((line(at - width) + line(at + width)) + line(at)) / 9.0
    };
    let mean = over_nine(&|light| light);
    let deviation = over_nine(&|light| (light - mean) * (light - mean)).sqrt();
    (deviation / (mean + DARK) - LEAST_CONTRAST).clamp(0.0, 1.0)
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

use super::{TexelRect, WINDOW_STEP_TEXELS};

/// One level of a clipmap: the window it is to hold, and the rectangle of it that is there.
///
/// Texels keep their place in the texture whatever the window does, so what two windows share need not
/// be sent again: of a window that has moved a little, a strip along one side or two is missing, in the
/// shape of an L.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LevelFill {
    window: TexelRect,
    filled: TexelRect,
    /// The texel nearest to the eye.
    focus: [u32; 2],
}

/// A side of what is filled that can grow.
struct Side {
    strip: TexelRect,
    /// Texels from the focus to this side: sides near the eye grow first.
    distance: i64,
}

impl LevelFill {
    /// The window the level is to hold.
    pub fn window(&self) -> TexelRect {
        self.window
    }

    /// The part of the window whose texels are in the texture.
    pub fn filled(&self) -> TexelRect {
        self.filled
    }

    /// Whether nothing of the window is missing.
    pub fn is_complete(&self) -> bool {
        self.filled == self.window
    }

    /// The part of the window that is there, from 0 to 1.
    pub fn part(&self) -> f64 {
        self.filled.area() as f64 / self.window.area().max(1) as f64
    }

    /// Moves the window. What both windows hold stays, unless the eye has left it: then the level
    /// begins anew from the eye. `eye` is in texels from the root's corner, anywhere.
    pub fn move_to(&mut self, window: TexelRect, eye: [f64; 2]) {
        self.window = window;
        let nearest = |at: f64, first: u32, end: u32| {
            at.clamp(f64::from(first), f64::from(end.saturating_sub(1).max(first))) as u32
        };
        self.focus = [
            nearest(eye[0], window.west, window.east),
            nearest(eye[1], window.north, window.south),
        ];
        let kept = self.filled.intersection(&window);
        self.filled = if kept.holds(self.focus) { kept } else { TexelRect::default() };
    }

    /// Drops everything: the texture is new.
    pub fn clear(&mut self) {
        self.filled = TexelRect::default();
    }

    /// The texels to send next: the tile's part under the eye where there is nothing yet, else a strip
    /// along the nearest side whose tiles are all there, at most up to the next border of tiles, and
    /// about `most_texels` (at least a step's thickness). `None` where the window is full or what it
    /// lacks is not there.
    ///
    /// `is_ready` is asked whether all tiles under a rectangle are there.
    pub fn next_strip(
        &self,
        tile_size: u32,
        most_texels: u64,
        is_ready: impl Fn(&TexelRect) -> bool,
    ) -> Option<TexelRect> {
        if self.is_complete() {
            return None;
        }
        if self.filled.is_empty() {
            let corner = self.focus.map(|at| at / tile_size * tile_size);
            let seed = TexelRect::new(corner, [tile_size; 2]).intersection(&self.window);
            return Some(seed).filter(|seed| is_ready(seed));
        }
        let mut sides = self.sides(tile_size, most_texels);
        sides.sort_by_key(|side| side.distance);
        sides.into_iter().map(|side| side.strip).find(|strip| is_ready(strip))
    }

    /// Takes a strip of [`Self::next_strip`] as sent.
    pub fn take(&mut self, strip: &TexelRect) {
        if self.filled.is_empty() {
            self.filled = *strip;
            return;
        }
        self.filled = TexelRect {
            west: self.filled.west.min(strip.west),
            north: self.filled.north.min(strip.north),
            east: self.filled.east.max(strip.east),
            south: self.filled.south.max(strip.south),
        };
    }

    /// The strips along the sides where the window reaches farther than what is filled.
    fn sides(&self, tile_size: u32, most_texels: u64) -> Vec<Side> {
        let (filled, window) = (self.filled, self.window);
        let step = u64::from(WINDOW_STEP_TEXELS);
        let thickness = |length: u32| {
            let steps = (most_texels / u64::from(length.max(1)) / step).max(1);
            (steps * step).min(u64::from(u32::MAX)) as u32
        };
        let across = thickness(filled.height());
        let down = thickness(filled.width());
        let before = |at: u32, end: u32, most: u32| {
            let border = (at - 1) / tile_size * tile_size;
            end.max(border).max(at.saturating_sub(most))
        };
        let after = |at: u32, end: u32, most: u32| {
            let border = (at / tile_size + 1) * tile_size;
            end.min(border).min(at.saturating_add(most))
        };
        let mut sides = Vec::with_capacity(4);
        let mut add = |strip, from: u32, to: u32| {
            let distance = i64::from(to) - i64::from(from);
            sides.push(Side { strip, distance });
        };
        let [column, row] = self.focus;
        if filled.west > window.west {
            let west = before(filled.west, window.west, across);
            add(TexelRect { west, east: filled.west, ..filled }, filled.west, column);
        }
        if filled.east < window.east {
            let east = after(filled.east, window.east, across);
            add(TexelRect { west: filled.east, east, ..filled }, column, filled.east);
        }
        if filled.north > window.north {
            let north = before(filled.north, window.north, down);
            add(TexelRect { north, south: filled.north, ..filled }, filled.north, row);
        }
        if filled.south < window.south {
            let south = after(filled.south, window.south, down);
            add(TexelRect { north: filled.south, south, ..filled }, row, filled.south);
        }
        sides
    }
}

//! Which scene is seen where in the window.

use std::ops::Range;
use std::time::Duration;

/// How long flicker shows one scene before it shows the other.
pub const FLICKER: Duration = Duration::from_millis(500);

/// One of the two scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The scene there always is.
    First,
    /// The one it is compared with.
    Second,
}

/// How much of each scene is seen: the first one's columns and, right of them, the second one's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shares {
    /// Columns of the window that show the first scene, pixels.
    pub first_columns: u32,
    /// Width of the window, pixels.
    pub width_px: u32,
}

impl Shares {
    /// The whole window shows this scene.
    pub fn all_of(side: Side, width_px: u32) -> Self {
        let first_columns = if side == Side::First { width_px } else { 0 };
        Self { first_columns, width_px }
    }

    /// The window is divided at this fraction of its width, from 0 to 1.
    pub fn divided_at(fraction: f64, width_px: u32) -> Self {
        let columns = (fraction.clamp(0.0, 1.0) * f64::from(width_px)).round();
        Self { first_columns: (columns as u32).min(width_px), width_px }
    }

    /// The columns that show a scene.
    pub fn columns(&self, side: Side) -> Range<u32> {
        match side {
            Side::First => 0..self.first_columns,
            Side::Second => self.first_columns..self.width_px,
        }
    }

    /// One picture of both: what the window shows. RGBA of 8 bits, both of the window's width and of
    /// the same height.
    pub fn compose(&self, first: &[u8], second: &[u8]) -> Vec<u8> {
        let row_bytes = 4 * self.width_px.max(1) as usize;
        let of_first = 4 * self.first_columns as usize;
        let rows = first.chunks_exact(row_bytes).zip(second.chunks_exact(row_bytes));
        rows.flat_map(|(first, second)| [&first[..of_first], &second[of_first..]].concat())
            .collect()
    }
}

/// Where a divider dragged to column `x_px` lies, as a fraction of the window's width; in the middle
/// of a window without width.
pub fn fraction_at(x_px: f64, width_px: u32) -> f64 {
    if width_px > 0 { (x_px / f64::from(width_px)).clamp(0.0, 1.0) } else { 0.5 }
}

/// The scene that flicker shows so long after it began, and how soon it shows the other.
pub fn flicker(elapsed: Duration) -> (Side, Duration) {
    let period = FLICKER.as_nanos();
    let (turn, into_turn) = (elapsed.as_nanos() / period, elapsed.as_nanos() % period);
    let side = if turn.is_multiple_of(2) { Side::First } else { Side::Second };
    // Less than the period, so it fits.
    (side, FLICKER - Duration::from_nanos(into_turn as u64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_shares_fill_the_window_wherever_it_is_divided() {
        for width_px in [1, 2, 801, 1280] {
            for fraction in [-1.0, 0.0, 0.001, 0.25, 0.5, 0.999, 1.0, 7.0] {
                let shares = Shares::divided_at(fraction, width_px);
                let [first, second] = [Side::First, Side::Second].map(|side| shares.columns(side));
                assert_eq!((first.start, second.end), (0, width_px));
                assert_eq!(first.end, second.start);
                let wanted = fraction.clamp(0.0, 1.0) * f64::from(width_px);
                assert!((f64::from(first.end) - wanted).abs() <= 0.5, "{fraction} of {width_px}");
            }
        }
        assert_eq!(Shares::all_of(Side::First, 640).columns(Side::Second), 640..640);
        assert_eq!(Shares::all_of(Side::Second, 640).columns(Side::Second), 0..640);
    }

    #[test]
    fn a_divider_goes_where_it_is_dragged_and_stays_in_the_window() {
        assert_eq!(fraction_at(200.0, 800), 0.25);
        assert_eq!(fraction_at(-3.0, 800), 0.0);
        assert_eq!(fraction_at(900.0, 800), 1.0);
        assert_eq!(fraction_at(0.0, 0), 0.5);
        let shares = Shares::divided_at(fraction_at(321.0, 1280), 1280);
        assert_eq!(shares.first_columns, 321);
    }

    #[test]
    fn a_composed_picture_has_each_column_from_its_scene() {
        let pixels = |value: u8| [value; 4 * 3 * 2];
        let composed = Shares::divided_at(1.0 / 3.0, 3).compose(&pixels(1), &pixels(2));
        let columns: Vec<u8> = composed.chunks_exact(4).map(|pixel| pixel[0]).collect();
        assert_eq!(columns, [1, 2, 2, 1, 2, 2]);
        for (side, value) in [(Side::First, 1), (Side::Second, 2)] {
            assert_eq!(Shares::all_of(side, 3).compose(&pixels(1), &pixels(2)), pixels(value));
        }
    }

    #[test]
    fn flicker_shows_both_in_turn_and_says_when_it_turns() {
        let ms = Duration::from_millis;
        assert_eq!(flicker(ms(0)), (Side::First, ms(500)));
        assert_eq!(flicker(ms(499)), (Side::First, ms(1)));
        assert_eq!(flicker(ms(500)), (Side::Second, ms(500)));
        assert_eq!(flicker(ms(1_250)), (Side::First, ms(250)));
        let mut elapsed = Duration::ZERO;
        for turn in 0..20 {
            let (side, rest) = flicker(elapsed);
            assert_eq!(side == Side::First, turn % 2 == 0);
            assert!(!rest.is_zero());
            elapsed += rest;
        }
    }
}

/// Time a frame has at 60 frames a second, milliseconds.
pub const FRAME_BUDGET_MS: f64 = 1000.0 / 60.0;

/// Jank-sum in milliseconds: by how much frames of these lengths (milliseconds) exceed
/// [`FRAME_BUDGET_MS`], all together. Frames that end early make up for none that end late.
pub fn jank_sum_ms(frames_ms: impl IntoIterator<Item = f64>) -> f64 {
    frames_ms.into_iter().map(|frame_ms| (frame_ms - FRAME_BUDGET_MS).max(0.0)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_late_counts() {
        let late = [5.0, FRAME_BUDGET_MS, FRAME_BUDGET_MS + 2.0, 116.0 + 2.0 / 3.0];
        assert!((jank_sum_ms(late) - 102.0).abs() < 1.0e-9);
        assert_eq!(jank_sum_ms([]), 0.0);
    }
}

//! How far the work is, on a terminal, once it takes longer than a second.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Shorter work shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bar over a known number of frames.
pub struct FrameProgress {
    bar: ProgressBar,
    started: Instant,
}

impl FrameProgress {
    /// A bar for this many frames; hidden until the work has taken a second.
    pub fn new(frames: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(frames), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{pos} of {len} frames {wide_bar} {eta}") {
            bar.set_style(style);
        }
        Self { bar, started: Instant::now() }
    }

    /// So many frames are done.
    pub fn advance(&self, done: u64) {
        let late = self.started.elapsed() >= PATIENCE;
        if late && self.bar.is_hidden() && std::io::stderr().is_terminal() {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.bar.set_position(done);
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

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
        Self::over(frames, "frames")
    }

    /// A bar for this many of something else.
    pub fn over(count: u64, unit: &str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(count), ProgressDrawTarget::hidden());
        let template = format!("{{pos}} of {{len}} {unit} {{wide_bar}} {{eta}}");
        if let Ok(style) = ProgressStyle::with_template(&template) {
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

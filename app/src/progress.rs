//! How far the work is, on a terminal, once it takes longer than a second.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use terrain_core::Progress;

use crate::output;

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

/// A bar over work in named phases, on a terminal; nothing elsewhere.
pub struct PhaseProgress {
    bar: Option<ProgressBar>,
    phase: Mutex<String>,
    started: Instant,
}

impl PhaseProgress {
    /// A bar that is hidden until the work has taken a second.
    pub fn new() -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::hidden();
            if let Ok(style) =
                ProgressStyle::with_template("{msg:18} {wide_bar} {percent:>3} % {eta}")
            {
                bar.set_style(style);
            }
            bar
        });
        Self { bar, phase: Mutex::new(String::new()), started: Instant::now() }
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Progress for PhaseProgress {
    fn advanced(&self, phase: &str, done: u64, total: u64) {
        let Some(bar) = &self.bar else { return };
        if self.started.elapsed() < PATIENCE {
            return;
        }
        if bar.is_hidden() {
            bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        let mut known = self.phase.lock().unwrap_or_else(PoisonError::into_inner);
        if *known != phase {
            phase.clone_into(&mut known);
            bar.set_message(phase.to_owned());
            bar.reset_eta();
        }
        bar.set_length(total);
        bar.set_position(done);
    }

    fn note(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| output::say(text)),
            None => output::say(text),
        }
    }
}

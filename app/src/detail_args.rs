//! Imagery continued beyond a dataset's finest level.

use std::sync::Arc;

use clap::Args;
use terrain_core::dataset::{DetailedSource, TileSource};

/// What the detail is made of; always the same, so that pictures are.
const SEED: u32 = 1;

/// How far imagery is continued.
#[derive(Args, Clone, Copy, Debug)]
pub struct DetailArgs {
    /// Continue the imagery to so many levels in all, with detail made up tile by tile: over a globe, 10 levels of
    /// tiles of 512 texels are 262144 x 131072 texels
    #[arg(long, value_name = "LEVELS")]
    detail: Option<u8>,
}

impl DetailArgs {
    /// The source, its imagery continued as far as asked for.
    ///
    /// # Errors
    /// Where it has none, or as many levels already.
    pub fn continued(self, source: Arc<dyn TileSource>) -> anyhow::Result<Arc<dyn TileSource>> {
        Ok(match self.detail {
            None => source,
            Some(levels) => Arc::new(DetailedSource::new(source, levels, SEED)?),
        })
    }
}

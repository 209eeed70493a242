use std::sync::atomic::{AtomicBool, Ordering};

use super::PrepareError;
use super::resample::LayerGrid;
use crate::progress::Progress;

/// What all phases share: whom to tell, and whether to stop.
pub struct Run<'a> {
    /// Whom to tell.
    pub progress: &'a dyn Progress,
    /// Set by the caller to stop the work.
    pub cancel: &'a AtomicBool,
}

/// Texels read at a time.
const BAND_TEXELS: usize = 2 << 20;

/// Reads a layer's rows band by band, always one band ahead of the one being used, so that decoding
/// and encoding share the processors.
pub fn read_ahead<R: Send>(
    target: &LayerGrid,
    phase: &str,
    run: &Run<'_>,
    read: impl Fn(usize, usize) -> Result<R, PrepareError> + Sync,
    mut take: impl FnMut(R) -> Result<(), PrepareError> + Send,
) -> Result<(), PrepareError> {
    let band_rows = (BAND_TEXELS / target.width.max(1)).clamp(8, 256);
    let band = |row: usize| band_rows.min(target.height - row);
    let mut row = 0;
    let mut current = Some(read(0, band(0))?);
    while let Some(rows) = current.take() {
        if run.cancel.load(Ordering::Relaxed) {
            return Err(PrepareError::Cancelled);
        }
        let next = row + band(row);
        let read_next = || (next < target.height).then(|| read(next, band(next))).transpose();
        let (ahead, taken) = rayon::join(read_next, || take(rows));
        taken?;
        current = ahead?;
        row = next;
        run.progress.advanced(phase, row as u64, target.height as u64);
    }
    Ok(())
}

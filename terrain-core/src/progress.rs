//! Who hears how far long work has come.

/// Hears how far the work has come.
pub trait Progress: Sync {
    /// `done` of `total` parts of a phase are through: rows, tiles, whatever the work counts. Phases follow
    /// one another. Work on several threads may tell of parts out of order.
    fn advanced(&self, phase: &str, done: u64, total: u64);

    /// A choice was made that the user may want otherwise. By default nothing is done with it: results
    /// hold it too.
    fn note(&self, _text: &str) {}
}

/// A [`Progress`] that tells nobody.
pub struct NoProgress;

impl Progress for NoProgress {
    fn advanced(&self, _phase: &str, _done: u64, _total: u64) {}
}

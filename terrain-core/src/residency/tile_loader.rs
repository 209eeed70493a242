use std::any::Any;
use std::collections::{HashSet, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::tiling::TileId;

/// Worker threads that load tiles in order of urgency.
///
/// What is wanted is replaced as a whole, every frame if need be: tiles that nobody wants any more
/// are not begun, those being loaded are finished and delivered.
pub struct TileLoader<T: Send + 'static> {
    shared: Arc<Shared<T>>,
    workers: Vec<JoinHandle<()>>,
}

/// A load that ended in a panic. The tile is not tried again.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("loading tile {tile} panicked: {message}")]
pub struct LoadPanic {
    /// The tile.
    pub tile: TileId,
    /// What the panic said.
    pub message: String,
}

struct Shared<T> {
    state: Mutex<State<T>>,
    /// There is work, or it is time to stop.
    work: Condvar,
    /// A load came to an end.
    ended: Condvar,
}

struct State<T> {
    queue: VecDeque<TileId>,
    in_flight: HashSet<TileId>,
    delivered: Vec<(TileId, T)>,
    panics: Vec<LoadPanic>,
    /// Tiles that are never to be tried again.
    given_up: HashSet<TileId>,
    is_stopping: bool,
}

impl<T: Send + 'static> TileLoader<T> {
    /// Starts `threads` workers (0 is taken as 1) that call `load`.
    ///
    /// # Errors
    /// Where the system gives not even one thread.
    pub fn new(
        threads: usize,
        load: Arc<dyn Fn(TileId) -> T + Send + Sync>,
    ) -> std::io::Result<Self> {
        let mut loader =
            Self { shared: Arc::new(Shared::new()), workers: Vec::with_capacity(threads) };
        for number in 0..threads.max(1) {
            let (shared, load) = (Arc::clone(&loader.shared), Arc::clone(&load));
            let builder = std::thread::Builder::new().name(format!("tile loader {number}"));
            match builder.spawn(move || shared.work(&*load)) {
                Ok(worker) => loader.workers.push(worker),
                Err(error) if loader.workers.is_empty() => return Err(error),
                Err(_) => break, // fewer workers load the same tiles
            }
        }
        Ok(loader)
    }

    /// Replaces the queue by these tiles, most urgent first. Tiles being loaded, and those delivered
    /// but not yet taken, are not loaded twice; tiles whose load panicked are left out.
    pub fn set_wanted(&self, tiles: &[TileId]) {
        let mut state = self.shared.lock();
        let state = &mut *state;
        let mut known: HashSet<_> = state.delivered.iter().map(|&(tile, _)| tile).collect();
        known.extend(&state.in_flight);
        known.extend(&state.given_up);
        state.queue.clear();
        state.queue.extend(tiles.iter().copied().filter(|&tile| known.insert(tile)));
        self.shared.work.notify_all();
    }

    /// Takes what has been loaded since the last call, in order of completion. Does not wait.
    pub fn poll(&self) -> Vec<(TileId, T)> {
        std::mem::take(&mut self.shared.lock().delivered)
    }

    /// Takes the reports of loads that panicked. Does not wait.
    pub fn take_panics(&self) -> Vec<LoadPanic> {
        std::mem::take(&mut self.shared.lock().panics)
    }

    /// Waits until [`TileLoader::poll`] has something to give, at most for `timeout`; returns whether
    /// it has. Returns at once where nothing is under way.
    pub fn wait_any(&self, timeout: Duration) -> bool {
        let deadline = Instant::now() + timeout;
        let mut state = self.shared.lock();
        while state.delivered.is_empty() && state.is_busy() {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            let woken = self.shared.ended.wait_timeout(state, left);
            state = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
        !state.delivered.is_empty()
    }

    /// Whether nothing is queued, being loaded or waiting to be taken.
    pub fn is_idle(&self) -> bool {
        let state = self.shared.lock();
        !state.is_busy() && state.delivered.is_empty()
    }
}

impl<T: Send + 'static> Drop for TileLoader<T> {
    /// Drops the queue and waits for the loads under way.
    fn drop(&mut self) {
        let mut state = self.shared.lock();
        state.is_stopping = true;
        state.queue.clear();
        drop(state);
        self.shared.work.notify_all();
        for worker in self.workers.drain(..) {
            // A worker catches the panics of its loads; there is nothing left to report.
            let _ = worker.join();
        }
    }
}

impl<T> Shared<T> {
    fn new() -> Self {
        let state = State {
            queue: VecDeque::new(),
            in_flight: HashSet::new(),
            delivered: Vec::new(),
            panics: Vec::new(),
            given_up: HashSet::new(),
            is_stopping: false,
        };
        Self { state: Mutex::new(state), work: Condvar::new(), ended: Condvar::new() }
    }

    /// The state is whole between any two statements that hold the lock, so poison means nothing.
    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The life of a worker.
    fn work(&self, load: &(dyn Fn(TileId) -> T + Send + Sync)) {
        while let Some(tile) = self.next_tile() {
            // The closure's own state is its author's concern; ours is not touched while it runs.
            let outcome = catch_unwind(AssertUnwindSafe(|| load(tile)));
            let mut state = self.lock();
            state.in_flight.remove(&tile);
            match outcome {
                Ok(loaded) => state.delivered.push((tile, loaded)),
                Err(payload) => {
                    state.given_up.insert(tile);
                    state.panics.push(LoadPanic { tile, message: panic_message(&*payload) });
                }
            }
            drop(state);
            self.ended.notify_all();
        }
    }

    /// Waits for work; `None` when it is time to stop.
    fn next_tile(&self) -> Option<TileId> {
        let mut state = self.lock();
        loop {
            if state.is_stopping {
                return None;
            }
            if let Some(tile) = state.queue.pop_front() {
                state.in_flight.insert(tile);
                return Some(tile);
            }
            state = self.work.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl<T> State<T> {
    fn is_busy(&self) -> bool {
        !self.queue.is_empty() || !self.in_flight.is_empty()
    }
}

fn panic_message(payload: &(dyn Any + Send)) -> String {
    payload
        .downcast_ref::<&str>()
        .map(|message| (*message).to_owned())
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "no message".to_owned())
}

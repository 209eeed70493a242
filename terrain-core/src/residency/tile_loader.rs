use std::any::Any;
use std::collections::{HashSet, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::load_delay::LoadDelay;
use crate::tiling::TileId;

/// How tiles are loaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Loading {
    /// Worker threads; 0 is taken as 1.
    pub threads: usize,
    /// Frames that a tile takes at least from when it is asked for until it is handed out.
    pub delay_frames: u32,
}

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
    delay: LoadDelay<T>,
    panics: Vec<LoadPanic>,
    /// Tiles that are never to be tried again.
    given_up: HashSet<TileId>,
    is_stopping: bool,
}

impl<T: Send + 'static> TileLoader<T> {
    /// Starts workers that call `load`.
    ///
    /// # Errors
    /// Where the system gives not even one thread.
    pub fn new(
        Loading { threads, delay_frames }: Loading,
        load: Arc<dyn Fn(TileId) -> T + Send + Sync>,
    ) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::new(delay_frames));
        let mut loader = Self { shared, workers: Vec::with_capacity(threads) };
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

    /// Replaces the queue by these tiles, most urgent first; called once a frame. Tiles being loaded,
    /// and those delivered but not yet taken, are not loaded twice; tiles whose load panicked are left
    /// out.
    pub fn set_wanted(&self, tiles: &[TileId]) {
        let mut state = self.shared.lock();
        let state = &mut *state;
        let mut known: HashSet<_> = state.delivered.iter().map(|&(tile, _)| tile).collect();
        known.extend(&state.in_flight);
        known.extend(&state.given_up);
        state.delay.ask(tiles);
        known.extend(state.delay.held());
        state.queue.clear();
        state.queue.extend(tiles.iter().copied().filter(|&tile| known.insert(tile)));
        self.shared.work.notify_all();
    }

    /// Takes what has been loaded since the last call, in order of completion; called once a frame. Does
    /// not wait.
    pub fn poll(&self) -> Vec<(TileId, T)> {
        let mut state = self.shared.lock();
        let delivered = std::mem::take(&mut state.delivered);
        state.delay.due(delivered)
    }

    /// Takes the reports of loads that panicked. Does not wait.
    pub fn take_panics(&self) -> Vec<LoadPanic> {
        std::mem::take(&mut self.shared.lock().panics)
    }

    /// Waits until [`TileLoader::poll`] has something to give, at most for `timeout`; returns whether
    /// it has. Returns at once where nothing is under way.
    #[cfg(test)]
    pub fn wait_any(&self, timeout: Duration) -> bool {
        let state = self.wait_while(timeout, |state| state.delivered.is_empty() && state.is_busy());
        !state.delivered.is_empty()
    }

    /// Waits until everything wanted has been loaded, at most for `timeout`; returns whether it has.
    /// What [`TileLoader::poll`] then gives does not depend on how fast any load was.
    pub fn wait_all(&self, timeout: Duration) -> bool {
        !self.wait_while(timeout, State::is_busy).is_busy()
    }

    fn wait_while(
        &self,
        timeout: Duration,
        unfinished: impl Fn(&State<T>) -> bool,
    ) -> MutexGuard<'_, State<T>> {
        let deadline = Instant::now() + timeout;
        let mut state = self.shared.lock();
        while unfinished(&state) {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            let woken = self.shared.ended.wait_timeout(state, left);
            state = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
        state
    }

    /// Whether nothing is queued, being loaded or waiting to be taken.
    #[cfg(test)]
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
    fn new(delay_frames: u32) -> Self {
        let state = State {
            queue: VecDeque::new(),
            in_flight: HashSet::new(),
            delivered: Vec::new(),
            delay: LoadDelay::new(delay_frames),
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

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// Long enough that only a hang reaches it.
    const PATIENCE: Duration = Duration::from_secs(30);

    fn loading(threads: usize) -> Loading {
        Loading { threads, delay_frames: 0 }
    }

    fn tile(number: u32) -> TileId {
        TileId::new(5, 0, number)
    }

    /// A loader of one thread whose loads wait for a word each; every begun load is announced.
    struct Gated {
        loader: TileLoader<u32>,
        begun: crossbeam_channel::Receiver<TileId>,
        gate: crossbeam_channel::Sender<()>,
    }

    fn gated() -> Gated {
        let (announce, begun) = crossbeam_channel::unbounded();
        let (gate, open) = crossbeam_channel::unbounded();
        let load = move |tile: TileId| {
            announce.send(tile).unwrap();
            // An error means the test is over.
            let _ = open.recv();
            tile.column
        };
        Gated { loader: TileLoader::new(loading(1), Arc::new(load)).unwrap(), begun, gate }
    }

    fn take_all<T: Send>(loader: &TileLoader<T>) -> Vec<(TileId, T)> {
        let mut taken = Vec::new();
        while !loader.is_idle() {
            loader.wait_any(PATIENCE);
            taken.extend(loader.poll());
        }
        taken
    }

    #[test]
    fn the_queue_is_worked_off_in_order() {
        let Gated { loader, begun, gate } = gated();
        loader.set_wanted(&[tile(3), tile(1), tile(3), tile(2)]);
        (0..3).for_each(|_| gate.send(()).unwrap());
        assert_eq!(take_all(&loader), [(tile(3), 3), (tile(1), 1), (tile(2), 2)]);
        assert_eq!(begun.len(), 3, "a tile wanted twice is loaded once");
    }

    #[test]
    fn what_is_no_longer_wanted_is_not_begun_and_what_is_under_way_not_begun_again() {
        let Gated { loader, begun, gate } = gated();
        loader.set_wanted(&[tile(1), tile(2)]);
        assert_eq!(begun.recv_timeout(PATIENCE), Ok(tile(1)));
        loader.set_wanted(&[tile(4), tile(1)]);
        gate.send(()).unwrap();
        assert_eq!(begun.recv_timeout(PATIENCE), Ok(tile(4)));
        assert!(loader.wait_any(PATIENCE));
        loader.set_wanted(&[tile(1), tile(4)]); // one delivered but not taken, one under way
        gate.send(()).unwrap();
        assert_eq!(take_all(&loader), [(tile(1), 1), (tile(4), 4)]);
        loader.set_wanted(&[tile(1)]); // taken: it may be wanted again
        gate.send(()).unwrap();
        assert_eq!(take_all(&loader), [(tile(1), 1)]);
        assert!(begun.iter().take(1).eq([tile(1)]) && begun.is_empty());
    }

    #[test]
    fn many_threads_load_everything_once() {
        let loads = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&loads);
        let load = move |tile: TileId| {
            counted.fetch_add(1, Ordering::Relaxed);
            tile.column
        };
        let loader = TileLoader::new(loading(4), Arc::new(load)).unwrap();
        let wanted: Vec<_> = (0..32).map(tile).collect();
        loader.set_wanted(&wanted);
        let mut taken = take_all(&loader);
        taken.sort_unstable();
        assert_eq!(taken, wanted.iter().map(|&t| (t, t.column)).collect::<Vec<_>>());
        assert_eq!(loads.load(Ordering::Relaxed), 32);
    }

    #[test]
    fn a_panicking_load_is_reported_and_not_tried_again() {
        let load = |tile: TileId| {
            assert!(tile.column != 2, "tile two is bad");
            tile.column
        };
        let loader = TileLoader::new(loading(1), Arc::new(load)).unwrap();
        for _ in 0..2 {
            loader.set_wanted(&[tile(2), tile(5)]);
            assert_eq!(take_all(&loader), [(tile(5), 5)], "the worker lives on");
        }
        let panics = loader.take_panics();
        assert_eq!(panics.len(), 1);
        assert_eq!(panics[0].to_string(), "loading tile 5/0/2 panicked: tile two is bad");
        assert!(loader.take_panics().is_empty());
    }

    #[test]
    fn waiting_for_nothing_returns_at_once_and_dropping_ends_the_workers() {
        let Gated { loader, begun, gate } = gated();
        assert!(!loader.wait_any(PATIENCE) && loader.wait_all(PATIENCE) && loader.is_idle());
        loader.set_wanted(&(0..20).map(tile).collect::<Vec<_>>());
        assert_eq!(begun.recv_timeout(PATIENCE), Ok(tile(0)));
        assert!(!loader.wait_any(Duration::ZERO) && !loader.is_idle());
        assert!(!loader.wait_all(Duration::ZERO), "nineteen are still to come");
        drop(gate); // the load under way ends when the loader is being dropped
        drop(loader);
        let _ = begun.try_iter().count();
        let gone = Err(crossbeam_channel::TryRecvError::Disconnected);
        assert_eq!(begun.try_recv(), gone, "the workers have ended");
    }
}

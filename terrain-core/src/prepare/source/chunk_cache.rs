use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// The decoded strips or tiles of a raster used last, up to a number of bytes.
pub struct ChunkCache<T> {
    capacity_bytes: usize,
    state: Mutex<CacheState<T>>,
}

struct CacheState<T> {
    chunks: HashMap<u32, (Arc<T>, usize, u64)>,
    bytes: usize,
    clock: u64,
}

impl<T> ChunkCache<T> {
    /// An empty cache.
    pub fn new(capacity_bytes: usize) -> Self {
        let state = CacheState { chunks: HashMap::new(), bytes: 0, clock: 0 };
        Self { capacity_bytes, state: Mutex::new(state) }
    }

    /// The chunk, decoded by `load` (which returns it with its bytes) where it is not in memory.
    /// Several threads may decode the same chunk at once; one result is kept.
    pub fn get<E>(
        &self,
        index: u32,
        load: impl FnOnce() -> Result<(T, usize), E>,
    ) -> Result<Arc<T>, E> {
        if let Some(found) = self.locked(|state| state.touch(index)) {
            return Ok(found);
        }
        let (chunk, bytes) = load()?;
        let chunk = Arc::new(chunk);
        self.locked(|state| state.insert(index, chunk.clone(), bytes, self.capacity_bytes));
        Ok(chunk)
    }

    fn locked<R>(&self, act: impl FnOnce(&mut CacheState<T>) -> R) -> R {
        // The state is whole between statements, so a panic elsewhere leaves it usable.
        act(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl<T> CacheState<T> {
    fn touch(&mut self, index: u32) -> Option<Arc<T>> {
        self.clock += 1;
        let (chunk, _, used) = self.chunks.get_mut(&index)?;
        *used = self.clock;
        Some(chunk.clone())
    }

    fn insert(&mut self, index: u32, chunk: Arc<T>, bytes: usize, capacity_bytes: usize) {
        while self.bytes + bytes > capacity_bytes {
            let oldest = self.chunks.iter().min_by_key(|(_, (_, _, used))| *used);
            let Some(oldest) = oldest.map(|(&oldest, _)| oldest) else { break };
            self.remove(oldest);
        }
        self.remove(index);
        self.clock += 1;
        self.chunks.insert(index, (chunk, bytes, self.clock));
        self.bytes += bytes;
    }

    fn remove(&mut self, index: u32) {
        if let Some((_, bytes, _)) = self.chunks.remove(&index) {
            self.bytes -= bytes;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_unused_chunk_leaves_first() {
        let cache = ChunkCache::new(20);
        let loads = Mutex::new(Vec::new());
        let get = |index: u32| {
            let loaded = cache.get(index, || {
                loads.lock().unwrap().push(index);
                Ok::<_, ()>((index * 10, 10))
            });
            assert_eq!(*loaded.unwrap(), index * 10);
        };
        for index in [1, 2, 1, 3, 1, 2] {
            get(index);
        }
        assert_eq!(*loads.lock().unwrap(), [1, 2, 3, 2]);
    }
}

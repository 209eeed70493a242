use std::collections::HashMap;

use crate::tiling::TileId;

/// Holds loaded tiles back, for measuring what a slow disk or network costs: a tile is handed out in the
/// `frames`-th frame after the one that asked for it, or as soon as it is loaded if that is later.
pub(super) struct LoadDelay<T> {
    frames: u64,
    /// Counted by [`Self::due`].
    frame: u64,
    /// The tiles that are asked for, since when, and those of them that are loaded.
    asked: HashMap<TileId, (u64, Option<T>)>,
}

impl<T> LoadDelay<T> {
    pub fn new(frames: u32) -> Self {
        Self { frames: u64::from(frames), frame: 0, asked: HashMap::new() }
    }

    /// Begins a frame: takes what has been loaded, hands out what is due.
    pub fn due(&mut self, loaded: Vec<(TileId, T)>) -> Vec<(TileId, T)> {
        self.frame += 1;
        if self.frames == 0 {
            return loaded;
        }
        let mut due = Vec::new();
        for (tile, payload) in loaded {
            match self.asked.get_mut(&tile) {
                Some((_, held)) => *held = Some(payload),
                // Nobody asks for it any more.
                None => due.push((tile, payload)),
            }
        }
        let (frames, frame) = (self.frames, self.frame);
        let is_due = |_: &TileId, (since, held): &mut (u64, Option<T>)| {
            held.is_some() && *since + frames <= frame
        };
        let ended = self.asked.extract_if(is_due);
        due.extend(ended.filter_map(|(tile, (_, held))| Some((tile, held?))));
        // A map has no order of its own.
        due.sort_by_key(|(tile, _)| *tile);
        due
    }

    /// Takes note of the tiles that are asked for, in place of those before.
    pub fn ask(&mut self, tiles: &[TileId]) {
        if self.frames == 0 {
            return;
        }
        let mut before = std::mem::take(&mut self.asked);
        for &tile in tiles {
            let asked = before.remove(&tile).unwrap_or((self.frame, None));
            self.asked.entry(tile).or_insert(asked);
        }
    }

    /// The tiles that are held back.
    pub fn held(&self) -> impl Iterator<Item = TileId> {
        self.asked.iter().filter(|(_, (_, held))| held.is_some()).map(|(tile, _)| *tile)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(column: u32) -> TileId {
        TileId::new(4, 0, column)
    }

    fn held(delay: &LoadDelay<char>) -> Vec<TileId> {
        delay.held().collect()
    }

    #[test]
    fn tiles_come_so_many_frames_after_they_were_asked_for() {
        let mut delay = LoadDelay::new(3);
        assert_eq!(delay.due(vec![]), []);
        delay.ask(&[tile(1), tile(2), tile(1)]);
        assert_eq!((delay.due(vec![(tile(1), 'a')]), held(&delay)), (vec![], vec![tile(1)]));
        delay.ask(&[tile(1), tile(2)]);
        assert_eq!(delay.due(vec![(tile(2), 'b')]), []);
        assert_eq!(delay.due(vec![]), [(tile(1), 'a'), (tile(2), 'b')]);
        assert_eq!((delay.due(vec![]), held(&delay)), (vec![], vec![]), "each once");
    }

    #[test]
    fn a_slow_load_comes_when_it_comes_and_one_called_off_is_forgotten() {
        let mut delay = LoadDelay::new(2);
        delay.due(vec![]);
        delay.ask(&[tile(1), tile(2)]);
        delay.due(vec![(tile(1), 'a')]);
        // Nobody wants the first any more; asked for again, it counts from then on.
        delay.ask(&[tile(2)]);
        delay.ask(&[tile(1), tile(2)]);
        assert_eq!(held(&delay), []);
        assert_eq!(delay.due(vec![(tile(1), 'a')]), []);
        assert_eq!(
            delay.due(vec![(tile(2), 'b')]),
            [(tile(1), 'a'), (tile(2), 'b')],
            "one is late"
        );
    }

    #[test]
    fn without_a_delay_all_pass() {
        let mut delay = LoadDelay::new(0);
        delay.ask(&[tile(1)]);
        assert_eq!(delay.due(vec![(tile(1), 'a')]), [(tile(1), 'a')]);
    }
}

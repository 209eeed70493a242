/// A list without gaps of distinct ids, each found at once: what is taken out makes room for the last.
#[derive(Default)]
pub(super) struct IndexedList {
    ids: Vec<u32>,
    /// Place of each id in the list, or [`Self::ABSENT`].
    places: Vec<u32>,
}

impl IndexedList {
    const ABSENT: u32 = u32::MAX;

    /// The ids, in the order of their places.
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// Number of ids.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Where the id is.
    pub fn place(&self, id: u32) -> Option<u32> {
        self.places.get(id as usize).copied().filter(|&place| place != Self::ABSENT)
    }

    /// Puts an id that is not there at the end; returns its place.
    pub fn push(&mut self, id: u32) -> u32 {
        let place = self.ids.len() as u32;
        self.ids.push(id);
        self.set_place(id, place);
        place
    }

    /// Puts an id in the place of another; returns the place, if there is one.
    pub fn replace(&mut self, old: u32, new: u32) -> Option<u32> {
        let place = self.place(old)?;
        self.places[old as usize] = Self::ABSENT;
        self.ids[place as usize] = new;
        self.set_place(new, place);
        Some(place)
    }

    /// Takes an id out; returns the place that has another id now, unless it was the last.
    pub fn remove(&mut self, id: u32) -> Option<u32> {
        let place = self.place(id)?;
        self.places[id as usize] = Self::ABSENT;
        self.ids.swap_remove(place as usize);
        let moved = self.ids.get(place as usize).copied()?;
        self.places[moved as usize] = place;
        Some(place)
    }

    fn set_place(&mut self, id: u32, place: u32) {
        let index = id as usize;
        if index >= self.places.len() {
            self.places.resize(index + 1, Self::ABSENT);
        }
        self.places[index] = place;
    }
}

/// Ids that something has changed of, each once.
#[derive(Default)]
pub(super) struct ChangedIds {
    ids: Vec<u32>,
    is_listed: Vec<bool>,
}

impl ChangedIds {
    /// Lists the id.
    pub fn mark(&mut self, id: u32) {
        let index = id as usize;
        if index >= self.is_listed.len() {
            self.is_listed.resize(index + 1, false);
        }
        if !std::mem::replace(&mut self.is_listed[index], true) {
            self.ids.push(id);
        }
    }

    /// How many ids are listed.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Takes the ids in rising order; the list is empty then.
    pub fn take(&mut self) -> Vec<u32> {
        let mut ids = std::mem::take(&mut self.ids);
        for &id in &ids {
            self.is_listed[id as usize] = false;
        }
        ids.sort_unstable();
        ids
    }
}

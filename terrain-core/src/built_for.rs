/// Something built for a key, kept while the key stays and built anew when it changes: pipelines, mostly, which are
/// dear to build and fixed once they are.
pub(crate) struct BuiltFor<K, T>(Option<(K, T)>);

impl<K, T> Default for BuiltFor<K, T> {
    /// Nothing is built yet.
    fn default() -> Self {
        Self(None)
    }
}

impl<K: PartialEq, T> BuiltFor<K, T> {
    /// What is built for the key.
    pub fn get(&mut self, key: K, build: impl FnOnce() -> T) -> &T {
        let kept = self.0.take().filter(|(built_for, _)| *built_for == key);
        &self.0.insert(kept.unwrap_or_else(|| (key, build()))).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_built_when_the_key_changes() {
        let (mut cache, mut built) = (BuiltFor::default(), 0);
        for (key, expected) in [(1, 1), (1, 1), (2, 2), (1, 3)] {
            let count = *cache.get(key, || {
                built += 1;
                built
            });
            assert_eq!(count, expected);
        }
    }
}

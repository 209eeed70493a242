//! The streaming of pages held against a small model of it, under any order of requests and loads.

use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;

use super::*;

const GPU_SLOTS: u32 = 6;
const MEMORY_SLOTS: u32 = 9;
/// Pages seen at once at the most: one slot is the always resident page's.
const MOST_SEEN: usize = 5;
const PAGE_BYTES: u64 = 10;

fn layout() -> PageLayout {
    PageLayout::of_texture([5 * 64, 3 * 64], (64, 4), 1).unwrap()
}

fn pages() -> Vec<PageId> {
    let layout = layout();
    (0..layout.coarsest_level)
        .flat_map(|level| {
            let (rows, columns) = (layout.rows_at(level), layout.columns_at(level));
            (0..rows * columns).map(move |i| PageId {
                level,
                row: i / columns,
                column: i % columns,
            })
        })
        .collect()
}

/// What may happen, pages and queue places told by numbers.
#[derive(Clone, Debug)]
enum Event {
    Request(Vec<usize>),
    /// A load ends: of the so manieth page under way.
    Loaded(usize),
    Failed(usize),
    Upload(u64),
}

fn events() -> impl Strategy<Value = Vec<Event>> {
    let request =
        prop::collection::vec(0..pages().len(), 0..MOST_SEEN + 1).prop_map(Event::Request);
    let event = prop_oneof![
        3 => request,
        6 => (0_usize..8).prop_map(Event::Loaded),
        1 => (0_usize..8).prop_map(Event::Failed),
        4 => (0_u64..35).prop_map(Event::Upload),
    ];
    prop::collection::vec(event, 1..120)
}

/// The rules in their plainest form: who is where and when each was seen last.
#[derive(Default)]
struct Model {
    now: u64,
    wanted: Vec<PageId>,
    memory: BTreeMap<PageId, u64>,
    gpu: BTreeMap<PageId, u64>,
    failed: BTreeSet<PageId>,
    /// Pages that were handed out to be loaded and have not come back.
    under_way: Vec<PageId>,
}

impl Model {
    fn root(&self) -> PageId {
        layout().resident_pages().next().unwrap()
    }

    fn request(&mut self, seen: &[PageId]) {
        self.now += 1;
        self.wanted = vec![self.root()];
        self.wanted.extend(seen);
        for page in &self.wanted {
            for time in [self.memory.get_mut(page), self.gpu.get_mut(page)].into_iter().flatten() {
                *time = self.now;
            }
        }
    }

    fn is_to_load(&self, page: &PageId) -> bool {
        let is_anywhere = self.memory.contains_key(page) || self.gpu.contains_key(page);
        self.wanted.contains(page) && !is_anywhere && !self.failed.contains(page)
    }

    fn is_to_upload(&self, page: &PageId) -> bool {
        self.wanted.contains(page) && self.memory.contains_key(page) && !self.gpu.contains_key(page)
    }
}

/// The oldest of those not seen now, whom one of this set must be.
fn oldest(held: &BTreeMap<PageId, u64>, now: u64, keep: Option<PageId>) -> BTreeSet<PageId> {
    let others = || held.iter().filter(|(page, time)| **time < now && Some(**page) != keep);
    let least = others().map(|(_, time)| *time).min();
    others().filter(|(_, time)| Some(**time) == least).map(|(page, _)| *page).collect()
}

struct Pair {
    stream: PageStream<PageId>,
    model: Model,
    /// The slots as a GPU knows them.
    known: Vec<Option<u32>>,
}

impl Pair {
    fn new() -> Self {
        let stream = PageStream::new(layout(), GPU_SLOTS, MEMORY_SLOTS);
        let known = vec![None; layout().page_count() as usize];
        let mut model = Model::default();
        model.request(&[]);
        Self { stream, model, known }
    }

    fn apply(&mut self, event: &Event) {
        match event {
            Event::Request(numbers) => {
                let all = pages();
                let mut seen = numbers.iter().map(|&i| all[i]).collect::<Vec<_>>();
                seen.dedup();
                seen.retain(|page| !self.model.failed.contains(page));
                self.stream.request(&seen);
                self.model.request(&seen);
            }
            Event::Loaded(number) => {
                if let Some(page) = self.take_under_way(*number) {
                    self.load(page);
                }
            }
            Event::Failed(number) => {
                if let Some(page) = self.take_under_way(*number)
                    && page != self.model.root()
                {
                    self.stream.failed(page);
                    self.model.failed.insert(page);
                }
            }
            Event::Upload(budget) => self.upload(*budget),
        }
        // Whoever loads takes what is new in the queue; what was taken goes on being loaded.
        for &page in self.stream.to_load() {
            if !self.model.under_way.contains(&page) {
                self.model.under_way.push(page);
            }
        }
        for ChangedPage { address, shown } in self.stream.take_changed() {
            assert!(shown.is_none_or(|(_, parts)| (1..=4).contains(&parts)));
            self.known[address as usize] = shown.map(|(slot, _)| slot);
        }
        self.stream.advance_fades();
    }

    fn take_under_way(&mut self, number: usize) -> Option<PageId> {
        let count = self.model.under_way.len();
        (count > 0).then(|| self.model.under_way.remove(number % count))
    }

    fn load(&mut self, page: PageId) {
        let Self { stream, model, .. } = self;
        let is_wanted = model.is_to_load(&page);
        let before = in_memory(stream);
        stream.loaded(page, page);
        let evicted = before.difference(&in_memory(stream)).copied().collect::<Vec<_>>();
        let is_full = model.memory.len() == MEMORY_SLOTS as usize;
        let may_go = oldest(&model.memory, model.now, None);
        if model.memory.contains_key(&page) {
            assert_eq!(evicted, [], "it was there already");
        } else if is_full && may_go.is_empty() {
            assert!(!is_wanted, "there is always room for what is wanted");
            assert_eq!(evicted, []);
        } else {
            assert_eq!(evicted.len(), usize::from(is_full));
            assert!(evicted.iter().all(|page| may_go.contains(page)), "{evicted:?}");
            model.memory.retain(|page, _| !evicted.contains(page));
            let seen = if is_wanted { model.now } else { model.now - 1 };
            model.memory.insert(page, seen);
        }
    }

    fn upload(&mut self, budget: u64) {
        let Self { stream, model, .. } = self;
        let to_upload = pages().into_iter().chain([model.root()]);
        let to_upload = to_upload.filter(|page| model.is_to_upload(page)).count() as u64;
        let uploads = stream.upload(budget, |_| PAGE_BYTES);
        let fitting = (budget / PAGE_BYTES).max(1).min(to_upload);
        let root = u64::from(uploads.iter().any(|upload| upload.page == model.root()));
        let count = uploads.len() as u64;
        assert!(count >= fitting && count <= fitting + root, "{count} for {budget}");
        for PageUpload { page, evicted, .. } in uploads {
            assert!(model.is_to_upload(&page), "{page:?} was not to come");
            let is_full = model.gpu.len() == GPU_SLOTS as usize;
            assert_eq!(evicted.is_some(), is_full);
            if let Some(evicted) = evicted {
                let may_go = oldest(&model.gpu, model.now, Some(model.root()));
                assert!(may_go.contains(&evicted), "{evicted:?} was not the oldest");
                model.gpu.remove(&evicted);
            }
            model.gpu.insert(page, model.now);
        }
    }

    /// Both tell the same of every page.
    fn check(&self) {
        let Self { stream, model, known } = self;
        let slots = stream.pages_on_gpu().collect::<Vec<_>>();
        assert!(slots.len() <= GPU_SLOTS as usize);
        assert!(model.memory.len() <= MEMORY_SLOTS as usize);
        let [on_gpu, held] = stream.resident();
        assert_eq!((on_gpu, held), (model.gpu.len(), model.memory.len()));
        let mut to_load = Vec::new();
        for page in pages().into_iter().chain([model.root()]) {
            let k1 = match slots.iter().find(|(held, _)| *held == page) {
                Some((_, slot)) => PageEntry::At(*slot),
                None if model.is_to_upload(&page) => PageEntry::Queued,
                None => PageEntry::Absent,
            };
            assert_eq!(stream.on_gpu(page), k1, "{page:?}");
            assert_eq!(matches!(k1, PageEntry::At(_)), model.gpu.contains_key(&page), "{page:?}");
            assert_eq!(stream.payload(page).is_some(), model.memory.contains_key(&page));
            assert!(stream.payload(page).is_none_or(|payload| *payload == page), "a stale slot");
            match stream.in_memory(page) {
                PageEntry::At(_) => assert!(model.memory.contains_key(&page)),
                PageEntry::Failed => assert!(model.failed.contains(&page)),
                PageEntry::Queued => to_load.push(page),
                PageEntry::Absent => assert!(!model.is_to_load(&page), "{page:?} is lost"),
            }
            let shown = known[layout().address(page) as usize].map(PageEntry::At);
            let is_there = matches!(k1, PageEntry::At(_));
            assert_eq!(shown, is_there.then_some(k1), "the GPU's table");
        }
        assert!(to_load.iter().all(|page| model.is_to_load(page)));
        let queue = stream.to_load().iter().copied().collect::<BTreeSet<_>>();
        assert_eq!(queue.len(), stream.to_load().len(), "a page is queued twice");
        assert_eq!(queue, to_load.into_iter().collect());
    }
}

fn in_memory(stream: &PageStream<PageId>) -> BTreeSet<PageId> {
    let root = layout().resident_pages().next();
    let there = |page: &PageId| matches!(stream.in_memory(*page), PageEntry::At(_));
    pages().into_iter().chain(root).filter(there).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn whatever_comes_in_whatever_order_the_tables_tell_what_is_where(events in events()) {
        let mut pair = Pair::new();
        pair.check();
        for event in &events {
            pair.apply(event);
            pair.check();
        }
        // From any state all that is wanted and can be had comes, and then nothing moves any more.
        for _ in 0..40 {
            pair.apply(&Event::Loaded(0));
            pair.apply(&Event::Upload(0));
            pair.check();
        }
        prop_assert_eq!(pair.stream.missing(), 0);
        let wanted = pair.model.wanted.iter().filter(|page| !pair.model.failed.contains(page));
        prop_assert!(wanted.clone().all(|page| pair.model.gpu.contains_key(page)));
        let seen = pair.model.wanted[1..].to_vec();
        pair.stream.request(&seen);
        prop_assert_eq!(pair.stream.upload(1_000, |_| PAGE_BYTES), []);
    }
}

#[test]
fn a_page_evicted_from_the_gpu_comes_back_without_the_disk() {
    let mut pair = Pair::new();
    let all = (0..8).collect::<Vec<_>>();
    let settle = |pair: &mut Pair, numbers: &[usize]| {
        pair.apply(&Event::Request(numbers.to_vec()));
        let loads = pair.stream.to_load().len();
        for _ in 0..12 {
            pair.apply(&Event::Loaded(0));
            pair.apply(&Event::Upload(1_000));
        }
        loads
    };
    assert_eq!(settle(&mut pair, &all[..5]), 6, "five and the always resident one");
    assert_eq!(settle(&mut pair, &all[5..8]), 3);
    assert_eq!(settle(&mut pair, &all[..5]), 0, "memory has them");
    assert_eq!(pair.stream.missing(), 0);
}

#[test]
fn the_always_resident_pages_come_whatever_the_budget_and_stay() {
    let layout = PageLayout::of_texture([5 * 64, 3 * 64], (64, 4), 2).unwrap();
    let mut stream = PageStream::new(layout.clone(), 4, 8);
    let always = layout.resident_pages().collect::<Vec<_>>();
    assert_eq!(always.len(), 1 + 2);
    assert_eq!(stream.to_load(), always);
    for &page in &always {
        stream.loaded(page, page);
    }
    let uploads = stream.upload(0, |_| PAGE_BYTES);
    assert_eq!(uploads.iter().map(|upload| upload.page).collect::<Vec<_>>(), always);
    assert!(!stream.is_fading(), "there is nothing below them");
    for column in 0..5 {
        let page = PageId { level: 0, row: 0, column };
        stream.request(&[page]);
        stream.loaded(page, page);
        assert_eq!(stream.upload(0, |_| PAGE_BYTES).len(), 1);
        assert!(always.iter().all(|page| matches!(stream.on_gpu(*page), PageEntry::At(_))));
    }
}

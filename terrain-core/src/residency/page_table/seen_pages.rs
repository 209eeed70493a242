use std::collections::BTreeMap;

use super::{PageId, PagesAsked};
use crate::CameraView;

/// What the pixels of one image asked for.
pub(crate) struct PageImage {
    pub asked: PagesAsked,
    /// The frame and the camera that drew it.
    pub frame: u64,
    pub view: CameraView,
}

/// What pixels have asked for lately.
///
/// An image that sees all counts alone. Of images that see a part each, in turns, as many count as make up
/// the whole.
#[derive(Default)]
pub(crate) struct SeenPages {
    pages: BTreeMap<PageId, Seen>,
    /// Frame and camera of the latest image; `None` before the first.
    latest: Option<(u64, CameraView)>,
    images: u64,
    images_of_view: u32,
    images_of_all: u32,
}

#[derive(Clone, Copy)]
struct Seen {
    steps: u32,
    /// The latest image that asked for the page.
    image: u64,
}

impl SeenPages {
    /// Takes an image in. `period` images make up the whole, and `is_complete` tells whether none of the
    /// pages asked for was missing when it came. After so many images of one view that `grows(images of
    /// all, images)`, nothing is forgotten any more until the view changes: heights that arrive change the
    /// ground in view, and with it what is asked for, and where tiles keep driving each other out that
    /// need not end by itself.
    pub fn take(
        &mut self,
        image: PageImage,
        period: u32,
        is_complete: bool,
        grows: impl Fn(u32, u32) -> bool,
    ) {
        if self.latest.is_none_or(|(_, view)| view != image.view) {
            (self.images_of_view, self.images_of_all) = (0, 0);
        }
        self.images += 1;
        self.images_of_view += 1;
        self.images_of_all += u32::from(is_complete);
        self.latest = Some((image.frame, image.view));
        // In periods, so that it means the same for all ways to see.
        if !grows(self.images_of_all.div_ceil(period), self.images_of_view.div_ceil(period)) {
            let oldest = (self.images + 1).saturating_sub(u64::from(period));
            self.pages.retain(|_, seen| seen.image >= oldest);
        }
        for (page, steps) in image.asked {
            let seen = self.pages.entry(page).or_insert(Seen { steps: 0, image: 0 });
            seen.steps |= steps;
            seen.image = self.images;
        }
    }

    /// All that counts.
    pub fn asked(&self) -> PagesAsked {
        self.pages.iter().map(|(&page, seen)| (page, seen.steps)).collect()
    }

    /// Frame and camera of the latest image.
    pub fn latest(&self) -> Option<(u64, CameraView)> {
        self.latest
    }

    /// Whether images of all turns of this view have come.
    pub fn has_whole(&self, view: &CameraView, period: u32) -> bool {
        self.images_of_view >= period && self.latest.is_some_and(|(_, latest)| latest == *view)
    }

    /// The settings have changed: images of the view count anew.
    pub fn reconsider(&mut self) {
        (self.images_of_view, self.images_of_all) = (0, 0);
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn view(heading_deg: f64) -> CameraView {
        let viewport_px = [64, 64];
        CameraView { eye: DVec3::ZERO, heading_deg, pitch_deg: 0.0, fov_y_deg: 50.0, viewport_px }
    }

    fn image(heading_deg: f64, columns: &[u32]) -> PageImage {
        let page = |&column: &u32| (PageId { level: 0, row: 0, column }, 1);
        PageImage { asked: columns.iter().map(page).collect(), frame: 7, view: view(heading_deg) }
    }

    fn columns(seen: &SeenPages) -> Vec<u32> {
        seen.asked().keys().map(|page| page.column).collect()
    }

    fn never(_: u32, _: u32) -> bool {
        false
    }

    #[test]
    fn an_image_that_sees_all_counts_alone() {
        let mut seen = SeenPages::default();
        seen.take(image(0.0, &[1, 2]), 1, true, never);
        seen.take(image(0.0, &[3]), 1, true, never);
        assert_eq!(columns(&seen), [3]);
        assert_eq!(seen.latest(), Some((7, view(0.0))));
    }

    #[test]
    fn images_that_see_a_part_count_for_a_period() {
        let mut seen = SeenPages::default();
        for column in 0..5 {
            assert!(!seen.has_whole(&view(0.0), 3) || column >= 3);
            seen.take(image(0.0, &[column]), 3, true, never);
        }
        assert_eq!(columns(&seen), [2, 3, 4]);
        assert!(seen.has_whole(&view(0.0), 3) && !seen.has_whole(&view(1.0), 3));
        seen.take(image(1.0, &[9]), 3, true, never);
        assert_eq!(columns(&seen), [3, 4, 9], "what another view saw counts as long");
        assert!(!seen.has_whole(&view(1.0), 3));
    }

    #[test]
    fn of_a_view_that_goes_on_changing_nothing_is_forgotten_at_last() {
        let mut seen = SeenPages::default();
        let grows = |of_all: u32, _: u32| of_all > 2;
        for turn in 0..8 {
            seen.take(image(0.0, &[turn % 2]), 1, true, grows);
        }
        assert_eq!(columns(&seen), [0, 1]);
        seen.take(image(5.0, &[4]), 1, true, grows);
        assert_eq!(columns(&seen), [4], "another view begins anew");
    }
}

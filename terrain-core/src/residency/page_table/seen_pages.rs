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
}

#[derive(Clone, Copy)]
struct Seen {
    steps: u32,
    /// The latest image that asked for the page.
    image: u64,
}

impl SeenPages {
    /// Takes an image in; `period` of them make up the whole.
    pub fn take(&mut self, image: PageImage, period: u32) {
        self.images += 1;
        self.latest = Some((image.frame, image.view));
        let oldest = (self.images + 1).saturating_sub(u64::from(period));
        self.pages.retain(|_, seen| seen.image >= oldest);
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
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn image(columns: &[u32]) -> PageImage {
        let viewport_px = [64, 64];
        let view = CameraView {
            eye: DVec3::ZERO,
            heading_deg: 0.0,
            pitch_deg: 0.0,
            fov_y_deg: 50.0,
            viewport_px,
        };
        let page = |&column: &u32| (PageId { level: 0, row: 0, column }, 1 << column);
        PageImage { asked: columns.iter().map(page).collect(), frame: 7, view }
    }

    fn columns(seen: &SeenPages) -> Vec<u32> {
        seen.asked().keys().map(|page| page.column).collect()
    }

    #[test]
    fn an_image_that_sees_all_counts_alone() {
        let mut seen = SeenPages::default();
        assert_eq!(seen.latest(), None);
        seen.take(image(&[1, 2]), 1);
        seen.take(image(&[3]), 1);
        assert_eq!(columns(&seen), [3]);
        assert_eq!(seen.latest(), Some((7, image(&[]).view)));
    }

    #[test]
    fn images_that_see_a_part_count_for_a_period() {
        let mut seen = SeenPages::default();
        for column in 0..5 {
            seen.take(image(&[column]), 3);
        }
        assert_eq!(columns(&seen), [2, 3, 4]);
        seen.take(image(&[3]), 3);
        assert_eq!(columns(&seen), [3, 4]);
        for _ in 0..2 {
            seen.take(image(&[]), 3);
        }
        assert_eq!(columns(&seen), [3], "seen again");
    }
}

use crate::CameraView;
use crate::selection::{CoordinateImage, SeenGround, Visibility, VisibleRegion, visible_region};

/// A view that was seen, and how often.
#[derive(Clone, Copy)]
pub(super) struct SeenView {
    /// Frame of the latest image of it.
    pub frame: u64,
    pub view: CameraView,
    /// Images of this very view.
    images: u32,
    /// Those of them that came when no tile was missing.
    images_of_all: u32,
}

impl SeenView {
    /// Images of a view that are taken as they are: so many when no tile was missing, so many at all.
    ///
    /// Heights that arrive change the ground in view, and a changed region may choose other tiles.
    /// Commonly one image after the last tile ends that. Where the cache is so small that each choice
    /// evicts what the one before had brought, it need not end at all; so from here on the region of
    /// a view only grows, which ends for certain; there all of it counts as visible.
    const AS_THEY_ARE: [u32; 2] = [4, 256];

    /// The state after an image of the view that was drawn in this frame; `is_of_all`: no tile was missing.
    pub fn after(
        earlier: Option<&Self>,
        (frame, view): (u64, CameraView),
        is_of_all: bool,
    ) -> Self {
        let earlier = earlier.filter(|earlier| earlier.view == view);
        Self {
            frame,
            view,
            images: earlier.map_or(0, |earlier| earlier.images) + 1,
            images_of_all: earlier.map_or(0, |earlier| earlier.images_of_all)
                + u32::from(is_of_all),
        }
    }

    /// Whether the region of the view only grows by now.
    pub fn grows(&self) -> bool {
        self.images_of_all > Self::AS_THEY_ARE[0] || self.images > Self::AS_THEY_ARE[1]
    }

    /// Counts the images anew: what is chosen by them is something else.
    pub fn reconsider(&mut self) {
        (self.images, self.images_of_all) = (0, 0);
    }

    /// How many frames ago it was seen; 0 where tiles were selected for this very view.
    pub fn age_frames(&self, selected_for: Option<&CameraView>, frame: u64) -> u64 {
        if selected_for == Some(&self.view) { 0 } else { frame - self.frame }
    }
}

/// The latest region that came back.
pub(super) struct RegionState {
    /// `None`: the view was empty.
    pub region: Option<VisibleRegion>,
    /// The image it is the box of, where what its pixels saw is to count and not all of the box.
    pub image: Option<CoordinateImage>,
    pub seen: SeenView,
}

impl RegionState {
    /// The state after the region of this image has come back; `is_of_all`: no tile was missing.
    pub fn after(earlier: Option<&Self>, image: CoordinateImage, is_of_all: bool) -> Self {
        let region = visible_region(&image);
        let when = (image.frame, image.view);
        let seen = SeenView::after(earlier.map(|earlier| &earlier.seen), when, is_of_all);
        match earlier.filter(|_| seen.grows()) {
            Some(earlier) => {
                let region = VisibleRegion::union(earlier.region, region);
                Self { region, image: None, seen }
            }
            None => Self { region, image: Some(image), seen },
        }
    }

    /// What was seen and counts as visible; `None` for an empty view.
    pub fn visible(&self, visibility: Visibility) -> Option<SeenGround<'_>> {
        let image = self.image.as_ref().filter(|_| visibility == Visibility::Exact);
        self.region.as_ref().map(|region| SeenGround { region, image })
    }
}

use crate::CameraView;
use crate::renderer_settings::RendererSettings;
use crate::selection::{CoordinateImage, SeenGround, Visibility, VisibleRegion};

/// The latest region that came back.
pub(super) struct RegionState {
    /// `None`: the view was empty.
    pub region: Option<VisibleRegion>,
    /// The image it is the box of, where what its pixels saw is to count and not all of the box.
    pub image: Option<CoordinateImage>,
    pub frame: u64,
    pub view: CameraView,
    /// Images of this very view that have come back.
    pub images: u32,
    /// Those of them that came when no tile was missing.
    pub images_of_all: u32,
}

impl RegionState {
    /// Images of a view that are taken as they are: so many when no tile was missing, so many at all.
    ///
    /// Heights that arrive change the ground in view, and a changed region may choose other tiles.
    /// Commonly one image after the last tile ends that. Where the cache is so small that each choice
    /// evicts what the one before had brought, it need not end at all; so from here on the region of
    /// a view only grows, which ends for certain; there all of it counts as visible.
    const AS_THEY_ARE: [u32; 2] = [4, 256];

    /// Whether after so many images of a view, so many of them with no tile missing, its region only
    /// grows.
    pub fn grows(images_of_all: u32, images: u32) -> bool {
        images_of_all > Self::AS_THEY_ARE[0] || images > Self::AS_THEY_ARE[1]
    }

    /// The state after this region of the view has come back.
    pub fn after(earlier: Option<&Self>, found: Self) -> Self {
        let Some(earlier) = earlier.filter(|earlier| earlier.view == found.view) else {
            return found;
        };
        let images = earlier.images + found.images;
        let images_of_all = earlier.images_of_all + found.images_of_all;
        if Self::grows(images_of_all, images) {
            let region = VisibleRegion::union(earlier.region, found.region);
            Self { region, image: None, images, images_of_all, ..found }
        } else {
            Self { images, images_of_all, ..found }
        }
    }

    /// What was seen and counts as visible; `None` for an empty view.
    pub fn seen(&self, visibility: Visibility) -> Option<SeenGround<'_>> {
        let image = self.image.as_ref().filter(|_| visibility == Visibility::Exact);
        self.region.as_ref().map(|region| SeenGround { region, image })
    }
}

/// What a coordinate image is drawn anew for. Not the choice among resident tiles: it follows from the
/// image, and commonly a still camera comes to rest so.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct CoordinateState {
    pub view: CameraView,
    pub uploads: u64,
    pub settings: RendererSettings,
}

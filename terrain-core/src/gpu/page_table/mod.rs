//! The page table of a virtual texture on the GPU: its entries and atlas, the passes that find what pixels
//! ask for, and those that draw plane ground with it. What is decided is decided in
//! [`crate::residency::page_table`].

mod feedback;
mod gather_pass;
mod ground_pass;
mod page_atlas;
mod page_bindings;
mod page_ground;
mod page_marks;
mod request_image;
mod sample_pass;
mod tin_pass;

pub(crate) use feedback::PageFeedbackRing;
pub(crate) use ground_pass::{
    PageGroundBindings, PageGroundPass, PageGroundPassSettings, PageRequestPass,
};
pub(crate) use page_atlas::PageAtlas;
pub(crate) use page_bindings::{PageBindings, PageTableUniforms};
pub(crate) use page_ground::{PageGround, PageGroundGroup};
pub(crate) use page_marks::PageMarks;
pub(super) use request_image::RequestImage;
pub(crate) use tin_pass::{TinBindings, TinBuffers, TinPass, TinPassSettings, TinRequestPass};

#[cfg(test)]
pub(super) use gather_pass::GatherPagesPass;
#[cfg(test)]
pub(super) use sample_pass::SamplePagesPass;
#[cfg(test)]
pub(super) use tin_pass::TinPlace;

//! The page table of a virtual texture: which of its tiles are on the GPU, in memory or on their way, and
//! which are to come. Plans only, no GPU.
//!
//! After the paper on GPU-visible tiles ("a new method for fast determination of visible texture tiles",
//! stages, tables and algorithms under its names): pixels ask for tiles of the texture, [`unite`]d on the
//! GPU or here; [`fitting`] makes of what they asked what there is room for; [`PageStream`] brings it from
//! disk to memory to the GPU. Nothing here knows what the texture is drawn on.

mod face_culling;
mod page_fades;
mod page_feedback;
mod page_layout;
mod page_request;
mod page_slots;
mod page_stream;
mod seen_pages;
mod texture_place;

pub use face_culling::{FaceCulling, UnknownFaceCulling};
pub use page_feedback::{PageFeedback, UnknownPageFeedback};
pub use page_layout::{PageId, PageLayout};
pub use page_request::{PageRequest, PagesAsked, coarsened, fitting, unite};
pub use page_stream::{ChangedPage, PageEntry, PageStream, PageUpload};
pub(crate) use seen_pages::{PageImage, SeenPages};
pub use texture_place::{Footprint, TexturePlace};

#[cfg(test)]
mod tests;

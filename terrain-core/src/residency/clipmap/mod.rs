//! Clipmaps: of every level of a layer a square window of texels round the eye, kept in a texture whose
//! sides wrap round, so that a window that moves brings in only the texels it newly covers. Plans only,
//! no GPU.
//!
//! After Tanner, Migdal and Jones, "The Clipmap: A Virtual Mipmap" (1998) for colours, and Losasso and
//! Hoppe, "Geometry Clipmaps: Terrain Rendering Using Nested Regular Grids" (2004), for heights:
//! nested windows ([`window_around`]), updates that wrap round ([`pieces`]), levels shown as far as they are
//! complete, coarser ones first ([`LevelFill`]), and levels left alone
//! whose texels would be too small to see from the eye's height ([`is_level_wanted`]).
//!
//! Where this departs from them: a window is as large as the picture's resolution asks
//! ([`clip_sizes`]) rather than fixed; its texels come from the tiles of a dataset ([`ClipLayer`]), as
//! they are stored there, not from one compressed image in memory; and what is complete of a level is
//! a rectangle that grows from the eye outwards, all levels side by side: after a jump the ground near
//! the eye is sharp long before the last of the coarser levels has come.

mod clip_layer;
mod clip_sizes;
mod level_fill;
mod pieces;
#[cfg(test)]
mod tests;
mod texel_rect;
mod window;

pub use clip_layer::{ClipLayer, ClipLayerUpdate, ClipStrip, TileKeeping};
pub use clip_sizes::{ClipSizes, clip_sizes, is_level_wanted};
pub use level_fill::LevelFill;
pub use pieces::{Piece, pieces, tiles_under};
pub use texel_rect::TexelRect;
pub use window::{WINDOW_STEP_TEXELS, clip_level_count, level_size_texels, window_around};

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use super::image_pyramid::ImagePyramid;
use super::model::{Model, ModelImage, WrapMode};
use crate::dataset::{ColourFormat, ColourTile};
use crate::residency::page_table::{PageId, PageLayout};
use crate::tiling::TileId;

/// All images of a scene in one virtual texture.
///
/// Each image lies in the middle of a square block of its own, a power of two texels a side and at least twice the
/// image's. Round the image the block holds what its wrap modes show there, so that filters need no borders:
/// down to the level at which a margin of two texels is left ([`PackedImage::coarsest_level`], the image some four
/// texels across), nothing of another image comes near. Beyond that level who draws takes the image's mean colour
/// ([`PackedImage::mean`]) instead of the texture, which is all that is left of it anyway. Most of a block is
/// never asked for; a page that is not asked for is not made.
///
/// An image that several models or materials use with the same wrap modes is there once.
pub struct TexturePack {
    layout: PageLayout,
    images: Vec<PackedImage>,
    /// Which of the images each material of each model shows.
    shown: Vec<Vec<Option<usize>>>,
    pyramids: Vec<ImagePyramid>,
}

/// Where an image lies in the virtual texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackedImage {
    /// Texel of level 0 at the image's top left corner: a multiple of a quarter of the block.
    pub first_texel: [u32; 2],
    /// Texels of the image.
    pub size_texels: [u32; 2],
    /// Texel of level 0 at the block's top left corner: a multiple of its size.
    pub block_first: [u32; 2],
    /// Texels a side of the block: a power of two.
    pub block_size: u32,
    /// The coarsest level at which the image is not drawn with its neighbours' colours.
    pub coarsest_level: u8,
    /// Mean of the image: linear light, and coverage.
    pub mean: [f32; 4],
    /// How the image goes on beyond its borders.
    pub wrap: [WrapMode; 2],
    /// Which of the distinct images it is.
    pyramid: usize,
}

impl TexturePack {
    /// Texels along a side of a page, and of its gutter.
    pub const TILE_TEXELS: u32 = 128;
    /// Two halvings of a slot leave a gutter of one texel.
    pub const GUTTER_TEXELS: u32 = 4;
    /// Most pages that are always resident.
    const MOST_RESIDENT: u32 = 24;
    /// Blocks are no smaller, so that even an image of one texel has a level at which it shows by itself.
    const LEAST_BLOCK: u32 = 16;

    /// Packs the images of the models.
    ///
    /// # Errors
    /// In words, where all images together are more than a virtual texture can be.
    pub fn new(models: &[Model]) -> Result<Self, String> {
        let mut distinct = Distinct::default();
        let mut of_model = |model: &Model| -> Vec<Option<usize>> {
            let shown = model.materials.iter().map(|material| {
                let texture = material.texture.as_ref()?;
                Some(distinct.place(model.images.get(texture.image)?, texture.wrap))
            });
            shown.collect()
        };
        let shown = models.iter().map(&mut of_model).collect();
        let Distinct { images, pyramids, .. } = distinct;
        let (layout, images) = packed(&pyramids, &images)?;
        Ok(Self { layout, images, shown, pyramids })
    }

    /// The image on a material of a model, both by their numbers; `None` where there is none.
    pub fn image_on(&self, model: usize, material: usize) -> Option<&PackedImage> {
        let place = self.shown.get(model)?.get(material).copied()??;
        self.images.get(place)
    }

    /// How the texture is cut into pages.
    pub fn layout(&self) -> &PageLayout {
        &self.layout
    }

    /// The images' places.
    pub fn images(&self) -> &[PackedImage] {
        &self.images
    }

    /// Makes the page that is this tile; see [`PageLayout::tile_of`].
    pub fn page(&self, tile: TileId) -> ColourTile {
        let stored_size_texels = Self::TILE_TEXELS + 2 * Self::GUTTER_TEXELS;
        let mut data = vec![0; 4 * (stored_size_texels as usize).pow(2)];
        if let Some(page) = self.layout.page_of(tile) {
            for image in &self.images {
                self.draw(image, page, (&mut data, stored_size_texels));
            }
        }
        ColourTile { id: tile, stored_size_texels, format: ColourFormat::Rgba8, data }
    }

    /// Draws what of an image's block lies on a page, its gutter included.
    fn draw(&self, image: &PackedImage, page: PageId, (data, stored): (&mut [u8], u32)) {
        let level = page.level;
        let corner = [page.column, page.row]
            .map(|index| i64::from(index * Self::TILE_TEXELS) - i64::from(Self::GUTTER_TEXELS));
        let range = |axis: usize| {
            let first = i64::from(image.block_first[axis] >> level) - corner[axis];
            let end = i64::from((image.block_first[axis] + image.block_size).div_ceil(1 << level))
                - corner[axis];
            first.clamp(0, i64::from(stored))..end.clamp(0, i64::from(stored))
        };
        // Where the block's quarters are no whole texels any more only the mean is ever shown.
        let is_whole = (image.block_size / 4) >> level > 0;
        let pyramid_level = if is_whole { usize::from(level) } else { usize::MAX };
        let first = image.first_texel.map(|texel| i64::from(texel >> level));
        let pyramid = &self.pyramids[image.pyramid];
        for y in range(1) {
            for x in range(0) {
                let place = [x + corner[0] - first[0], y + corner[1] - first[1]];
                let texel = pyramid.texel(pyramid_level, place, image.wrap);
                let index = 4 * (y as usize * stored as usize + x as usize);
                data[index..index + 4].copy_from_slice(&texel);
            }
        }
    }
}

/// The distinct images among all, and the distinct ways in which each is wrapped.
#[derive(Default)]
struct Distinct {
    pyramids: Vec<ImagePyramid>,
    by_hash: HashMap<u64, Vec<usize>>,
    /// Which image, and how it is wrapped.
    images: Vec<(usize, [WrapMode; 2])>,
}

impl Distinct {
    fn place(&mut self, image: &ModelImage, wrap: [WrapMode; 2]) -> usize {
        let pyramid = self.pyramid(image);
        let known = self.images.iter().position(|known| *known == (pyramid, wrap));
        known.unwrap_or_else(|| {
            self.images.push((pyramid, wrap));
            self.images.len() - 1
        })
    }

    fn pyramid(&mut self, image: &ModelImage) -> usize {
        let mut hasher = DefaultHasher::new();
        (image.size_texels, &image.rgba).hash(&mut hasher);
        let alike = self.by_hash.entry(hasher.finish()).or_default();
        let known = alike.iter().copied().find(|&index| self.pyramids[index].image() == image);
        known.unwrap_or_else(|| {
            alike.push(self.pyramids.len());
            self.pyramids.push(ImagePyramid::new(image.clone()));
            self.pyramids.len() - 1
        })
    }
}

/// Places for the images, and the layout of the texture that holds them all.
///
/// Blocks are laid along a Z-order curve, the largest first: each then begins at a multiple of its own size, and
/// they follow one another without gaps.
fn packed(
    pyramids: &[ImagePyramid],
    images: &[(usize, [WrapMode; 2])],
) -> Result<(PageLayout, Vec<PackedImage>), String> {
    let block_size = |&(pyramid, _): &(usize, [WrapMode; 2])| {
        let longest = pyramids[pyramid].image().size_texels.into_iter().max().unwrap_or(1);
        (2 * longest).next_power_of_two().max(TexturePack::LEAST_BLOCK)
    };
    let mut order = (0..images.len()).collect::<Vec<_>>();
    order.sort_by_key(|&index| std::cmp::Reverse(block_size(&images[index])));
    let mut placed = vec![None; images.len()];
    let (mut along_curve, mut end) = (0_u64, [TexturePack::TILE_TEXELS; 2]);
    for index in order {
        let (pyramid, wrap) = images[index];
        let size = block_size(&images[index]);
        let block_first = z_order(along_curve).ok_or_else(too_large)?;
        along_curve += u64::from(size) * u64::from(size);
        end = [0, 1].map(|axis| end[axis].max(block_first[axis].saturating_add(size)));
        placed[index] = Some(PackedImage {
            first_texel: block_first.map(|first| first + size / 4),
            size_texels: pyramids[pyramid].image().size_texels,
            block_first,
            block_size: size,
            coarsest_level: (size / 8).ilog2() as u8,
            mean: pyramids[pyramid].mean(),
            wrap,
            pyramid,
        });
    }
    let layout = layout_of(end).ok_or_else(too_large)?;
    Ok((layout, placed.into_iter().flatten().collect()))
}

fn too_large() -> String {
    "the textures of all models together are more than a virtual texture can be".to_owned()
}

/// Column and row of a place along the Z-order curve (G. M. Morton, 1966): its even bits and its odd ones.
fn z_order(place: u64) -> Option<[u32; 2]> {
    let every_second = |bits: u64| (0..32).fold(0, |sum, bit| sum | (bits >> (2 * bit) & 1) << bit);
    let corner = [every_second(place), every_second(place >> 1)];
    // Half the range, so that sums stay within it.
    corner.iter().all(|side| *side < 1 << 30).then(|| corner.map(|side| side as u32))
}

/// Of a texture of this size: as many of the coarsest levels always resident as are few pages.
fn layout_of(size_texels: [u32; 2]) -> Option<PageLayout> {
    let sizes = (TexturePack::TILE_TEXELS, TexturePack::GUTTER_TEXELS);
    let of = |levels| PageLayout::of_texture(size_texels, sizes, levels);
    let is_few =
        |layout: &PageLayout| layout.resident_pages().count() as u32 <= TexturePack::MOST_RESIDENT;
    (2..=3).rev().filter_map(of).find(is_few).or_else(|| of(1))
}

#[cfg(test)]
mod tests;

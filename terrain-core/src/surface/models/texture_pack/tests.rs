use proptest::prelude::*;

use super::*;
use crate::surface::models::{ModelMaterial, ModelTexture};

fn image([width, height]: [u32; 2], first: u8) -> ModelImage {
    let texels = 0..width * height;
    let rgba = texels.flat_map(|index| [first, (index % 251) as u8, (index / 251) as u8, 255]);
    ModelImage { size_texels: [width, height], rgba: rgba.collect() }
}

/// A model with a material for each image.
fn model(images: Vec<ModelImage>, wrap: WrapMode) -> Model {
    let texture = |image| Some(ModelTexture { image, wrap: [wrap; 2] });
    let material = |image| ModelMaterial { texture: texture(image), ..Default::default() };
    Model { materials: (0..images.len()).map(material).collect(), images, ..Default::default() }
}

fn overlaps(one: &PackedImage, other: &PackedImage) -> bool {
    (0..2).all(|axis| {
        one.block_first[axis] < other.block_first[axis] + other.block_size
            && other.block_first[axis] < one.block_first[axis] + one.block_size
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn blocks_are_aligned_inside_and_apart(
        sizes in prop::collection::vec((1_u32..300, 1_u32..300), 0..40),
    ) {
        let images = sizes.iter().zip(0..).map(|(&(w, h), first)| image([w, h], first)).collect();
        let pack = TexturePack::new(&[model(images, WrapMode::Repeat)]).unwrap();
        prop_assert_eq!(pack.images().len(), sizes.len());
        let end = pack.layout().data_end;
        for (index, packed) in pack.images().iter().enumerate() {
            prop_assert_eq!(pack.image_on(0, index), Some(packed));
            prop_assert_eq!(packed.size_texels, [sizes[index].0, sizes[index].1]);
            prop_assert!(packed.block_size.is_power_of_two());
            for (axis, end) in end.to_array().into_iter().enumerate() {
                prop_assert_eq!(packed.block_first[axis] % packed.block_size, 0);
                prop_assert!(packed.block_first[axis] + packed.block_size <= end as u32);
                // Two texels of the coarsest level all round.
                let margin = 2 << packed.coarsest_level;
                prop_assert!(packed.first_texel[axis] >= packed.block_first[axis] + margin);
                let image_end = packed.first_texel[axis] + packed.size_texels[axis];
                prop_assert!(image_end + margin <= packed.block_first[axis] + packed.block_size);
            }
            for other in &pack.images()[..index] {
                prop_assert!(!overlaps(packed, other), "{packed:?} {other:?}");
            }
        }
        // No more than twice what the blocks themselves take, or a page.
        let blocks: u64 = pack.images().iter().map(|i| u64::from(i.block_size).pow(2)).sum();
        let texture = end.x as u64 * end.y as u64;
        prop_assert!(texture <= (4 * blocks).max(128 * 128), "{texture} for {blocks}");
    }
}

#[test]
fn like_images_are_there_once_unless_they_are_wrapped_otherwise() {
    let images = || vec![image([8, 8], 1), image([8, 8], 2)];
    let models = [
        model(images(), WrapMode::Repeat),
        model(images(), WrapMode::Repeat),
        model(images(), WrapMode::Clamp),
    ];
    let pack = TexturePack::new(&models).unwrap();
    assert_eq!(pack.shown, [[Some(0), Some(1)], [Some(0), Some(1)], [Some(2), Some(3)]]);
    assert_eq!((pack.image_on(3, 0), pack.image_on(0, 2)), (None, None));
    assert_eq!((pack.images().len(), pack.pyramids.len()), (4, 2));
}

/// Every texel of every page, its gutter too, is the one that the wrapped image has there.
#[test]
fn pages_hold_the_images_and_how_they_go_on() {
    for wrap in [WrapMode::Repeat, WrapMode::Mirror, WrapMode::Clamp] {
        let shown = image([200, 90], 7);
        let pack = TexturePack::new(&[model(vec![shown.clone()], wrap)]).unwrap();
        let packed = pack.images()[0];
        let layout = pack.layout();
        assert_eq!((packed.block_size, layout.columns, layout.rows), (512, 4, 4));
        for (row, column) in (0..16).map(|index| (index / 4, index % 4)) {
            let page = pack.page(layout.tile_of(PageId { level: 0, row, column }));
            assert_eq!(page.stored_size_texels, 136);
            for (index, texel) in page.data.as_chunks::<4>().0.iter().enumerate() {
                let x = i64::from(column * 128) + index as i64 % 136 - 4;
                let y = i64::from(row * 128) + index as i64 / 136 - 4;
                let is_outside = |place: i64| !(0..512).contains(&place);
                if is_outside(x) || is_outside(y) {
                    assert_eq!(*texel, [0; 4]);
                    continue;
                }
                let place = (wrap.texel(x - 128, 200), wrap.texel(y - 128, 90));
                let at = (place.1 * 200 + place.0) as usize;
                assert_eq!(texel[..], shown.rgba[4 * at..4 * at + 4], "{wrap:?} {x} {y}");
            }
        }
    }
}

/// A coarser page is the mean of the finer ones, inside the image and beyond its border.
#[test]
fn coarser_pages_are_means_of_finer_ones() {
    let grey = |index: u32| {
        if (index / 2).is_multiple_of(2) { [40, 40, 40, 255] } else { [200, 200, 200, 255] }
    };
    let rgba = (0..256 * 256_u32).flat_map(grey).collect();
    let shown = ModelImage { size_texels: [256, 256], rgba };
    let pack = TexturePack::new(&[model(vec![shown], WrapMode::Repeat)]).unwrap();
    let layout = pack.layout();
    // Level 1 pairs texels alike, level 2 mixes the two greys in equal parts of light.
    for (level, greys) in [(1, vec![40, 200]), (2, vec![149]), (layout.coarsest_level, vec![149])] {
        let page = pack.page(layout.tile_of(PageId { level, row: 0, column: 0 }));
        let inside = |index: &usize| {
            index / 136 >= 8 && index / 136 < 100 && index % 136 >= 8 && index % 136 < 100
        };
        for (_, texel) in
            page.data.as_chunks::<4>().0.iter().enumerate().filter(|(index, _)| inside(index))
        {
            assert!(greys.contains(&texel[0]), "level {level}: {texel:?}");
        }
    }
    assert!((pack.images()[0].mean[0] - 0.2994).abs() < 0.003, "{:?}", pack.images()[0].mean);
}

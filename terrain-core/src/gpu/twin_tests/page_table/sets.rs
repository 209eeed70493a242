//! The pages that all pixels of an image ask for, as a set, by every way to find it.

use std::collections::BTreeSet;

use glam::{DVec2, Vec2, dvec2};

use super::{MOST_TAPS, PageProbePoint, Stage, layout, mapped};
use crate::gpu::page_table::{GatherPagesPass, PageMarks, RequestImage, SamplePagesPass};
use crate::gpu::read_texture;
use crate::gpu::twin_tests::gpu;
use crate::residency::page_table::{
    Footprint, PageId, PageLayout, PageRequest, PagesAsked, TexturePlace, unite,
};

const IMAGE_PX: [u32; 2] = [203, 117];

/// The pixels of a plane seen at a slant, with sky above: places, and the exact sides of their footprints.
fn slanted_plane() -> Vec<Option<PageProbePoint>> {
    let place = |x: f64, y: f64| {
        let below = (y - 20.0) / 97.0;
        let distance = 0.05 / below;
        dvec2(0.45 + (x - 101.0) / 203.0 * distance * 3.0, 1.02 - 1.7 * distance)
    };
    let size = dvec2(1_900.0, 1_150.0);
    let pixel = |index: u32| {
        let (x, y) = (f64::from(index % IMAGE_PX[0]) + 0.5, f64::from(index / IMAGE_PX[0]) + 0.5);
        let st = place(x, y);
        let inside = y > 20.5 && st.cmpge(DVec2::ZERO).all() && st.cmple(DVec2::ONE).all();
        inside.then(|| PageProbePoint {
            st: st.as_vec2(),
            span_x: ((place(x + 1.0, y) - st) * size).as_vec2(),
            span_y: ((place(x, y + 1.0) - st) * size).as_vec2(),
            padding: Vec2::ZERO,
        })
    };
    (0..IMAGE_PX[0] * IMAGE_PX[1]).map(pixel).collect()
}

/// The request image of the plane, its requests made by the GPU.
fn request_image(stage: &Stage, pixels: &[Option<PageProbePoint>]) -> RequestImage {
    let seen = pixels.iter().flatten().copied().collect::<Vec<_>>();
    let mut requests = stage.probe(&seen).into_iter().map(|answer| answer.request);
    let texels =
        pixels.iter().map(|pixel| pixel.map_or(PageRequest::NONE, |_| requests.next().unwrap()));
    let texels = texels.collect::<Vec<_>>();
    let image = RequestImage::new(&stage.gpu.device, IMAGE_PX);
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(IMAGE_PX[0] * RequestImage::TEXEL_BYTES),
        rows_per_image: None,
    };
    let (target, size) = (image.texture.as_image_copy(), image.texture.size());
    stage.gpu.queue.write_texture(target, bytemuck::cast_slice(&texels), layout, size);
    image
}

/// What the CPU works out from places and footprints alone: what is asked for for certain, and what may be, where a
/// value lies within rounding of the next step.
fn by_brute_force(
    layout: &PageLayout,
    pixels: &[Option<PageProbePoint>],
) -> [BTreeSet<(PageId, u32)>; 2] {
    let (mut certain, mut possible) = (BTreeSet::new(), BTreeSet::new());
    for point in pixels.iter().flatten() {
        let place = TexturePlace::from_coordinates(layout, point.st.as_dvec2());
        let nudged = [-2.0e-4, 0.0, 2.0e-4].map(|nudge| {
            let footprint = Footprint::new(point.span_x, point.span_y, MOST_TAPS);
            footprint.request(layout, place, nudge)
        });
        let asked = nudged
            .map(|request| request.map(|request| (request.page(layout).unwrap(), request.steps())));
        possible.extend(asked.iter().flatten());
        if asked[0] == asked[2] {
            certain.extend(asked[1]);
        }
    }
    [certain, possible]
}

fn single_steps(asked: &PagesAsked) -> BTreeSet<(PageId, u32)> {
    let steps = |(&page, &steps): (&PageId, &u32)| {
        let bits = (0..PageRequest::STEP_BITS).map(|bit| 1 << bit);
        bits.filter(move |bit| steps & bit != 0).map(move |bit| (page, bit))
    };
    asked.iter().flat_map(steps).collect()
}

#[test]
fn the_list_the_whole_image_and_brute_force_give_the_same_pages() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::new(gpu, layout(), 0.0, true);
    let pixels = slanted_plane();
    let image = request_image(&stage, &pixels);

    let marks = PageMarks::new(&stage.gpu.device, &stage.layout, &stage.pages);
    let gather = GatherPagesPass::new(&stage.gpu.device, &marks, &stage.pages);
    let bytes = PageMarks::list_bytes(PageMarks::MOST_LISTED);
    let back = stage.gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = stage.gpu.device.create_command_encoder(&Default::default());
    // Twice: the second time finds nothing of the first.
    for _ in 0..2 {
        gather.record(&stage.gpu.device, &mut encoder, &image, &marks, &stage.pages);
    }
    assert_eq!(marks.copy_list(&mut encoder, &back, u32::MAX), bytes);
    stage.gpu.queue.submit([encoder.finish()]);
    let words = bytemuck::pod_collect_to_vec::<u8, u32>(&mapped(&stage.gpu, &back));
    let listed = bytemuck::cast_slice::<u32, PageRequest>(&words[2..2 + 2 * words[0] as usize]);
    let by_list = unite(&stage.layout, listed.iter().copied());
    assert_eq!(by_list.len(), listed.len(), "each page once");

    let texels = read_texture(&stage.gpu, &image.texture, IMAGE_PX, RequestImage::TEXEL_BYTES);
    let texels = bytemuck::pod_collect_to_vec::<u8, PageRequest>(&texels.unwrap());
    let by_image = unite(&stage.layout, texels);
    assert_eq!(by_list, by_image);

    let [certain, possible] = by_brute_force(&stage.layout, &pixels);
    let asked = single_steps(&by_image);
    println!(
        "{} pages, {} with their steps, of which rounding decides {}",
        by_list.len(),
        asked.len(),
        possible.difference(&certain).count()
    );
    assert!(by_list.len() > 60, "{}", by_list.len());
    assert!(certain.is_subset(&asked), "{:?}", certain.difference(&asked));
    assert!(asked.is_subset(&possible), "{:?}", asked.difference(&possible));
}

#[test]
fn one_pixel_of_each_block_sees_a_part_and_all_of_them_in_turn_everything() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::new(gpu, layout(), 0.0, true);
    let image = request_image(&stage, &slanted_plane());
    let texels = read_texture(&stage.gpu, &image.texture, IMAGE_PX, RequestImage::TEXEL_BYTES);
    let texels = bytemuck::pod_collect_to_vec::<u8, PageRequest>(&texels.unwrap());
    let all = single_steps(&unite(&stage.layout, texels));
    let device = &stage.gpu.device;
    let sample = SamplePagesPass::new(device, IMAGE_PX);
    let (mut seen, mut counts) = (BTreeSet::new(), Vec::new());
    for frame in 0..u64::from(SamplePagesPass::PERIOD) {
        let back = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: sample.bytes(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        sample.record((device, &stage.gpu.queue), &mut encoder, &image, frame, &back);
        stage.gpu.queue.submit([encoder.finish()]);
        let samples = bytemuck::pod_collect_to_vec::<u8, PageRequest>(&mapped(&stage.gpu, &back));
        let part = single_steps(&unite(&stage.layout, samples));
        assert!(part.is_subset(&all), "frame {frame}");
        counts.push(part.len());
        seen.extend(part);
    }
    println!(
        "of {} a frame sees {} to {}",
        all.len(),
        counts.iter().min().unwrap(),
        counts.iter().max().unwrap()
    );
    assert!(counts.iter().all(|count| *count < all.len()));
    assert_eq!(seen, all);
}

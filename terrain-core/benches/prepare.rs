//! What preparing and loading cost a tile, and a whole small area.

#![allow(clippy::unwrap_used, reason = "a step that fails ends the benchmark")]

use std::fs::File;
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use terrain_core::dataset::codec::{
    decode_colours, decode_heights, encode_colours, encode_height_steps,
};
use terrain_core::dataset::{
    ColourEncoding, ColourFormat, Dataset, DetailedSource, Shape, TileSource,
};
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::tiling::TileId;
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

const HEIGHT_TILE: u32 = 136;
const COLOUR_TILE: u32 = 392;
/// The area: heights of 30 m, a picture of 10 m.
const HEIGHTS_SIDE: u32 = 1024;
const PICTURE_SIDE: u32 = 3 * HEIGHTS_SIDE;

/// Hills with a little noise, in eighths of a metre.
fn height_steps() -> Vec<i32> {
    (0..HEIGHT_TILE * HEIGHT_TILE)
        .map(|index| {
            let (row, column) = (f64::from(index / HEIGHT_TILE), f64::from(index % HEIGHT_TILE));
            let noise = (index.wrapping_mul(2_654_435_761) >> 28) as i32;
            8 * ((300.0 * (0.05 * row).sin() * (0.03 * column).cos()) as i32) + noise
        })
        .collect()
}

fn picture(side: u32, samples: u32) -> Vec<u8> {
    (0..side * side)
        .flat_map(|index| {
            let (row, column) = (index / side, index % side);
            let noise = index.wrapping_mul(2_654_435_761) >> 28;
            [row / 5 + noise, column / 4 + noise, 90 + noise, 255].map(|part| part as u8)
        })
        .enumerate()
        .filter(|(index, _)| *index as u32 % 4 < samples)
        .map(|(_, byte)| byte)
        .collect()
}

fn tiles(criterion: &mut Criterion) {
    let steps = height_steps();
    let heights = encode_height_steps(&steps, HEIGHT_TILE, 0.125);
    let mut group = criterion.benchmark_group("height tile");
    group.throughput(Throughput::Elements(steps.len() as u64));
    group.bench_function("encode", |bencher| {
        bencher.iter(|| encode_height_steps(black_box(&steps), HEIGHT_TILE, 0.125));
    });
    group.bench_function("decode", |bencher| {
        bencher.iter(|| decode_heights(black_box(&heights), TileId::ROOT, HEIGHT_TILE).unwrap());
    });
    group.finish();

    let rgba = picture(COLOUR_TILE, 4);
    let mut group = criterion.benchmark_group("colour tile");
    group.throughput(Throughput::Elements(u64::from(COLOUR_TILE * COLOUR_TILE)));
    for (name, encoding, format) in [
        ("bc7", ColourEncoding::Bc7, ColourFormat::Bc7),
        ("bc1", ColourEncoding::Bc1, ColourFormat::Bc1),
        ("jpeg, bc7 when loaded", ColourEncoding::Jpeg, ColourFormat::Bc7),
    ] {
        let payload = encode_colours(&rgba, COLOUR_TILE, encoding).unwrap();
        group.bench_function(format!("encode {name}"), |bencher| {
            bencher.iter(|| encode_colours(black_box(&rgba), COLOUR_TILE, encoding).unwrap());
        });
        group.bench_function(format!("decode {name}"), |bencher| {
            bencher.iter(|| {
                decode_colours(black_box(&payload), TileId::ROOT, COLOUR_TILE, format).unwrap()
            });
        });
    }
    group.finish();
}

fn write_sources(folder: &Path) {
    let geo_keys: [u16; 16] = [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32632];
    let tie_point = [0.0, 0.0, 0.0, 432_000.0, 6_850_000.0, 0.0];
    macro_rules! write {
        ($name:literal, $colour:ty, $side:expr, $cell_m:expr, $data:expr) => {
            let mut encoder = TiffEncoder::new(File::create(folder.join($name)).unwrap()).unwrap();
            let mut image = encoder.new_image::<$colour>($side, $side).unwrap();
            let directory = image.encoder();
            directory.write_tag(Tag::ModelPixelScaleTag, &[$cell_m, $cell_m, 0.0][..]).unwrap();
            directory.write_tag(Tag::ModelTiepointTag, &tie_point[..]).unwrap();
            directory.write_tag(Tag::GeoKeyDirectoryTag, &geo_keys[..]).unwrap();
            image.write_data($data).unwrap();
        };
    }
    let heights: Vec<i16> = (0..HEIGHTS_SIDE * HEIGHTS_SIDE)
        .map(|index| {
            let (row, column) = (index / HEIGHTS_SIDE, index % HEIGHTS_SIDE);
            let wave = (0.01 * f64::from(row)).sin() * (0.013 * f64::from(column)).cos();
            (1200.0 + 900.0 * wave) as i16 + (index.wrapping_mul(2_654_435_761) >> 29) as i16
        })
        .collect();
    write!("dem.tif", colortype::GrayI16, HEIGHTS_SIDE, 30.0, &heights);
    write!("dom.tif", colortype::RGB8, PICTURE_SIDE, 10.0, &picture(PICTURE_SIDE, 3));
}

fn area(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    write_sources(folder.path());
    let path = |name: &str| folder.path().join(name);
    let request =
        PrepareRequest::new(vec![path("dem.tif")], vec![path("dom.tif")], path("dataset"));
    let mut group = criterion.benchmark_group("prepare");
    group.sample_size(10);
    group.throughput(Throughput::Elements(u64::from(PICTURE_SIDE * PICTURE_SIDE)));
    group.bench_function("1024 heights, 3072 colours", |bencher| {
        bencher.iter(|| prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap());
    });
    group.finish();
}

/// Tiles made up below a globe's imagery, of 512 texels: by how many levels down, and encoded how.
fn detail(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let (width, height) = (2048, 1024);
    let rgb = picture(width, 3);
    let path = folder.path().join("earth.png");
    let rows = rgb[..(3 * width * height) as usize].to_vec();
    image::RgbImage::from_raw(width, height, rows).unwrap().save(&path).unwrap();
    let mut group = criterion.benchmark_group("tile made up");
    group.sample_size(20);
    for encoding in [ColourEncoding::Rgba8, ColourEncoding::Bc7] {
        let request = PrepareRequest {
            shape: Shape::Globe,
            colour_tile_texels: 512,
            colour_encoding: encoding,
            ..PrepareRequest::new(vec![], vec![path.clone()], folder.path().join("dataset"))
        };
        prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
        let dataset = Arc::new(Dataset::open(&request.out).unwrap());
        let source = DetailedSource::new(dataset, 10, 1).unwrap();
        for level in [3, 5, 9] {
            let tile = TileId::new(level, (1 << level) / 5, (1 << level) / 3);
            group.bench_function(format!("{encoding:?}, level {level}"), |bencher| {
                bencher.iter(|| source.load_colours(black_box(tile)).unwrap());
            });
        }
    }
    group.finish();
}

criterion_group!(benches, tiles, area, detail);
criterion_main!(benches);

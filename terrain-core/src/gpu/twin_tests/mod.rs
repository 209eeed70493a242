//! What exists both in Rust and in WGSL, compared: struct layouts, and functions run on both with
//! the same seeded inputs.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a step that fails fails the test")]

mod derived_mips;
mod globe;
mod layouts;
mod mesh;
mod page_table;
mod random_field;
mod sampling;
mod sorted_triangles;
mod texture_map;
mod tile_management;
mod tile_selection;
mod view_mesh;

use crate::gpu::{AdapterChoice, GpuContext};

/// A GPU, or `None` where there is none and `TERRAIN_REQUIRE_GPU=1` does not demand one.
fn gpu() -> Option<GpuContext> {
    match GpuContext::headless(&AdapterChoice::Best) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            let required = std::env::var("TERRAIN_REQUIRE_GPU").is_ok_and(|value| value == "1");
            assert!(!required, "TERRAIN_REQUIRE_GPU=1, but: {error}");
            println!("SKIPPED, no GPU: {error}");
            None
        }
    }
}

/// What a buffer to be mapped holds, once all that was submitted is done.
fn mapped(gpu: &GpuContext, buffer: &wgpu::Buffer) -> Vec<u8> {
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    gpu.wait().unwrap();
    buffer.slice(..).get_mapped_range().unwrap().to_vec()
}

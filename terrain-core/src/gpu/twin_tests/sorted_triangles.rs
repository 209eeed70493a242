use glam::dvec2;

use super::gpu;
use super::mesh::{SCALE_M, mesh_scene};
use super::sampling::{COLUMNS, LAYOUT, Scene};
use crate::dataset::{ColourFormat, ColourTile};
use crate::frame_setup::frame_uniforms;
use crate::gpu::{
    FrameBindings, GpuContext, OFFSCREEN_FORMAT, OffscreenTarget, Picture, PictureTarget,
    SceneMeshes, TargetKind, TerrainCache, TerrainPass, TerrainPassSettings,
};
use crate::renderer_settings::{DebugView, RendererSettings};
use crate::residency::OffsetTable;
use crate::selection::LayerTree;
use crate::tiling::TileId;

/// A tile that looks like no other: one shade of red, green and blue growing across it.
fn colour_tile(tile: TileId) -> ColourTile {
    let size = LAYOUT.stored_size_texels();
    let shade = (u32::from(tile.level) * 97 + tile.row * 41 + tile.column * 59) as u8;
    let texel = |index: u32| [shade, (index % size * 6) as u8, (index / size * 6) as u8, 255];
    ColourTile {
        id: tile,
        stored_size_texels: size,
        format: ColourFormat::Rgba8,
        data: (0..size * size).flat_map(texel).collect(),
    }
}

/// Everything of a frame but its picture's settings.
struct Stage {
    bindings: FrameBindings,
    meshes: SceneMeshes,
    _cache: TerrainCache,
}

impl Stage {
    /// The scene's heights under imagery whose tiles are others: every second one.
    fn new(gpu: &GpuContext, scene: &mut Scene) -> Self {
        let present = scene.tree.heights.present.clone();
        scene.tree.colours = Some(LayerTree { layout: LAYOUT, present });
        let mut cache = scene.cache(gpu);
        let shown = scene.residents.iter().copied().step_by(2).collect::<Vec<_>>();
        let tiles = shown.iter().map(|&(tile, _)| colour_tile(tile)).collect::<Vec<_>>();
        let slots = shown.iter().map(|&(_, slot)| slot);
        let uploads = slots.zip(&tiles).collect::<Vec<_>>();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        cache.upload_colours(gpu, &mut encoder, &uploads);

        let view = scene.view();
        let (eye, colours) = (view.eye.truncate(), OffsetTable::build(shown));
        let tables = cache.update_tables(gpu, &scene.tree, eye, &scene.table, Some(&colours));
        let mut bindings =
            FrameBindings::new(&gpu.device, &cache.table, &cache.heights, &cache.colours);
        let settings = RendererSettings::default();
        let mut uniforms = frame_uniforms(&view, &scene.tree, &settings, SCALE_M);
        [uniforms.height_table, uniforms.colour_table] = tables.ranges;
        uniforms.height_uv_per_texel = cache.heights.grid.uv_per_texel();
        uniforms.colour_uv_per_texel = cache.colours.grid.uv_per_texel();
        bindings.frame.set_uniforms(&gpu.queue, &uniforms);
        let mut meshes = SceneMeshes::new(&gpu.device, &bindings, false);
        meshes.set_up(&gpu.device, &gpu.queue, &mesh_scene(scene, &view));
        let mut pass = encoder.begin_compute_pass(&Default::default());
        meshes.displace(&mut pass, &bindings, [true, false]);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        Self { bindings, meshes, _cache: cache }
    }

    fn draw(&self, gpu: &GpuContext, size_px: [u32; 2], settings: TerrainPassSettings) -> Vec<u8> {
        let target = OffscreenTarget::new(gpu, size_px);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let to = PictureTarget { view: target.view(), size_px, timestamps: None };
        let pass = TerrainPass::new(&gpu.device, &self.bindings, settings);
        Picture::default().record(&gpu.device, &mut encoder, settings.target, to, |target| {
            let mesh = self.meshes.picture().unwrap();
            pass.draw(target, &self.bindings, mesh.parts(), mesh.visible());
            Some(&self.bindings.frame)
        });
        gpu.queue.submit([encoder.finish()]);
        target.read_rgba8(gpu).unwrap()
    }
}

#[test]
fn sorted_triangles_draw_the_picture_that_looking_every_fragment_up_draws() {
    let Some(gpu) = gpu() else { return };
    let mut scene = Scene::new(dvec2(500_000.0, 6_800_000.0));
    let stage = Stage::new(&gpu, &mut scene);
    let size_px = scene.view().viewport_px;
    // With several taps both ways filter by the same code, and only a fragment on the border of two tiles
    // may find the other. The isotropic filter of the sampler, which only triangles within a tile can
    // use, chooses its mip by its own formula.
    for (anisotropy, most_differing, most_mean) in [(8, 1.0e-5, 0.001), (1, 0.01, 0.05)] {
        let [sorted, looked_up] = [true, false].map(|sorts_triangles| {
            let settings = TerrainPassSettings {
                target: TargetKind { format: OFFSCREEN_FORMAT, samples: 1 },
                linear_lookup: false,
                wireframe: false,
                has_colours: true,
                has_voids: false,
                anisotropy,
                sorts_triangles,
                debug_view: DebugView::Off,
            };
            stage.draw(&gpu, size_px, settings)
        });
        let distinct = sorted.chunks_exact(4).collect::<std::collections::HashSet<_>>().len();
        assert!(distinct > u32::from(u8::MAX) as usize * COLUMNS as usize, "{distinct} colours");
        let differences = sorted.iter().zip(&looked_up).map(|(a, b)| a.abs_diff(*b));
        let differing = differences.clone().filter(|difference| *difference > 0).count();
        let sum = differences.map(u64::from).sum::<u64>();
        let part = differing as f64 / sorted.len() as f64;
        let mean = sum as f64 / sorted.len() as f64;
        println!(
            "{anisotropy} taps: {part:.5} of all values differ, by {mean:.4} of 255 in the mean"
        );
        assert!(part <= most_differing && mean <= most_mean, "{anisotropy} taps");
    }
}

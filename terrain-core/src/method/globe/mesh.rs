//! The globe's mesh for a view, and its patches on the GPU.

use super::patch_slots::PatchSlots;
use crate::CameraView;
use crate::gpu::{DrawnPatch, GpuContext, PatchBuffers};
use crate::renderer_settings::RendererSettings;
use crate::surface::globe::{
    CoverSettings, GlobeCover, GlobeGround, GlobeSight, PatchStore, cover,
};
use crate::tiling::Extent;

/// Patches made, patches on the GPU, and those that show a view.
pub(super) struct GlobeMesh {
    pub store: PatchStore,
    pub buffers: PatchBuffers,
    slots: PatchSlots,
    covered: Option<Covered>,
    /// Counts changes of the ground.
    ground_version: u64,
    turns: u64,
    /// Counts changes of what is drawn of one view.
    pub version: u64,
}

/// A cover on the GPU, and what it is of.
struct Covered {
    view: CameraView,
    triangle_px: f64,
    ground_version: u64,
    cover: GlobeCover,
    drawn: Vec<DrawnPatch>,
}

/// What a change of the cover moved.
#[derive(Clone, Copy, Default)]
pub(super) struct MeshMoved {
    pub sent_bytes: u64,
    pub new: u64,
    pub evicted: u64,
}

impl GlobeMesh {
    /// Triangles in view at the most.
    const MOST_TRIANGLES: usize = 150_000;
    /// Patches on the GPU at the most, 8 KB each; those of a view of so many triangles are 293.
    const SLOTS: u32 = 512;
    /// How far in pixels the mesh may be seen from the ellipsoid between its vertices.
    const CURVE_PX: f64 = 0.25;
    /// Most patches made in a frame, some milliseconds of work, beside those whose ground has changed.
    const MOST_MADE: usize = 64;

    pub fn new(gpu: &GpuContext) -> Self {
        Self {
            store: PatchStore::default(),
            buffers: PatchBuffers::new(&gpu.device, &gpu.queue, Self::SLOTS),
            slots: PatchSlots::new(Self::SLOTS),
            covered: None,
            ground_version: 0,
            turns: 0,
            version: 0,
        }
    }

    /// The patches of the view covered last.
    pub fn drawn(&self) -> &[DrawnPatch] {
        self.covered.as_ref().map_or(&[], |covered| &covered.drawn)
    }

    /// Their cover and its view.
    pub fn cover(&self) -> Option<(&GlobeCover, &CameraView)> {
        self.covered.as_ref().map(|covered| (&covered.cover, &covered.view))
    }

    /// Both, with the patches made.
    pub fn cover_and_store(&mut self) -> Option<(&GlobeCover, &CameraView, &mut PatchStore)> {
        let covered = self.covered.as_ref()?;
        Some((&covered.cover, &covered.view, &mut self.store))
    }

    /// Triangles drawn.
    pub fn triangle_count(&self) -> u64 {
        self.drawn().iter().map(|patch| patch.triangles.len() as u64 / 3).sum()
    }

    /// Whether a view is not covered as finely as it will be.
    pub fn is_pending(&self, view: &CameraView, settings: &RendererSettings) -> bool {
        !settings.freeze_selection && !self.is_covered(view, settings)
    }

    /// Has the patches over changed ground made anew.
    pub fn ground_changed(&mut self, changed: &[Extent]) {
        if !changed.is_empty() {
            self.store.ground_changed(changed);
            self.ground_version += 1;
            self.version += 1;
        }
    }

    /// Has all patches made anew.
    pub fn all_changed(&mut self) {
        self.store.all_changed();
        self.ground_version += 1;
        self.version += 1;
    }

    /// Covers the view, unless that is done, and sends what is not on the GPU yet.
    pub fn show(
        &mut self,
        gpu: &GpuContext,
        ground: &GlobeGround,
        view: &CameraView,
        settings: &RendererSettings,
    ) -> MeshMoved {
        let is_kept = settings.freeze_selection
            && self.covered.as_ref().is_some_and(|c| c.ground_version == self.ground_version);
        if is_kept || self.is_covered(view, settings) {
            return MeshMoved::default();
        }
        let seen_from = match &self.covered {
            Some(covered) if settings.freeze_selection => covered.view,
            _ => *view,
        };
        let sight = GlobeSight::new(&seen_from, ground.lowest_m());
        let cover_settings = CoverSettings {
            cell_px: settings.triangle_px.max(1.0),
            curve_px: Self::CURVE_PX,
            most_triangles: Self::MOST_TRIANGLES,
            most_made: Self::most_made(settings.upload_budget_bytes),
        };
        let cover = cover(&mut self.store, ground, &sight, &cover_settings);
        let (drawn, moved) = self.send(gpu, ground, &cover);
        if let Some(before) = &self.covered {
            let same_view = before.view == seen_from;
            self.version += u64::from(same_view && before.drawn != drawn);
        }
        self.covered = Some(Covered {
            view: seen_from,
            triangle_px: settings.triangle_px,
            ground_version: self.ground_version,
            cover,
            drawn,
        });
        moved
    }

    /// How many patches may be made in a frame that may send so many bytes; some always may.
    fn most_made(budget_bytes: u64) -> usize {
        const LEAST: usize = 8;
        let within_budget = (budget_bytes / PatchBuffers::PATCH_BYTES) as usize;
        within_budget.clamp(LEAST, Self::MOST_MADE)
    }

    fn is_covered(&self, view: &CameraView, settings: &RendererSettings) -> bool {
        self.covered.as_ref().is_some_and(|covered| {
            covered.view == *view
                && covered.triangle_px == settings.triangle_px
                && covered.ground_version == self.ground_version
                && !covered.cover.is_unfinished
        })
    }

    fn send(
        &mut self,
        gpu: &GpuContext,
        ground: &GlobeGround,
        cover: &GlobeCover,
    ) -> (Vec<DrawnPatch>, MeshMoved) {
        self.turns += 1;
        let mut moved = MeshMoved::default();
        let mut drawn = Vec::with_capacity(cover.patches.len());
        for covered in &cover.patches {
            let (patch, serial) = self.store.get(covered.id, ground);
            // There are more slots than patches in a view of the most triangles.
            let Some(place) = self.slots.place(covered.id, serial, self.turns) else { break };
            if place.is_new {
                moved.new += 1;
                moved.evicted += u64::from(place.evicts);
                moved.sent_bytes += self.buffers.write(&gpu.queue, place.slot, patch);
            }
            let triangles = self.buffers.triangles(covered.coarse_edges);
            drawn.push(DrawnPatch { slot: place.slot, triangles });
        }
        (drawn, moved)
    }
}

//! What is drawn beside a dataset's own ground: models, each of whose steps follows the ground's own; and a TIN in
//! its place.

use std::sync::Arc;

use super::{RenderError, TerrainRenderer};
use crate::CameraView;
use crate::RendererSettings;
use crate::measure::{ByteCause, ByteTotals};
use crate::method::{FrameContext, GroundBelow, Moved, Objects, SceneState};
use crate::surface::models::ModelScene;
use crate::surface::tin::TinGround;

impl TerrainRenderer {
    /// Draws models beside the ground from the next frame on, or none. Whatever the strategy, they are drawn with
    /// a page table of their own; see [`crate::surface::models::TexturePack`].
    ///
    /// # Errors
    /// [`RenderError::Models`] where their textures are too large together; what was drawn before stays.
    pub fn set_models(&mut self, scene: Option<Arc<ModelScene>>) -> Result<(), RenderError> {
        let Self { gpu, settings, ledger, frame, .. } = self;
        let mut cx = FrameContext { gpu, settings, ledger, frame: *frame };
        let objects = scene.map(|scene| Objects::open(&mut cx, &scene)).transpose()?;
        self.gpu.check()?;
        self.objects = objects;
        // Whatever their version is, it is not what was drawn.
        self.drawn = None;
        Ok(())
    }

    /// Draws the ground of a TIN with the source's imagery, by a page table whatever the strategy, in place of the
    /// source's heights; or of these again. Begins with empty caches.
    ///
    /// # Errors
    /// [`RenderError`] where the caches cannot be made anew; what was drawn before stays.
    pub fn set_tin(&mut self, tin: Option<Arc<TinGround>>) -> Result<(), RenderError> {
        self.renew(self.settings, tin)
    }

    /// The ground drawn, where it is a TIN.
    pub fn tin(&self) -> Option<&Arc<TinGround>> {
        self.tin.as_ref()
    }

    /// The models drawn.
    pub fn models(&self) -> Option<&Arc<ModelScene>> {
        self.objects.as_ref().map(Objects::scene)
    }

    pub(super) fn objects_version(&self) -> u64 {
        self.objects.as_ref().map_or(0, Objects::version)
    }

    /// Has the models' choice made anew after a change of the settings, or them brought to the GPU anew.
    pub(super) fn reconsider_models(
        &mut self,
        before: &RendererSettings,
    ) -> Result<(), RenderError> {
        let is_made_for_them = Objects::made_for(before) == Objects::made_for(&self.settings);
        match &mut self.objects {
            Some(objects) if is_made_for_them => objects.reconsider(),
            Some(objects) => {
                let scene = Arc::clone(objects.scene());
                self.set_models(Some(scene))?;
            }
            None => {}
        }
        Ok(())
    }

    pub(super) fn receive_for_models(&mut self) {
        if let Some(objects) = &mut self.objects {
            objects.receive(self.frame);
        }
    }

    pub(super) fn select_for_models(&mut self, view: &CameraView) {
        if let Some(objects) = &mut self.objects {
            objects.select(&self.settings, view);
        }
    }

    /// Brings pages to the GPU within what the ground, which began with these totals, has left of the budget.
    /// Returns all that has moved.
    pub(super) fn stream_models(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        ground: Moved,
        before: &ByteTotals,
    ) -> Moved {
        let Self { gpu, settings, ledger, frame, objects: Some(objects), .. } = self else {
            return ground;
        };
        let tiles = |totals: &ByteTotals| totals.get(ByteCause::Dem) + totals.get(ByteCause::Dom);
        let sent = tiles(&ledger.totals()).saturating_sub(tiles(before));
        let budget_bytes = settings.upload_budget_bytes.saturating_sub(sent);
        let mut cx = FrameContext { gpu, settings, ledger, frame: *frame };
        let pages = objects.stream(&mut cx, encoder, budget_bytes);
        Moved { new: ground.new + pages.new, evicted: ground.evicted + pages.evicted }
    }

    pub(super) fn set_up_models(&mut self, scene: &SceneState) {
        let Self { gpu, source, settings, ledger, frame, method, objects: Some(objects), .. } =
            self
        else {
            return;
        };
        let mut cx = FrameContext { gpu, settings, ledger, frame: *frame };
        let ground = GroundBelow {
            tree: method.tree(),
            shape: source.manifest().shape,
            version: method.data_version(),
            height_m: &|point| method.ground_height_m(point),
        };
        objects.set_up(&mut cx, scene, &ground);
    }

    pub(super) fn ask_for_models(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) {
        let Self { gpu, settings, ledger, frame, objects: Some(objects), .. } = self else {
            return;
        };
        let mut cx = FrameContext { gpu, settings, ledger, frame: *frame };
        objects.ask(&mut cx, encoder, scene);
    }
}

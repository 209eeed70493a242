//! One virtual texture behind a page table, whatever it is drawn on: its pages' stream, their atlas and table
//! on the GPU, and what comes back of what pixels ask for. After the paper on GPU-visible tiles (a new method for
//! fast determination of visible texture tiles); what is resident is planned in
//! [`crate::residency::page_table`], whose page names the paper's tables, and what the GPU does is in
//! `gpu/page_table/`.
//!
//! Who draws with it brings the geometry: shaders that know their place in the texture (`common/page_table.wgsl`
//! and those that need it), with [`PagedTexture::bindings`] as group 2.

mod streamed_pages;

use std::time::Duration;

pub(crate) use self::streamed_pages::PagedSource;
use self::streamed_pages::StreamedPages;
use super::{FrameContext, ImageState, Moved};
use crate::CameraView;
use crate::dataset::ColourTile;
use crate::gpu::{PageAtlas, PageBindings, PageFeedbackRing, PageMarks, PageTableUniforms};
use crate::measure::{ByteCause, FrameRecord};
use crate::renderer_settings::RendererSettings;
use crate::residency::page_table::{
    PageId, PageLayout, PageRequest, PageUpload, PagesAsked, SeenPages, fitting,
};
use crate::terrain_renderer::RenderError;

/// A virtual texture.
///
/// A frame calls [`Self::receive`], [`Self::choose`], [`Self::stream`], [`Self::set_up`] and [`Self::ask`] in this
/// order, and draws with [`Self::bindings`] after them. None of them waits.
///
/// `texel_px` sets how large texels may be drawn: the levels of all footprints are log2 of it coarser. Where
/// more pages are seen than there is room for, all are drawn so many eighths of a level coarser that they fit.
pub(crate) struct PagedTexture {
    pages: StreamedPages,
    atlas: PageAtlas,
    bindings: PageBindings,
    feedback: PageFeedbackRing,
    seen: SeenPages,
    /// Eighths of a level that all pages are drawn coarser for them to fit.
    coarser_steps: i32,
    /// The pages chosen, beside those that are always resident.
    chosen_pages: Vec<PageId>,
    /// The view and the latest image's frame, if any, that pages were chosen for.
    chosen: Option<(CameraView, Option<u64>)>,
    /// What the latest images were asked for, and how many.
    asked: Option<(ImageState, u32)>,
    version: u64,
}

impl PagedTexture {
    /// Opens a texture and loads the pages that are always resident. The settings' cache is N1.
    ///
    /// # Errors
    /// [`RenderError`] where one of these cannot be loaded or the atlas is larger than textures can be.
    pub fn open(cx: &mut FrameContext<'_>, source: PagedSource) -> Result<Self, RenderError> {
        let (gpu, settings) = (cx.gpu, cx.settings);
        // Of no texture there is but a stub.
        let (slots, tile_texels) = match source.present.is_empty() {
            true => ((1, 1), 16),
            false => {
                let gutters = 2 * source.layout.gutter_texels;
                let slots = (settings.cache_columns, settings.cache_rows);
                (slots, source.layout.tile_size_texels + gutters)
            }
        };
        let atlas = PageAtlas::new(gpu, slots, tile_texels, source.format)?;
        let bindings = PageBindings::new(&gpu.device, &source.layout, &atlas);
        let feedback = PageFeedbackRing::new(&gpu.device, &source.layout, &bindings, settings);
        let pages = StreamedPages::open(source, slots.0 * slots.1, cx.ledger)?;
        Ok(Self {
            pages,
            atlas,
            bindings,
            feedback,
            seen: SeenPages::default(),
            coarser_steps: 0,
            chosen_pages: Vec::new(),
            chosen: None,
            asked: None,
            version: 0,
        })
    }

    /// The settings that a texture is made for; all others as they are by default.
    pub fn made_for(settings: &RendererSettings) -> RendererSettings {
        let RendererSettings {
            strategy,
            cache_columns,
            cache_rows,
            page_feedback,
            readback_latency_frames,
            ..
        } = *settings;
        RendererSettings {
            strategy,
            cache_columns,
            cache_rows,
            page_feedback,
            readback_latency_frames,
            ..Default::default()
        }
    }

    /// Whether there is a texture: its source has pages.
    pub fn has_any(&self) -> bool {
        self.pages.has_any()
    }

    /// How the texture is cut.
    pub fn layout(&self) -> &PageLayout {
        self.pages.stream.layout()
    }

    /// Group 2 of whoever draws with the texture or asks for its pages.
    pub fn bindings(&self) -> &PageBindings {
        &self.bindings
    }

    /// Counts the changes of what is shown.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Whether any page does not show as a whole yet: the shaders' `FADES`.
    pub fn is_fading(&self) -> bool {
        self.pages.stream.is_fading()
    }

    /// Takes what pixels of earlier frames asked for, if any of it has come back.
    pub fn receive(&mut self, frame: u64) {
        let back = self.feedback.take(self.pages.stream.layout(), frame);
        if back.is_cut_off {
            self.asked = None;
        }
        for image in back.images {
            self.seen.take(image, self.feedback.period());
        }
    }

    /// What the latest images asked for.
    pub fn asked(&self) -> PagesAsked {
        self.seen.asked()
    }

    /// Whether pages are to be chosen anew: the view has changed, or more has come back.
    pub fn wants_choice(&self, settings: &RendererSettings, view: &CameraView) -> bool {
        !settings.freeze_selection && self.chosen != Some(self.choice_for(view))
    }

    /// Chooses pages by what was asked for last.
    pub fn choose(&mut self, settings: &RendererSettings, view: &CameraView) {
        let asked = self.seen.asked();
        let layout = self.pages.stream.layout();
        let most_pages = settings.max_tiles.saturating_sub(layout.resident_pages().count());
        let serving = |page| self.pages.serving(page);
        let (coarser_steps, pages) = fitting(layout, &asked, most_pages, serving);
        self.pages.stream.request(&pages);
        self.chosen_pages = pages;
        self.version += u64::from(coarser_steps != self.coarser_steps);
        self.coarser_steps = coarser_steps;
        self.chosen = Some(self.choice_for(view));
    }

    /// Has the choice made anew in the next frame.
    pub fn reconsider(&mut self) {
        self.chosen = None;
    }

    /// Takes what has been loaded, brings it to the GPU within the budget and asks for what is missing.
    pub fn stream(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        budget_bytes: u64,
    ) -> Moved {
        let (uploads, has_failed) = self.pages.update(budget_bytes, cx.ledger);
        if has_failed {
            self.chosen = None;
        }
        let stream = &mut self.pages.stream;
        let content = |upload: &PageUpload| Some((upload.slot, stream.payload(upload.page)?));
        let tiles: Vec<(u32, &ColourTile)> = uploads.iter().filter_map(content).collect();
        cx.ledger.add(ByteCause::Dom, self.atlas.upload(&cx.gpu.queue, encoder, &tiles));
        let side_texels = u64::from(self.atlas.grid().slot_size_texels);
        cx.ledger.add_texels(ByteCause::Dom, tiles.len() as u64 * side_texels * side_texels);
        let changed = stream.take_changed();
        self.version += u64::from(!changed.is_empty());
        cx.ledger.add(ByteCause::Table, self.bindings.set_entries(&cx.gpu.queue, &changed));
        let evicted = uploads.iter().filter(|upload| upload.evicted.is_some()).count();
        Moved { new: uploads.len() as u64, evicted: evicted as u64 }
    }

    /// Brings the table's parameters to the GPU.
    pub fn set_up(&mut self, cx: &mut FrameContext<'_>, settings: &RendererSettings) {
        let request_bias = settings.texel_px.log2() as f32;
        let lookup_bias = request_bias + self.coarser_steps as f32 / PageRequest::STEPS as f32;
        let layout = self.pages.stream.layout();
        let biases = [request_bias, lookup_bias];
        let table = PageTableUniforms::new(layout, self.atlas.grid(), biases);
        cx.ledger.add(ByteCause::Uniform, self.bindings.set_uniforms(&cx.gpu.queue, &table));
    }

    /// Whether not all images of a state have been asked for yet.
    pub fn wants_image(&self, state: &ImageState) -> bool {
        let period = self.feedback.period();
        let has_all = |(asked, images)| asked == *state && images >= period;
        let needs_any = !state.settings.freeze_selection && self.has_any();
        needs_any && !self.asked.is_some_and(has_all)
    }

    /// Asks for what the pixels of a state need, unless that was done already; returns whether it did. `draw`
    /// draws what each pixel asks for (`common/page_request.wgsl`), all groups but group 2 its own.
    pub fn ask(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        state: ImageState,
        draw: impl FnOnce(&mut wgpu::RenderPass<'_>, &PageBindings),
    ) -> bool {
        if !self.wants_image(&state) || !self.feedback.is_free() {
            return false;
        }
        let Self { feedback, bindings, .. } = self;
        let gpu = (&cx.gpu.device, &cx.gpu.queue);
        let size_px = state.view.viewport_px;
        let bytes = feedback.record(gpu, encoder, size_px, bindings, |pass| draw(pass, bindings));
        self.has_asked(cx, state, bytes)
    }

    /// [`Self::ask`] where pages are found otherwise than by asking pixels: `mark` marks those of the layout it is
    /// given (`common/page_marks.wgsl`).
    pub fn ask_marked(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        state: ImageState,
        mark: impl FnOnce(&mut wgpu::CommandEncoder, (&PageLayout, &PageMarks), &PageBindings),
    ) -> bool {
        if !self.wants_image(&state) || !self.feedback.is_free() {
            return false;
        }
        let Self { feedback, bindings, pages, .. } = self;
        let size_px = state.view.viewport_px;
        let bytes =
            feedback.record_marked(&cx.gpu.device, encoder, size_px, bindings, |encoder, marks| {
                mark(encoder, (pages.stream.layout(), marks), bindings)
            });
        self.has_asked(cx, state, bytes)
    }

    /// What pages are marked in.
    pub fn marks(&self) -> &PageMarks {
        self.feedback.marks()
    }

    /// Notes that so many bytes have been asked for, if any.
    fn has_asked(
        &mut self,
        cx: &mut FrameContext<'_>,
        state: ImageState,
        bytes: Option<u64>,
    ) -> bool {
        let Some(bytes) = bytes else { return false };
        cx.ledger.add(ByteCause::Readback, bytes);
        let before = self.asked.filter(|(asked, _)| *asked == state);
        self.asked = Some((state, before.map_or(0, |(_, images)| images) + 1));
        true
    }

    /// After the frame's commands have been submitted.
    pub fn after_submit(&mut self, frame: u64, view: &CameraView) {
        self.feedback.begin(frame, view);
    }

    /// Pages wanted that are not resident yet but will be.
    pub fn missing(&self) -> usize {
        self.pages.missing()
    }

    /// Whether pages or answers are still to come for a state.
    pub fn is_pending(&self, state: &ImageState) -> bool {
        self.missing() > 0
            || self.is_fading()
            || self.feedback.is_waiting()
            || self.wants_image(state)
            || self.wants_choice(&state.settings, &state.view)
    }

    /// Fills in what the record tells of pages as its tiles.
    pub fn describe(&self, record: &mut FrameRecord) {
        let layout = self.layout();
        let finest = self.chosen_pages.first().map_or(layout.coarsest_level, |page| page.level);
        record.tiles_selected = (self.chosen_pages.len() + layout.resident_pages().count()) as u64;
        record.tiles_missing = self.missing() as u64;
        record.tiles_resident = self.pages.stream.resident()[0] as u64;
        record.finest_level = layout.coarsest_level - finest;
        record.region_age_frames = self.image_age_frames(record.frame);
    }

    /// Waits until everything asked for is loaded, at most for `patience`.
    pub fn wait(&self, patience: Duration) {
        self.pages.wait(patience);
    }

    /// Takes what went wrong with single pages since the last call, in words.
    pub fn take_failures(&mut self) -> Vec<String> {
        self.pages.take_failures()
    }

    /// The atlas, to be looked at.
    pub fn atlas_view(&self) -> wgpu::TextureView {
        self.atlas.mip(0)
    }

    /// What a choice for the view by the latest image is made for.
    fn choice_for(&self, view: &CameraView) -> (CameraView, Option<u64>) {
        (*view, self.seen.latest().map(|(frame, _)| frame))
    }

    /// How many frames ago the latest image was drawn; 0 where the camera has not moved since.
    fn image_age_frames(&self, frame: u64) -> Option<u64> {
        let (seen_in, seen_from) = self.seen.latest()?;
        let is_current = self.chosen.is_some_and(|(view, _)| view == seen_from);
        Some(if is_current { 0 } else { frame - seen_in })
    }
}

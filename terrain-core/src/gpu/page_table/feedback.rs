use super::gather_pass::GatherPagesPass;
use super::page_bindings::PageBindings;
use super::page_marks::PageMarks;
use super::request_image::RequestImage;
use super::sample_pass::SamplePagesPass;
use crate::CameraView;
use crate::gpu::readback_ring::ReadbackRing;
use crate::renderer_settings::RendererSettings;
use crate::residency::page_table::{PageFeedback, PageImage, PageLayout, PageRequest, unite};
use crate::selection::Strategy;

/// Finds the pages that a frame's pixels ask for and brings them back without waiting for the GPU, in one of
/// three ways; see [`PageFeedback`].
pub(crate) struct PageFeedbackRing {
    way: PageFeedback,
    latency_frames: u32,
    gather: GatherPagesPass,
    marks: PageMarks,
    /// What depends on the size of the frame; `None` before the first.
    sized: Option<OfSize>,
    /// Pages of the list that the next copy takes along.
    listed: u32,
    /// The copy recorded in this frame, until it is submitted.
    recorded: Option<(wgpu::Buffer, u32)>,
    turns: u64,
}

struct OfSize {
    size_px: [u32; 2],
    /// Where pixels are asked.
    image: Option<RequestImage>,
    sample: Option<SamplePagesPass>,
    ring: ReadbackRing<Ticket>,
}

/// The frame and the camera that a readback is of.
#[derive(Clone, Copy)]
struct Ticket {
    frame: u64,
    view: CameraView,
    /// Pages of the list that were copied.
    listed: u32,
}

/// What has come back.
pub(crate) struct PagesReadBack {
    /// What pixels asked for, oldest first.
    pub images: Vec<PageImage>,
    /// Whether a list came back that was longer than was copied of it: to be asked for anew.
    pub is_cut_off: bool,
}

impl PageFeedbackRing {
    /// Buffers of the ring: one being drawn, one on its way, one being read, and as many as are held back.
    const BUFFERS: u32 = 3;
    /// Pages of the first list that are read back.
    const FIRST_LISTED: u32 = 256;
    /// Pages that are always read back.
    const LEAST_LISTED: u32 = 16;

    pub fn new(
        device: &wgpu::Device,
        layout: &PageLayout,
        pages: &PageBindings,
        settings: &RendererSettings,
    ) -> Self {
        let marks = PageMarks::new(device, layout, pages);
        Self {
            way: match settings.strategy {
                Strategy::TextureMap => PageFeedback::List,
                _ => settings.page_feedback,
            },
            latency_frames: settings.readback_latency_frames,
            gather: GatherPagesPass::new(device, &marks, pages),
            marks,
            sized: None,
            listed: Self::FIRST_LISTED,
            recorded: None,
            turns: 0,
        }
    }

    /// Images that make up all that a frame's pixels ask for.
    pub fn period(&self) -> u32 {
        match self.way {
            PageFeedback::List | PageFeedback::Full => 1,
            PageFeedback::Jittered => SamplePagesPass::PERIOD,
        }
    }

    /// What pages are marked in.
    pub fn marks(&self) -> &PageMarks {
        &self.marks
    }

    /// Whether another image can be asked for.
    pub fn is_free(&self) -> bool {
        self.sized.as_ref().is_none_or(|sized| sized.ring.has_free())
    }

    /// Whether an image is on its way.
    pub fn is_waiting(&self) -> bool {
        self.sized.as_ref().is_some_and(|sized| sized.ring.is_waiting())
    }

    /// Records the stages and the copy of what they find, if a buffer is free; `draw` draws everything that
    /// has the texture on it. Returns the bytes that come back. [`Self::begin`] follows the submission.
    pub fn record(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        encoder: &mut wgpu::CommandEncoder,
        size_px: [u32; 2],
        pages: &PageBindings,
        draw: impl FnOnce(&mut wgpu::RenderPass<'_>),
    ) -> Option<u64> {
        let (way, listed) = (self.way, self.listed);
        let buffers = Self::BUFFERS + self.latency_frames;
        let Self { gather, marks, turns, .. } = self;
        let sized = Self::of_size(&mut self.sized, (device, way, size_px), buffers);
        let OfSize { image, sample, ring, .. } = sized;
        if !ring.has_free() {
            return None;
        }
        let image = &*image.get_or_insert_with(|| RequestImage::new(device, size_px));
        image.record(encoder, draw);
        let mut bytes = 0;
        let buffer = match (way, sample) {
            (PageFeedback::Jittered, Some(sample)) => ring.record_with(|buffer| {
                bytes = sample.record((device, queue), encoder, image, *turns, buffer);
            }),
            (PageFeedback::Full, _) => {
                bytes = OfSize::full_bytes(size_px);
                ring.record(encoder, &image.texture)
            }
            _ => {
                gather.record(device, encoder, image, marks, pages);
                ring.record_with(|buffer| bytes = marks.copy_list(encoder, buffer, listed))
            }
        };
        *turns += 1;
        self.recorded = buffer.map(|buffer| (buffer, listed));
        self.recorded.is_some().then_some(bytes)
    }

    /// [`Self::record`] of pages that are found otherwise than by asking pixels: `mark` marks them. To be used with
    /// [`PageFeedback::List`].
    pub fn record_marked(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        size_px: [u32; 2],
        pages: &PageBindings,
        mark: impl FnOnce(&mut wgpu::CommandEncoder, &PageMarks),
    ) -> Option<u64> {
        let buffers = Self::BUFFERS + self.latency_frames;
        let Self { way, marks, listed, .. } = self;
        let ring = &mut Self::of_size(&mut self.sized, (device, *way, size_px), buffers).ring;
        if !ring.has_free() {
            return None;
        }
        marks.clear(encoder);
        mark(encoder, marks);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("list pages"),
            timestamp_writes: None,
        });
        marks.complete(&mut pass, pages);
        drop(pass);
        let mut bytes = 0;
        let buffer = ring.record_with(|buffer| bytes = marks.copy_list(encoder, buffer, *listed));
        self.recorded = buffer.map(|buffer| (buffer, *listed));
        self.recorded.is_some().then_some(bytes)
    }

    /// What is needed for frames of a size. What is on its way from frames of another size is let go.
    fn of_size<'a>(
        sized: &'a mut Option<OfSize>,
        (device, way, size_px): (&wgpu::Device, PageFeedback, [u32; 2]),
        buffers: u32,
    ) -> &'a mut OfSize {
        let made = match sized.take() {
            Some(made) if made.size_px == size_px => made,
            _ => OfSize::new(device, way, size_px, buffers),
        };
        sized.insert(made)
    }

    /// Asks for what was recorded in this frame, after its submission.
    pub fn begin(&mut self, frame: u64, view: &CameraView) {
        if let (Some((buffer, listed)), Some(sized)) = (self.recorded.take(), &mut self.sized) {
            sized.ring.begin(buffer, Ticket { frame, view: *view, listed });
        }
    }

    /// What has come back since the last call and is due in this frame. Never waits.
    pub fn take(&mut self, layout: &PageLayout, frame: u64) -> PagesReadBack {
        let mut back = PagesReadBack { images: Vec::new(), is_cut_off: false };
        let Some(sized) = &mut self.sized else { return back };
        let latency_frames = u64::from(self.latency_frames);
        let is_due = |ticket: &Ticket| ticket.frame + latency_frames <= frame;
        while let Some(readback) = sized.ring.take_if(is_due) {
            let Ticket { frame, view, listed } = readback.metadata;
            let words = bytemuck::pod_collect_to_vec::<u8, u32>(&readback.bytes);
            let requests = match self.way {
                PageFeedback::List => {
                    let count = words.first().copied().unwrap_or(0);
                    let next = (count + count / 4).next_power_of_two();
                    self.listed = next.clamp(Self::LEAST_LISTED, PageMarks::MOST_LISTED);
                    back.is_cut_off = count.min(PageMarks::MOST_LISTED) > listed;
                    if back.is_cut_off {
                        continue;
                    }
                    let head = (PageMarks::HEAD_BYTES / 4) as usize;
                    let listed = 2 * count.min(PageMarks::MOST_LISTED) as usize;
                    &words[head..head + listed]
                }
                PageFeedback::Full | PageFeedback::Jittered => &words[..],
            };
            let requests =
                bytemuck::cast_slice::<u32, PageRequest>(&requests[..requests.len() & !1]);
            let asked = unite(layout, requests.iter().copied());
            back.images.push(PageImage { asked, frame, view });
        }
        back
    }
}

impl OfSize {
    fn new(device: &wgpu::Device, way: PageFeedback, size_px: [u32; 2], buffers: u32) -> Self {
        let sample = (way == PageFeedback::Jittered).then(|| SamplePagesPass::new(device, size_px));
        let ring = match (&sample, way) {
            (Some(sample), _) => ReadbackRing::of_bytes(device, buffers, sample.bytes() as u32),
            (None, PageFeedback::Full) => {
                ReadbackRing::new(device, buffers, size_px, RequestImage::TEXEL_BYTES)
            }
            (None, _) => {
                let bytes = PageMarks::list_bytes(PageMarks::MOST_LISTED);
                ReadbackRing::of_bytes(device, buffers, bytes as u32)
            }
        };
        Self { size_px, image: None, sample, ring }
    }

    fn full_bytes([width, height]: [u32; 2]) -> u64 {
        u64::from(width) * u64::from(height) * u64::from(RequestImage::TEXEL_BYTES)
    }
}

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

/// Measures the time the GPU takes for a frame, by timestamps at its beginning and end, read back
/// some frames later. Without timestamp queries it measures nothing.
pub(crate) struct FrameTimer {
    inner: Option<Timer>,
    latest_ms: Option<f64>,
}

struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
    state: State,
    period_ns: f64,
}

enum State {
    Free,
    Recorded,
    Waiting(Arc<AtomicU8>),
}

impl FrameTimer {
    const BYTES: u64 = 16;

    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let inner = device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| {
            let buffer = |label, usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size: Self::BYTES,
                    usage,
                    mapped_at_creation: false,
                })
            };
            use wgpu::BufferUsages as Usage;
            Timer {
                queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("frame time"),
                    ty: wgpu::QueryType::Timestamp,
                    count: 2,
                }),
                resolved: buffer("timestamps", Usage::QUERY_RESOLVE | Usage::COPY_SRC),
                readback: buffer("timestamp readback", Usage::COPY_DST | Usage::MAP_READ),
                state: State::Free,
                period_ns: f64::from(queue.get_timestamp_period()),
            }
        });
        Self { inner, latest_ms: None }
    }

    /// Begins a measurement unless the one before is still on its way.
    pub fn begin(&mut self) -> bool {
        self.inner.as_ref().is_some_and(|timer| matches!(timer.state, State::Free))
    }

    /// Records the stamp of the frame's beginning: an empty pass, as which pass comes first depends on
    /// what has arrived.
    pub fn stamp_beginning(&self, encoder: &mut wgpu::CommandEncoder, measuring: bool) {
        if let Some(timer) = self.inner.as_ref().filter(|_| measuring) {
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("beginning of the frame"),
                timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                    query_set: &timer.queries,
                    beginning_of_pass_write_index: Some(0),
                    end_of_pass_write_index: None,
                }),
            });
        }
    }

    /// The stamp for the last pass of the frame.
    pub fn last_pass(&self, measuring: bool) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let timer = self.inner.as_ref().filter(|_| measuring)?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set: &timer.queries,
            beginning_of_pass_write_index: None,
            end_of_pass_write_index: Some(1),
        })
    }

    /// Records the copy of the stamps.
    pub fn resolve(&mut self, encoder: &mut wgpu::CommandEncoder, measuring: bool) {
        if let Some(timer) = self.inner.as_mut().filter(|_| measuring) {
            encoder.resolve_query_set(&timer.queries, 0..2, &timer.resolved, 0);
            encoder.copy_buffer_to_buffer(&timer.resolved, 0, &timer.readback, 0, Self::BYTES);
            timer.state = State::Recorded;
        }
    }

    /// Asks for the stamps; to be called after the submission.
    pub fn after_submit(&mut self) {
        let Some(timer) = &mut self.inner else { return };
        if matches!(timer.state, State::Recorded) {
            let state = Arc::new(AtomicU8::new(0));
            let mapped = Arc::clone(&state);
            timer.readback.slice(..).map_async(wgpu::MapMode::Read, move |result| {
                mapped.store(if result.is_ok() { 1 } else { 2 }, Ordering::Release);
            });
            timer.state = State::Waiting(state);
        }
    }

    /// Milliseconds of the latest frame whose stamps are back; `None` before the first, without queries
    /// or where that frame's stamps cannot be read.
    pub fn latest_ms(&mut self) -> Option<f64> {
        let timer = self.inner.as_mut()?;
        if let State::Waiting(state) = &timer.state {
            let answer = state.load(Ordering::Acquire);
            if answer == 1 {
                self.latest_ms = read_ms(&timer.readback, timer.period_ns);
                timer.readback.unmap();
            }
            if answer == 2 {
                self.latest_ms = None;
            }
            if answer != 0 {
                timer.state = State::Free;
            }
        }
        self.latest_ms
    }
}

fn read_ms(buffer: &wgpu::Buffer, period_ns: f64) -> Option<f64> {
    let view = buffer.slice(..).get_mapped_range().ok()?;
    let stamps: &[u64] = bytemuck::try_cast_slice(&view).ok()?;
    let ticks = stamps.get(1)?.checked_sub(*stamps.first()?)?;
    Some(ticks as f64 * period_ns * 1.0e-6)
}

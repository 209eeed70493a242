use super::manage_tiles_pass::ManageTilesPass;
use super::readback_ring::ReadbackRing;
use super::tile_management::TileManagement;
use super::tile_report::TileReport;

/// Brings the reports of the tile management back without waiting for the GPU.
///
/// Of the lists of missing tiles as much is read back as the last report lets expect: while little is
/// missing, 64 bytes. What is missing beyond that is read in the next frame.
pub(crate) struct TileReportRing {
    ring: ReadbackRing<Ticket>,
    /// The frame the GPU's report is of, where it has not been read back as a whole.
    owed: Option<u64>,
    /// Tiles of each layer's list that the next copy takes along.
    listed: [u32; 2],
    /// The copy recorded in this frame, until it is submitted.
    recorded: Option<(wgpu::Buffer, Ticket)>,
}

#[derive(Clone, Copy)]
struct Ticket {
    frame: u64,
    listed: [u32; 2],
}

impl TileReportRing {
    const BUFFERS: u32 = 3;
    /// Tiles of a list that are always read back: with the head 64 bytes in all.
    const LEAST_LISTED: u32 = 3;

    pub fn new(device: &wgpu::Device) -> Self {
        Self {
            ring: ReadbackRing::of_bytes(
                device,
                Self::BUFFERS,
                ManageTilesPass::REPORT_BYTES as u32,
            ),
            owed: None,
            listed: [Self::LEAST_LISTED; 2],
            recorded: None,
        }
    }

    /// Notes that the GPU's report is of this frame from now on.
    pub fn expect(&mut self, frame: u64) {
        self.owed = Some(frame);
    }

    /// Whether a report is on its way or still to be asked for.
    pub fn is_waiting(&self) -> bool {
        self.owed.is_some() || self.ring.is_waiting()
    }

    /// Records the copy of the report, where one is owed and a buffer is free. Returns the bytes.
    pub fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        management: &TileManagement,
    ) -> u64 {
        let Some(frame) = self.owed else { return 0 };
        let listed = self.listed;
        let mut bytes = 0;
        let buffer =
            self.ring.record_with(|buffer| bytes = management.copy_report(encoder, buffer, listed));
        if let Some(buffer) = buffer {
            self.recorded = Some((buffer, Ticket { frame, listed }));
            self.owed = None;
        }
        bytes
    }

    /// Asks for the report whose copy was recorded, after its submission.
    pub fn begin(&mut self) {
        if let Some((buffer, ticket)) = self.recorded.take() {
            self.ring.begin(buffer, ticket);
        }
    }

    /// The oldest report that has come back since the last call, and the frame it is of. Never waits.
    pub fn take(&mut self) -> Option<(TileReport, u64)> {
        let readback = self.ring.take_if(|_| true)?;
        let Ticket { frame, listed } = readback.metadata;
        let report = TileReport::from_bytes(&readback.bytes, listed);
        let missed = [0, 1].map(|layer| report.layers[layer].listed > listed[layer]);
        self.listed = [0, 1].map(|layer: usize| {
            let next = report.layers[layer].listed.next_power_of_two();
            next.clamp(Self::LEAST_LISTED, ManageTilesPass::MOST_ASKED)
        });
        if missed.contains(&true) && !self.is_waiting() {
            self.owed = Some(frame);
        }
        Some((report, frame))
    }
}

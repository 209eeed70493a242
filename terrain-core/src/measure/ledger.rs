use serde::{Deserialize, Serialize};

/// Why bytes moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ByteCause {
    /// Height tiles to the GPU.
    Dem,
    /// Colour tiles to the GPU.
    Dom,
    /// Offset tables to the GPU.
    Table,
    /// Vertices, indices and lists of blocks to the GPU.
    Mesh,
    /// Uniforms and other parameters to the GPU.
    Uniform,
    /// From the GPU.
    Readback,
    /// From disk or network, as stored (compressed).
    Disk,
}

impl ByteCause {
    /// All causes.
    pub const ALL: [Self; 7] =
        [Self::Dem, Self::Dom, Self::Table, Self::Mesh, Self::Uniform, Self::Readback, Self::Disk];

    /// Whether the bytes went to the GPU.
    pub fn is_upload(self) -> bool {
        !matches!(self, Self::Readback | Self::Disk)
    }
}

/// Bytes by cause, and the texels in them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ByteTotals {
    bytes: [u64; ByteCause::ALL.len()],
    texels: [u64; ByteCause::ALL.len()],
}

impl ByteTotals {
    /// Bytes that moved for the cause.
    pub fn get(&self, cause: ByteCause) -> u64 {
        self.bytes[cause as usize]
    }

    /// Texels that moved for the cause, however many bytes they took.
    pub fn texels(&self, cause: ByteCause) -> u64 {
        self.texels[cause as usize]
    }

    /// Bytes to the GPU, all causes together.
    pub fn upload_bytes(&self) -> u64 {
        ByteCause::ALL
            .iter()
            .filter(|cause| cause.is_upload())
            .fold(0, |sum, &cause| sum.saturating_add(self.get(cause)))
    }
}

/// Counts the bytes of a frame where they move.
#[derive(Clone, Debug, Default)]
pub struct FrameLedger {
    totals: ByteTotals,
}

impl FrameLedger {
    /// Counts bytes that have moved.
    pub fn add(&mut self, cause: ByteCause, bytes: u64) {
        let total = &mut self.totals.bytes[cause as usize];
        *total = total.saturating_add(bytes);
    }

    /// Counts the texels, gutters included, that bytes counted for the cause hold.
    pub fn add_texels(&mut self, cause: ByteCause, texels: u64) {
        let total = &mut self.totals.texels[cause as usize];
        *total = total.saturating_add(texels);
    }

    /// Counts what another ledger has counted.
    pub fn add_all(&mut self, totals: &ByteTotals) {
        for cause in ByteCause::ALL {
            self.add(cause, totals.get(cause));
            self.add_texels(cause, totals.texels(cause));
        }
    }

    /// What has been counted since [`FrameLedger::take`].
    pub fn totals(&self) -> ByteTotals {
        self.totals
    }

    /// What has been counted since the last call; counting begins anew.
    pub fn take(&mut self) -> ByteTotals {
        std::mem::take(&mut self.totals)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_is_counted_once_under_its_cause() {
        let mut ledger = FrameLedger::default();
        for (power, cause) in ByteCause::ALL.into_iter().enumerate() {
            ledger.add(cause, 10_u64.pow(power as u32));
            ledger.add(cause, 10_u64.pow(power as u32));
            ledger.add_texels(cause, power as u64);
        }
        let mut sum = FrameLedger::default();
        sum.add_all(&ledger.totals());
        assert_eq!(sum.totals(), ledger.totals());
        let totals = ledger.take();
        assert_eq!(totals.texels(ByteCause::Disk), 6);
        assert_eq!(totals.get(ByteCause::Dem), 2);
        assert_eq!(totals.get(ByteCause::Disk), 2_000_000);
        assert_eq!(totals.upload_bytes(), 22_222, "readback and disk are no uploads");
        assert_eq!(ledger.take(), ByteTotals::default(), "taking begins anew");
    }

    #[test]
    fn an_overflow_saturates() {
        let mut ledger = FrameLedger::default();
        ledger.add(ByteCause::Dem, u64::MAX);
        ledger.add(ByteCause::Dem, 1);
        ledger.add(ByteCause::Dom, 1);
        assert_eq!(ledger.totals().upload_bytes(), u64::MAX);
    }
}

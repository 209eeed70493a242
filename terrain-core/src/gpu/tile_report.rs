use crate::residency::TileInSlot;

/// What the GPU reports of the tiles it manages, as `Report` in `manage_tiles.wgsl` packs it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct TileReport {
    /// By layer: heights, colours.
    pub layers: [LayerReport; 2],
    /// Tiles of the selection.
    pub selected: u32,
    /// Finest level of the selection.
    pub finest_level: u8,
    /// Tiles the selection left out because they are hidden.
    pub hidden: u32,
}

/// What the GPU reports of one layer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct LayerReport {
    /// Wanted tiles that are not resident and can be had.
    pub missing: u32,
    /// Tiles that have a slot and are to be loaded: all that were listed.
    pub listed: u32,
    /// Resident tiles.
    pub resident: u32,
    /// As many of the listed tiles as were read back, most urgent first.
    pub asked: Vec<TileInSlot>,
}

impl TileReport {
    /// Bytes in front of the lists.
    pub const HEAD_BYTES: u64 = 16;

    /// The report in these bytes, of which room was made for `listed` tiles a layer. Missing bytes are
    /// taken as zeros.
    pub fn from_bytes(bytes: &[u8], listed: [u32; 2]) -> Self {
        let words = bytemuck::pod_collect_to_vec::<u8, [u32; 2]>(bytes);
        let [heads, [selected, hidden]] =
            [0, 1].map(|index| words.get(index).copied().unwrap_or_default());
        let mut lists = words.get(2..).unwrap_or_default();
        let layers = [0, 1].map(|layer| {
            let head = heads[layer];
            let (list, rest) = lists.split_at(lists.len().min(listed[layer] as usize));
            lists = rest;
            let count = (head >> 11 & 0x3f).min(list.len() as u32);
            LayerReport {
                missing: head & 0x7ff,
                listed: head >> 11 & 0x3f,
                resident: head >> 17 & 0x7ff,
                asked: bytemuck::cast_slice(&list[..count as usize]).to_vec(),
            }
        });
        let finest_level = (selected >> 16) as u8;
        Self { layers, selected: selected & 0xffff, finest_level, hidden }
    }
}

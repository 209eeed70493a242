use serde::{Deserialize, Serialize};

use super::error::MeasuredErrors;
use super::{ByteCause, ByteTotals};

/// What one frame did and what it cost: a row of `frames.csv`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameRecord {
    /// How tiles were selected: a strategy's name.
    pub strategy: String,
    /// Number of the frame, from 0.
    pub frame: u64,
    /// Time in the flight, seconds.
    pub time_s: f64,
    /// From the beginning of the frame to its end, the GPU's work included, milliseconds.
    pub frame_ms: f64,
    /// Work of the CPU, waiting not counted, milliseconds.
    pub cpu_ms: f64,
    /// Work of the GPU by its own timestamps, milliseconds; `None` where it has none. Of a frame that
    /// was not waited for, that of the latest picture whose timestamps were back.
    pub gpu_ms: Option<f64>,
    /// Selection of tiles on the CPU, milliseconds. This and the five that follow are the stages of
    /// `cpu_ms`, in their order but for this one.
    pub select_ms: f64,
    /// Taking in what the GPU has sent back, milliseconds.
    pub receive_ms: f64,
    /// Taking in what was loaded, handing it to the GPU and asking for more, milliseconds.
    pub stream_ms: f64,
    /// Tables, uniforms and meshes, milliseconds.
    pub set_up_ms: f64,
    /// Recording the picture's commands, and those of what later frames need to know, milliseconds.
    pub draw_ms: f64,
    /// Submitting the commands, milliseconds.
    pub submit_ms: f64,
    /// Tiles selected, before each layer maps them to those it has.
    pub tiles_selected: u64,
    /// Tiles left out before merging because no pixel saw them, though the box round all that was seen
    /// holds them; 0 where all of the box counts as visible.
    pub tiles_hidden: u64,
    /// Tiles uploaded, both layers.
    pub tiles_new: u64,
    /// Tiles wanted but not resident yet, both layers.
    pub tiles_missing: u64,
    /// Tiles evicted, both layers.
    pub tiles_evicted: u64,
    /// Tiles resident after the frame, both layers.
    pub tiles_resident: u64,
    /// Bytes read from disk or network, as stored.
    pub disk_bytes: u64,
    /// Bytes to the GPU: the sum of the five that follow.
    pub upload_bytes: u64,
    /// Bytes of height tiles to the GPU.
    pub upload_dem_bytes: u64,
    /// Bytes of colour tiles to the GPU.
    pub upload_dom_bytes: u64,
    /// Bytes of offset tables to the GPU.
    pub upload_table_bytes: u64,
    /// Bytes of meshes to the GPU.
    pub upload_mesh_bytes: u64,
    /// Bytes of uniforms and other parameters to the GPU.
    pub upload_uniform_bytes: u64,
    /// Bytes read back from the GPU.
    pub readback_bytes: u64,
    /// Texels of heights among the bytes to the GPU, gutters included.
    pub upload_dem_texels: u64,
    /// Texels of colour among the bytes to the GPU, gutters included.
    pub upload_dom_texels: u64,
    /// How many frames ago the region that tiles were selected by was drawn; `None` before the
    /// first, and for a strategy that goes without.
    pub region_age_frames: Option<u64>,
    /// Finest level selected.
    pub finest_level: u8,
    /// Whether the frame drew a coordinate pass.
    pub coordinate_pass_drawn: bool,
    /// Blocks of the mesh drawn.
    pub blocks_drawn: u64,
    /// Triangles of the mesh drawn.
    pub triangles_drawn: u64,
    /// What was measured of the picture.
    #[serde(flatten)]
    pub errors: MeasuredErrors,
}

impl FrameRecord {
    /// Fills in every column of bytes.
    pub fn set_bytes(&mut self, totals: &ByteTotals) {
        self.disk_bytes = totals.get(ByteCause::Disk);
        self.upload_bytes = totals.upload_bytes();
        self.upload_dem_bytes = totals.get(ByteCause::Dem);
        self.upload_dom_bytes = totals.get(ByteCause::Dom);
        self.upload_table_bytes = totals.get(ByteCause::Table);
        self.upload_mesh_bytes = totals.get(ByteCause::Mesh);
        self.upload_uniform_bytes = totals.get(ByteCause::Uniform);
        self.readback_bytes = totals.get(ByteCause::Readback);
        self.upload_dem_texels = totals.texels(ByteCause::Dem);
        self.upload_dom_texels = totals.texels(ByteCause::Dom);
    }

    /// The columns of tiles by name.
    pub fn tile_columns(&self) -> [(&'static str, u64); 6] {
        [
            ("tiles_selected", self.tiles_selected),
            ("tiles_hidden", self.tiles_hidden),
            ("tiles_new", self.tiles_new),
            ("tiles_missing", self.tiles_missing),
            ("tiles_evicted", self.tiles_evicted),
            ("tiles_resident", self.tiles_resident),
        ]
    }

    /// The columns of bytes by name: the file's, the sum to the GPU, its five parts, the readback.
    pub fn byte_columns(&self) -> [(&'static str, u64); 8] {
        [
            ("disk_bytes", self.disk_bytes),
            ("upload_bytes", self.upload_bytes),
            ("upload_dem_bytes", self.upload_dem_bytes),
            ("upload_dom_bytes", self.upload_dom_bytes),
            ("upload_table_bytes", self.upload_table_bytes),
            ("upload_mesh_bytes", self.upload_mesh_bytes),
            ("upload_uniform_bytes", self.upload_uniform_bytes),
            ("readback_bytes", self.readback_bytes),
        ]
    }

    /// The columns of milliseconds on the CPU by name, in the order of a frame's stages.
    pub fn stage_columns(&self) -> [(&'static str, f64); 6] {
        [
            ("receive_ms", self.receive_ms),
            ("select_ms", self.select_ms),
            ("stream_ms", self.stream_ms),
            ("set_up_ms", self.set_up_ms),
            ("draw_ms", self.draw_ms),
            ("submit_ms", self.submit_ms),
        ]
    }

    /// The record without what depends on a clock, which is the same whenever the same is drawn.
    #[must_use]
    pub fn without_times(self) -> Self {
        Self {
            frame_ms: 0.0,
            cpu_ms: 0.0,
            gpu_ms: None,
            select_ms: 0.0,
            receive_ms: 0.0,
            stream_ms: 0.0,
            set_up_ms: 0.0,
            draw_ms: 0.0,
            submit_ms: 0.0,
            ..self
        }
    }

    /// Takes in the work of a later frame: counts, bytes and times add up; what describes the state
    /// after a frame becomes the later frame's.
    pub fn add_work_of(&mut self, later: &Self) {
        let earlier = std::mem::replace(self, later.clone());
        self.frame_ms += earlier.frame_ms;
        self.cpu_ms += earlier.cpu_ms;
        self.select_ms += earlier.select_ms;
        self.receive_ms += earlier.receive_ms;
        self.stream_ms += earlier.stream_ms;
        self.set_up_ms += earlier.set_up_ms;
        self.draw_ms += earlier.draw_ms;
        self.submit_ms += earlier.submit_ms;
        self.tiles_new += earlier.tiles_new;
        self.tiles_evicted += earlier.tiles_evicted;
        self.disk_bytes += earlier.disk_bytes;
        self.upload_bytes += earlier.upload_bytes;
        self.upload_dem_bytes += earlier.upload_dem_bytes;
        self.upload_dom_bytes += earlier.upload_dom_bytes;
        self.upload_table_bytes += earlier.upload_table_bytes;
        self.upload_mesh_bytes += earlier.upload_mesh_bytes;
        self.upload_uniform_bytes += earlier.upload_uniform_bytes;
        self.readback_bytes += earlier.readback_bytes;
        self.upload_dem_texels += earlier.upload_dem_texels;
        self.upload_dom_texels += earlier.upload_dom_texels;
        self.coordinate_pass_drawn |= earlier.coordinate_pass_drawn;
    }

    /// The first line of `frames.csv`, without a line break.
    pub fn csv_header() -> String {
        let names = Self::default().columns().into_iter().map(|(name, _)| name);
        names.collect::<Vec<_>>().join(",")
    }

    /// The record as a line of `frames.csv`, without a line break. What is not known is empty.
    pub fn csv_row(&self) -> String {
        let values = self.columns().into_iter().map(|(_, value)| value);
        values.collect::<Vec<_>>().join(",")
    }

    fn columns(&self) -> Vec<(&'static str, String)> {
        let optional = |value: Option<String>| value.unwrap_or_default();
        let ms = |ms: f64| format!("{ms:.4}");
        let count = |(name, count): (&'static str, u64)| (name, count.to_string());
        let mut columns = vec![
            ("strategy", csv_field(&self.strategy)),
            ("frame", self.frame.to_string()),
            ("time_s", format!("{:.6}", self.time_s)),
            ("frame_ms", ms(self.frame_ms)),
            ("cpu_ms", ms(self.cpu_ms)),
            ("gpu_ms", optional(self.gpu_ms.map(ms))),
            ("select_ms", ms(self.select_ms)),
            ("receive_ms", ms(self.receive_ms)),
            ("stream_ms", ms(self.stream_ms)),
            ("set_up_ms", ms(self.set_up_ms)),
            ("draw_ms", ms(self.draw_ms)),
            ("submit_ms", ms(self.submit_ms)),
        ];
        columns.extend(self.tile_columns().map(count));
        columns.extend(self.byte_columns().map(count));
        columns.extend([
            ("upload_dem_texels", self.upload_dem_texels.to_string()),
            ("upload_dom_texels", self.upload_dom_texels.to_string()),
            ("region_age_frames", optional(self.region_age_frames.map(|age| age.to_string()))),
            ("finest_level", self.finest_level.to_string()),
            ("coordinate_pass_drawn", self.coordinate_pass_drawn.to_string()),
            ("blocks_drawn", self.blocks_drawn.to_string()),
            ("triangles_drawn", self.triangles_drawn.to_string()),
        ]);
        let errors = self.errors.columns().into_iter();
        columns.extend(
            errors.map(|(name, error)| (name, optional(error.map(|error| format!("{error:.6}"))))),
        );
        columns
    }
}

/// Quotes the text where CSV (RFC 4180) needs it.
fn csv_field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::super::FrameLedger;
    use super::*;

    #[test]
    fn the_columns_are_the_fields_in_their_order() {
        let json = serde_json::to_string(&FrameRecord::default()).unwrap();
        let header = FrameRecord::csv_header();
        let mut rest = json.as_str();
        for column in header.split(',') {
            let key = format!("\"{column}\":");
            let place =
                rest.find(&key).unwrap_or_else(|| panic!("{column} not in order in {json}"));
            rest = &rest[place + key.len()..];
        }
        let fields = serde_json::to_value(FrameRecord::default()).unwrap();
        assert_eq!(fields.as_object().unwrap().len(), header.split(',').count());
    }

    #[test]
    fn unknown_values_are_empty_and_awkward_text_is_quoted() {
        let record = FrameRecord { strategy: "a,\"b\"".into(), frame: 3, ..FrameRecord::default() };
        let row = record.csv_row();
        assert!(
            row.starts_with("\"a,\"\"b\"\"\",3,0.000000,0.0000,0.0000,,0.0000,0.0000,"),
            "{row}"
        );
    }

    #[test]
    fn every_cause_has_its_column() {
        let mut ledger = FrameLedger::default();
        for (power, cause) in ByteCause::ALL.into_iter().enumerate() {
            ledger.add(cause, 1 << power);
        }
        let mut record = FrameRecord::default();
        record.set_bytes(&ledger.take());
        let parts = record.upload_dem_bytes
            + record.upload_dom_bytes
            + record.upload_table_bytes
            + record.upload_mesh_bytes
            + record.upload_uniform_bytes;
        assert_eq!(record.upload_bytes, parts);
        assert_eq!(parts + record.readback_bytes + record.disk_bytes, 0b111_1111);
    }
}

use super::Study;
use crate::precision::encodings::Verdict;

/// A table with the name of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedTable {
    /// Without folder or extension.
    pub name: &'static str,
    /// Names of the columns, with units.
    pub header: Vec<&'static str>,
    /// Cells, a row as long as the header.
    pub rows: Vec<Vec<String>>,
}

impl NamedTable {
    /// Comma-separated values with a header line. No cell holds a comma.
    pub fn to_csv(&self) -> String {
        let lines = self.rows.iter().map(|row| row.join(",") + "\n");
        self.header.join(",") + "\n" + &lines.collect::<String>()
    }
}

/// Every table of the study, all rows.
pub fn tables(study: &Study) -> Vec<NamedTable> {
    vec![
        spans(study),
        natives(study),
        positions(study),
        places(study),
        grounds(study),
        depth(study),
    ]
}

fn cell(value: f64) -> String {
    format!("{value:.6e}")
}

fn optional(value: Option<impl ToString>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

/// Rows measured on the CPU, each with its twin measured on the GPU, where there was one.
fn with_twins<'a, T>(
    cpu: &'a [T],
    gpu: Option<&'a [T]>,
) -> impl Iterator<Item = (&'a T, Option<&'a T>)> {
    cpu.iter().enumerate().map(move |(index, row)| (row, gpu.map(|rows| &rows[index])))
}

fn spans(study: &Study) -> NamedTable {
    let rows = study.spans.iter().map(|row| {
        vec![
            cell(row.half_pixel_rad),
            cell(row.range),
            cell(row.leading_zeros),
            cell(row.normal_dot_bits),
            row.cpu.normal_dot.to_string(),
            optional(row.gpu_f32.map(|bits| bits.normal_dot)),
            optional(row.gpu_f64.map(|bits| bits.normal_dot)),
            cell(row.texture_bits),
            row.cpu.texture.to_string(),
            optional(row.gpu_f32.map(|bits| bits.texture)),
            optional(row.gpu_f64.map(|bits| bits.texture)),
            row.component_bits.to_string(),
            cell(row.direction_bits),
        ]
    });
    NamedTable {
        name: "span-bits",
        header: vec![
            "half_pixel_rad",
            "range",
            "leading_zeros",
            "normal_dot_derived",
            "normal_dot_cpu",
            "normal_dot_gpu_f32",
            "normal_dot_gpu_f64",
            "texture_derived",
            "texture_cpu",
            "texture_gpu_f32",
            "texture_gpu_f64",
            "normal_dot_of_rounded_components",
            "two_directions",
        ],
        rows: rows.collect(),
    }
}

fn natives(study: &Study) -> NamedTable {
    let rows = study.natives.iter().map(|row| {
        vec![
            row.significant_bits.to_string(),
            cell(row.half_pixel_rad),
            cell(row.range),
            cell(row.predicted_texels),
            cell(row.measured_texels),
            cell(row.effective_bits),
            row.holds.to_string(),
        ]
    });
    NamedTable {
        name: "native-floats",
        header: vec![
            "significant_bits",
            "half_pixel_rad",
            "range",
            "derived_texels",
            "measured_texels",
            "effective_bits",
            "within_a_sixteenth",
        ],
        rows: rows.collect(),
    }
}

fn positions(study: &Study) -> NamedTable {
    let gpu = study.encodings.gpu.as_ref().map(|errors| &errors.positions[..]);
    let rows = with_twins(&study.encodings.cpu.positions, gpu).map(|(row, on_gpu)| {
        vec![
            row.encoding.name().to_owned(),
            cell(row.cell.magnitude_m),
            cell(row.cell.height_m),
            cell(row.cell.grazing_deg),
            cell(row.cell.fov_deg),
            row.cell.level.to_string(),
            cell(row.cell.distance_m),
            cell(row.worst_m),
            cell(row.worst_pixels),
            optional(on_gpu.map(|row| cell(row.worst_m))),
            optional(on_gpu.map(|row| cell(row.worst_pixels))),
        ]
    });
    NamedTable {
        name: "encoding-positions",
        header: vec![
            "encoding",
            "coordinates_m",
            "eye_height_m",
            "grazing_deg",
            "fov_deg",
            "level",
            "distance_m",
            "cpu_m",
            "cpu_pixels",
            "gpu_m",
            "gpu_pixels",
        ],
        rows: rows.collect(),
    }
}

fn places(study: &Study) -> NamedTable {
    let gpu = study.encodings.gpu.as_ref().map(|errors| &errors.places[..]);
    let rows = with_twins(&study.encodings.cpu.places, gpu).map(|(row, on_gpu)| {
        vec![
            row.encoding.name().to_owned(),
            cell(row.cell.magnitude_m),
            row.cell.level.to_string(),
            cell(row.cell.fov_deg),
            cell(row.worst_texels),
            optional(on_gpu.map(|row| cell(row.worst_texels))),
        ]
    });
    NamedTable {
        name: "encoding-places",
        header: vec!["encoding", "coordinates_m", "level", "fov_deg", "cpu_texels", "gpu_texels"],
        rows: rows.collect(),
    }
}

fn depth(study: &Study) -> NamedTable {
    let rows = study.depth.iter().map(|row| {
        vec![
            row.kind.name().replace(',', ""),
            cell(row.distance_m),
            cell(row.step_m),
            cell(row.cpu_gap_m),
            optional(row.gpu_gap_m.map(cell)),
        ]
    });
    NamedTable {
        name: "depth",
        header: vec!["kind", "distance_m", "step_m", "cpu_gap_m", "gpu_gap_m"],
        rows: rows.collect(),
    }
}

fn grounds(study: &Study) -> NamedTable {
    let gpu = study.encodings.gpu.as_ref().map(|errors| &errors.grounds[..]);
    let rows = with_twins(&study.encodings.cpu.grounds, gpu).map(|(row, on_gpu)| {
        vec![
            row.encoding.name().to_owned(),
            cell(row.cell.magnitude_m),
            row.cell.level.to_string(),
            cell(row.cell.texel_m),
            cell(row.shift_m),
            cell(row.height_m),
            optional(on_gpu.map(|row| cell(row.shift_m))),
            optional(on_gpu.map(|row| cell(row.height_m))),
        ]
    });
    NamedTable {
        name: "encoding-grounds",
        header: vec![
            "encoding",
            "coordinates_m",
            "level",
            "texel_m",
            "cpu_shift_m",
            "cpu_height_m",
            "gpu_shift_m",
            "gpu_height_m",
        ],
        rows: rows.collect(),
    }
}

/// Which encoding keeps which part of the contract, for people.
pub(super) fn verdict_table(verdicts: &[Verdict]) -> Vec<[String; 6]> {
    let told = |verdict: &Verdict| {
        let mark = |index: usize| if verdict.holds[index] { "" } else { " (fails)" };
        [
            verdict.encoding.name().to_owned(),
            format!("{:.3} mm{}", verdict.near_m.value * 1.0e3, mark(0)),
            format!("{:.4} px{}", verdict.far_pixels.value, mark(1)),
            format!("{:.5} texels{}", verdict.texels.value, mark(2)),
            format!("{:.3} mm{}", verdict.ground_m.value * 1.0e3, mark(3)),
            if verdict.is_kept() { "kept" } else { "broken" }.to_owned(),
        ]
    };
    verdicts.iter().map(told).collect()
}

use super::tables::verdict_table;
use super::{
    DepthRow, FloatFindings, NamedPlot, NativeSummary, SpanSummary, Study, Summary, plots,
};
use crate::measure::report::{HtmlReport, PlotError};
use crate::precision::encodings::Verdict;

/// Width and height in pixels of a plot on the page.
const PLOT_PX: [u32; 2] = [720, 420];

/// The study as a page that holds all it shows. `machine` says what it was measured on.
///
/// # Errors
/// [`PlotError`] where a plot cannot be drawn.
pub fn report_page(study: &Study, machine: &str) -> Result<String, PlotError> {
    let title = "Precision of places, texture coordinates and depth";
    let mut page =
        Page { html: HtmlReport::new(title), study, summary: study.summary(), plots: plots(study) };
    page.html.paragraph(machine).paragraph(&adapter_line(study));
    page.write_spans()?;
    page.write_floats()?;
    page.write_encodings()?;
    page.write_depth()?;
    Ok(page.html.to_html())
}

/// The page while it is written, a section a function.
struct Page<'a> {
    html: HtmlReport,
    study: &'a Study,
    summary: Summary,
    plots: Vec<NamedPlot>,
}

impl Page<'_> {
    /// Every plot whose name begins so.
    fn figures(&mut self, prefix: &str) -> Result<(), PlotError> {
        for plot in self.plots.iter().filter(|plot| plot.name.starts_with(prefix)) {
            self.html.figure(&plot.plot.to_svg(PLOT_PX)?, &plot.caption);
        }
        Ok(())
    }

    fn write_spans(&mut self) -> Result<(), PlotError> {
        let header = ["half a pixel", "ranges", "N.V", "texture", "components", "two directions"];
        self.html
            .heading("Bits of a span's dot products")
            .table(&header, &span_table(&self.summary))
            .paragraph(
                "Bits. N.V and texture: the farthest that derived and tried bits lie apart anywhere \
                 between straight below and the horizon, on the CPU and on the device. Components: the \
                 most that rounding the vectors' components, instead of the dot product, needs beyond \
                 the derived bits. Two directions: how far the literal reading of the paper lies from \
                 the derived bits of N.V.",
            );
        self.figures("span-bits")
    }

    fn write_floats(&mut self) -> Result<(), PlotError> {
        let Some(floats) = &self.study.floats else { return Ok(()) };
        let header = [
            "bits of the format",
            "half a pixel",
            "bits found",
            "beyond 1/16 texel",
            "exact",
            "overflows from",
        ];
        self.html
            .heading("The device's own floats")
            .table(&["operation", "tried", "not as IEEE 754 has it"], &float_table(floats))
            .table(&header, &native_table(&self.summary))
            .paragraph("The last three columns are ranges: ground distance over height.");
        self.figures("native")
    }

    fn write_encodings(&mut self) -> Result<(), PlotError> {
        let header = [
            "encoding",
            "position within 1 km",
            "position beyond",
            "texture coordinate",
            "height within 1 km",
            "contract",
        ];
        let encodings = &self.study.encodings;
        self.html
            .heading("Encodings of places")
            .paragraph("On the CPU, in the same f32 operations as the shaders:")
            .table(&header, &verdict_table(&encodings.cpu_verdicts));
        if let Some(verdicts) = &encodings.gpu_verdicts {
            let apart = format!(
                "Points for which the lookup's fixed-point position differed between CPU and device: {}.",
                encodings.positions_apart
            );
            self.html
                .paragraph("On the device:")
                .table(&header, &verdict_table(verdicts))
                .table(
                    &["encoding", "numbers", "apart", "steps of an f32"],
                    &twin_table(self.study),
                )
                .paragraph(&apart);
        }
        let verdicts = encodings.gpu_verdicts.as_ref().unwrap_or(&encodings.cpu_verdicts);
        self.html.paragraph("Where each was worst:").table(&header[..5], &places(verdicts));
        self.figures("encodings")
    }

    fn write_depth(&mut self) -> Result<(), PlotError> {
        let header = ["depth", "distance, m", "step, m", "gap on the CPU, m", "gap drawn, m"];
        self.html.heading("Depth").table(&header, &depth_table(&self.summary));
        self.figures("depth")
    }
}

fn adapter_line(study: &Study) -> String {
    match &study.adapter {
        Some(adapter) => format!("Device: {adapter}."),
        None => "No graphics adapter: everything below was computed on the CPU, in the same f32 \
                 operations as the shaders."
            .to_owned(),
    }
}

fn span_table(summary: &Summary) -> Vec<[String; 6]> {
    let row = |span: &SpanSummary| {
        let [above, below] = span.directions_beyond;
        [
            format!("2^{:.0}", span.half_pixel_rad.log2()),
            span.ranges.to_string(),
            format!("{:.2}", span.normal_dot_apart),
            format!("{:.2}", span.texture_apart),
            format!("{:.2}", span.components_beyond),
            format!("{below:+.1} to {above:+.1}"),
        ]
    };
    summary.spans.iter().map(row).collect()
}

fn native_table(summary: &Summary) -> Vec<[String; 6]> {
    let row = |native: &NativeSummary| {
        let [least, most] = native.effective_bits;
        let fails = native.fails_within;
        [
            native.significant_bits.to_string(),
            format!("2^{:.0}", native.half_pixel_rad.log2()),
            format!("{least:.1} to {most:.1}"),
            fails.map_or("nowhere".to_owned(), |[from, to]| format!("{from:.3} to {to:.1}")),
            native.exact_to.map_or("nowhere".to_owned(), |range| format!("to {range:.3}")),
            native.overflows_from.map_or("never".to_owned(), |range| format!("{range:.0}")),
        ]
    };
    summary.natives.iter().map(row).collect()
}

fn depth_table(summary: &Summary) -> Vec<[String; 5]> {
    let row = |row: &DepthRow| {
        [
            row.kind.name().to_owned(),
            format!("{:.3e}", row.distance_m),
            format!("{:.2e}", row.step_m),
            format!("{:.2e}", row.cpu_gap_m),
            row.gpu_gap_m.map_or(String::new(), |gap_m| format!("{gap_m:.2e}")),
        ]
    };
    summary.depth.iter().map(row).collect()
}

fn float_table(floats: &FloatFindings) -> Vec<[String; 3]> {
    let row = |name: &str, tried: usize, off: usize| {
        [name, &tried.to_string(), &off.to_string()].map(str::to_owned)
    };
    vec![
        row("a * b + c, two roundings (off: contracted to one)", floats.telling, floats.contracted),
        row("fma(a, b, c)", floats.tried, floats.fma_unfused),
        row("a / b", floats.tried, floats.quotients_off),
        row("error of a sum (Knuth)", floats.tried, floats.sum_errors_off),
        row("error of a product (Dekker)", floats.tried, floats.product_errors_off),
    ]
}

fn twin_table(study: &Study) -> Vec<[String; 4]> {
    let row = |twin: &super::TwinRow| {
        [
            twin.encoding.name().to_owned(),
            twin.numbers.to_string(),
            twin.apart.to_string(),
            twin.most_ulps.to_string(),
        ]
    };
    study.encodings.twins.iter().map(row).collect()
}

fn places(verdicts: &[Verdict]) -> Vec<[String; 5]> {
    let row = |verdict: &Verdict| {
        [
            verdict.encoding.name().to_owned(),
            verdict.near_m.at.clone(),
            verdict.far_pixels.at.clone(),
            verdict.texels.at.clone(),
            verdict.ground_m.at.clone(),
        ]
    };
    verdicts.iter().map(row).collect()
}

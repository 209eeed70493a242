//! The study's outcome as tables, plots and a page.

use std::fmt::Write;

use super::comparison::GroundComparison;
use super::study::{FilteredPixel, StudyCase, StudySettings};
use crate::measure::report::{HtmlReport, Plot, PlotError, ReportPicture, Series, SeriesStyle};

/// The cases run with one set of settings.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct StudyRun {
    /// What the settings are called.
    pub name: String,
    /// The settings.
    pub settings: StudySettings,
    /// The cases.
    pub cases: Vec<StudyCase>,
}

const TABLE_HEADER: [&str; 13] = [
    "settings",
    "border deg",
    "part of the interval",
    "distance m",
    "method, largest %",
    "method, mean %",
    "trilinear, largest %",
    "trilinear, mean %",
    "anisotropic 16, largest %",
    "anisotropic 64, largest %",
    "method to anisotropic, largest %",
    "trilinear to anisotropic, largest %",
    "bytes a triangle",
];

/// Size in pixels of a plot.
const PLOT_PX: [u32; 2] = [640, 360];

/// Numbers of every case, a row each: errors in per cent of the range from black to white, against
/// the ideal filter where nothing else is said.
fn table_rows(runs: &[StudyRun]) -> Vec<[String; 13]> {
    let percent = |part: f64| format!("{:.2}", 100.0 * part);
    let row = |run: &StudyRun, case: &StudyCase| {
        [
            run.name.clone(),
            format!("{}", case.place.border_deg),
            format!("{}", case.place.part),
            format!("{:.0}", case.distance_m),
            percent(case.limit_error.largest),
            percent(case.limit_error.mean),
            percent(case.trilinear_error.largest),
            percent(case.trilinear_error.mean),
            percent(case.anisotropic_16_error.largest),
            percent(case.anisotropic_64_error.largest),
            percent(case.limit_to_anisotropic.largest),
            percent(case.trilinear_to_anisotropic.largest),
            format!("{:.2}", case.memory.colour_bytes_per_triangle()),
        ]
    };
    runs.iter().flat_map(|run| run.cases.iter().map(|case| row(run, case))).collect()
}

/// The table of all cases as CSV.
pub fn study_table_csv(runs: &[StudyRun]) -> String {
    let mut csv = TABLE_HEADER.join(",").replace("method, ", "method ");
    csv = csv.replace("trilinear, ", "trilinear ").replace("16, ", "16 ").replace("64, ", "64 ");
    csv = csv.replace("anisotropic, ", "anisotropic ") + "\n";
    for row in table_rows(runs) {
        let _ = writeln!(csv, "{}", row.join(","));
    }
    csv
}

/// The profile across the border of a case, a row a pixel, as CSV.
pub fn study_profile_csv(case: &StudyCase) -> String {
    let mut csv = "pixel,ideal,anisotropic 16,anisotropic 64,trilinear,method\n".to_owned();
    for (pixel, p) in case.profile.iter().enumerate() {
        let values = [p.ideal, p.anisotropic_16, p.anisotropic_64, p.trilinear, p.limit];
        let values = values.map(|value| format!("{value:.5}")).join(",");
        let _ = writeln!(csv, "{pixel},{values}");
    }
    csv
}

/// The profile of a case as a plot.
pub fn study_plot(run: &StudyRun, case: &StudyCase) -> Plot {
    let near_border = case.profile.iter().map(|pixel| pixel.ideal).enumerate();
    let middle = near_border
        .min_by(|a, b| (a.1 - 0.5).abs().total_cmp(&(b.1 - 0.5).abs()))
        .map_or(0, |(pixel, _)| pixel);
    let series = |name: &str, style: SeriesStyle, of: fn(&FilteredPixel) -> f64| Series {
        name: name.to_owned(),
        style,
        points: (middle.saturating_sub(5)..(middle + 6).min(case.profile.len()))
            .map(|pixel| [pixel as f64, of(&case.profile[pixel])])
            .collect(),
    };
    Plot {
        title: format!(
            "Border at {}°, {} of an interval ({})",
            case.place.border_deg, case.place.part, run.name
        ),
        x_label: "pixel across the border".to_owned(),
        y_label: "white part".to_owned(),
        series: vec![
            series("ideal", SeriesStyle::Line, |p| p.ideal),
            series("anisotropic, 64 rays", SeriesStyle::Dashed, |p| p.anisotropic_64),
            series("anisotropic, 16 rays", SeriesStyle::Points, |p| p.anisotropic_16),
            series("trilinear, 16 rays", SeriesStyle::Dashed, |p| p.trilinear),
            series("limit-triangulated, 16 rays", SeriesStyle::Line, |p| p.limit),
        ],
        ..Plot::default()
    }
}

/// What holds in words.
fn findings(run: &StudyRun) -> String {
    let most = |of: fn(&StudyCase) -> f64| run.cases.iter().map(of).fold(0.0, f64::max);
    let below = run.cases.iter().filter(|c| c.limit_error.largest <= c.trilinear_error.largest);
    format!(
        "{}: a cone of {} of a pixel, triangles of {} of the cone at the least distance. The \
         method's error is at most {:.1} % against the ideal filter and {:.1} % against anisotropic \
         filtering with as many rays; it is not above trilinear filtering's in {} of {} cases.",
        run.name,
        run.settings.angle_share,
        run.settings.triangle_share,
        100.0 * most(|case| case.limit_error.largest),
        100.0 * most(|case| case.limit_to_anisotropic.largest),
        below.count(),
        run.cases.len(),
    )
}

/// The page: tables, a plot a case, and the pictures of a comparison on a dataset's ground.
///
/// # Errors
/// Where a plot cannot be drawn.
pub fn study_page(
    runs: &[StudyRun],
    grounds: &[GroundComparison],
    pictures: &[ReportPicture],
) -> Result<String, PlotError> {
    let mut page = HtmlReport::new("Limit-triangulated surface");
    page.heading("A plane half black, half white").paragraph(
        "Seen straight on; errors in per cent of the range over all pixels that the border \
         touches, against the exact white part of the pixel's square where nothing else is said. \
         Distances lie at 0.1, 0.5 and 0.9 of intervals of the set D.",
    );
    for run in runs {
        page.paragraph(&findings(run));
    }
    page.table(&TABLE_HEADER, &table_rows(runs));
    for (run, case) in runs.iter().flat_map(|run| run.cases.iter().map(move |case| (run, case))) {
        page.figure(&study_plot(run, case).to_svg(PLOT_PX)?, "Profile across the border.");
    }
    if !grounds.is_empty() {
        page.heading("Real terrain and imagery").paragraph(
            "The same surface by every way of colouring, against 1024 unfiltered rays a pixel. \
             Errors are the largest of a pixel's channels, linear light.",
        );
        page.table(&GroundComparison::HEADER, &rows_of(grounds));
        page.pictures(pictures);
    }
    Ok(page.to_html())
}

fn rows_of(grounds: &[GroundComparison]) -> Vec<[String; 8]> {
    grounds.iter().map(GroundComparison::row).collect()
}

/// The table of comparisons on a dataset's ground as CSV.
pub fn ground_table_csv(grounds: &[GroundComparison]) -> String {
    let mut csv = GroundComparison::HEADER.map(|cell| cell.replace(',', "")).join(",") + "\n";
    for row in rows_of(grounds) {
        let _ = writeln!(csv, "{}", row.join(","));
    }
    csv
}

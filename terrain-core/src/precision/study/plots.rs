use super::{NativeRow, SpanRow, Study};
use crate::measure::report::{Plot, Series, SeriesStyle};
use crate::precision::depth::DepthKind;
use crate::precision::encodings::{Encoding, EncodingErrors, GroundRow, PlaceRow, PositionRow};
use crate::precision::span::{STUDIED_HALF_PIXELS_RAD, TEXEL_PART};

/// A plot with the name of its file and what to say under it.
#[derive(Clone, Debug)]
pub struct NamedPlot {
    /// Without folder or extension.
    pub name: String,
    /// The plot.
    pub plot: Plot,
    /// What it shows.
    pub caption: String,
}

/// Every plot of the study.
pub fn plots(study: &Study) -> Vec<NamedPlot> {
    let mut plots = Vec::new();
    plots.extend(STUDIED_HALF_PIXELS_RAD.map(|half_pixel_rad| span_plot(study, half_pixel_rad)));
    if !study.natives.is_empty() {
        plots.push(native_plot(study));
    }
    plots.extend(encoding_plots(study));
    plots.push(depth_plot(study));
    plots
}

/// Exponent of a power of two, as the studied angles are.
fn exponent(value: f64) -> i32 {
    value.log2().round() as i32
}

fn span_plot(study: &Study, half_pixel_rad: f64) -> NamedPlot {
    let rows = study.spans.iter().filter(|row| row.half_pixel_rad == half_pixel_rad);
    let rows = rows.collect::<Vec<_>>();
    let series = |name: &str, style, bits: &dyn Fn(&SpanRow) -> f64| Series {
        name: name.to_owned(),
        points: rows.iter().map(|row| [row.range, bits(row)]).collect(),
        style,
    };
    let tried = |row: &SpanRow| row.gpu_f32.unwrap_or(row.cpu);
    NamedPlot {
        name: format!("span-bits-{}", -exponent(half_pixel_rad)),
        plot: Plot {
            title: format!("Bits against range, half a pixel = 2^{}", exponent(half_pixel_rad)),
            x_label: "range r = ground distance / height".to_owned(),
            y_label: "bits".to_owned(),
            x_log: true,
            y_log: false,
            series: vec![
                series("leading zeros N0 (15)", SeriesStyle::Dashed, &|row| row.leading_zeros),
                series("N.V, derived", SeriesStyle::Line, &|row| row.normal_dot_bits),
                series("N.V, tried", SeriesStyle::Points, &|row| f64::from(tried(row).normal_dot)),
                series("texture coordinate, derived", SeriesStyle::Line, &|row| row.texture_bits),
                series("texture coordinate, tried", SeriesStyle::Points, &|row| {
                    f64::from(tried(row).texture)
                }),
                series("two directions by N.V alone", SeriesStyle::Dashed, &|row| {
                    row.direction_bits
                }),
            ],
        },
        caption: "From straight below to the last pixel under the horizon. Derived bits are real \
                  numbers, tried ones whole."
            .to_owned(),
    }
}

fn native_plot(study: &Study) -> NamedPlot {
    let half_pixel_rad = STUDIED_HALF_PIXELS_RAD[2];
    let series = |bits: u32, what: &str, style, texels: &dyn Fn(&NativeRow) -> f64| {
        let rows = study
            .natives
            .iter()
            .filter(|row| row.significant_bits == bits && row.half_pixel_rad == half_pixel_rad);
        let points = rows.map(|row| [row.range, texels(row)]).collect();
        Series { name: format!("{bits} bits, {what}"), points, style }
    };
    let mut all = Vec::new();
    for bits in [11, 24] {
        all.push(series(bits, "derived", SeriesStyle::Line, &|row| row.predicted_texels));
        all.push(series(bits, "measured", SeriesStyle::Points, &|row| row.measured_texels));
    }
    all.push(bound("1/16 texel", &all, TEXEL_PART));
    NamedPlot {
        name: "native-floats".to_owned(),
        plot: Plot {
            title: "Texture coordinate in the device's floats, half a pixel = 2^-11".to_owned(),
            x_label: "range r = ground distance / height".to_owned(),
            y_label: "worst error, texels".to_owned(),
            x_log: true,
            y_log: true,
            series: all,
        },
        caption: "11 bits are f16, 24 bits f32. Measured f16 ends where its squares overflow."
            .to_owned(),
    }
}

/// A level line over all that the other series reach.
fn bound(name: &str, over: &[Series], value: f64) -> Series {
    let xs = || over.iter().flat_map(|series| &series.points).map(|point| point[0]);
    let (low, high) = (xs().fold(f64::INFINITY, f64::min), xs().fold(0.0, f64::max));
    let points = vec![[low, value], [high, value]];
    Series { name: name.to_owned(), points, style: SeriesStyle::Dashed }
}

/// One curve of the worst an encoding, over whatever `place` groups the rows by.
fn worst_by<Row>(
    rows: &[Row],
    encoding_of: impl Fn(&Row) -> Encoding,
    place: impl Fn(&Row) -> Option<f64>,
    value: impl Fn(&Row) -> f64,
) -> Vec<Series> {
    let curve = |encoding: Encoding| {
        let mut points: Vec<[f64; 2]> = Vec::new();
        for row in rows.iter().filter(|row| encoding_of(row) == encoding) {
            let Some(x) = place(row) else { continue };
            match points.iter_mut().find(|point| point[0] == x) {
                Some(point) => point[1] = point[1].max(value(row)),
                None => points.push([x, value(row)]),
            }
        }
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let style = match encoding {
            // It lies on the camera-relative one in most plots.
            Encoding::Shipped => SeriesStyle::Points,
            _ => SeriesStyle::Line,
        };
        Series { name: encoding.name().to_owned(), points, style }
    };
    Encoding::ALL.map(curve).into()
}

fn encoding_plots(study: &Study) -> Vec<NamedPlot> {
    let errors = study.encodings.gpu.as_ref().unwrap_or(&study.encodings.cpu);
    let contract = &study.encodings.contract;
    let is_near = |row: &PositionRow| row.cell.distance_m <= contract.near_m;
    let near = worst_by(
        &errors.positions,
        |row| row.encoding,
        |row| is_near(row).then_some(row.cell.magnitude_m),
        |row| row.worst_m,
    );
    let far = |name: &str, label: &str, x_log, x: &dyn Fn(&PositionRow) -> f64| {
        let place = |row: &PositionRow| (!is_near(row)).then(|| x(row));
        let curves = worst_by(&errors.positions, |row| row.encoding, place, |row| row.worst_pixels);
        encoding_plot(
            name,
            ["Position beyond 1 km", label, "worst error, pixels"],
            x_log,
            with_bound(curves, "1/16 pixel", contract.pixel_part),
        )
    };
    vec![
        encoding_plot(
            "encodings-near",
            ["Position within 1 km of the eye", "coordinates, m", "worst error, m"],
            true,
            with_bound(near, "1 mm", contract.near_tolerance_m),
        ),
        far("encodings-magnitude", "coordinates, m", true, &|row| row.cell.magnitude_m),
        far("encodings-height", "height of the eye, m", true, &|row| row.cell.height_m),
        far("encodings-grazing", "angle above the ground, degrees", true, &|row| {
            row.cell.grazing_deg
        }),
        far("encodings-fov", "field of view, degrees", true, &|row| row.cell.fov_deg),
        texel_plot(errors, contract.texel_part),
        ground_plot(errors, contract.near_tolerance_m),
    ]
}

fn ground_plot(errors: &EncodingErrors, near_tolerance_m: f64) -> NamedPlot {
    let texel = |row: &GroundRow| Some(row.cell.texel_m);
    let curves = worst_by(&errors.grounds, |row| row.encoding, texel, |row| row.height_m);
    encoding_plot(
        "encodings-grounds",
        [
            "Height of the ground within 1 km of the eye",
            "texel of the heights, m",
            "worst error, m",
        ],
        true,
        with_bound(curves, "1 mm", near_tolerance_m),
    )
}

fn texel_plot(errors: &EncodingErrors, texel_part: f64) -> NamedPlot {
    let level = |row: &PlaceRow| Some(f64::from(row.cell.level));
    let curves = worst_by(&errors.places, |row| row.encoding, level, |row| row.worst_texels);
    encoding_plot(
        "encodings-texels",
        ["Texture coordinate where the level is shown", "level", "worst error, texels"],
        false,
        with_bound(curves, "1/16 texel", texel_part),
    )
}

fn with_bound(mut curves: Vec<Series>, name: &str, value: f64) -> Vec<Series> {
    curves.push(bound(name, &curves, value));
    curves
}

fn encoding_plot(
    name: &str,
    [title, x_label, y_label]: [&str; 3],
    x_log: bool,
    series: Vec<Series>,
) -> NamedPlot {
    NamedPlot {
        name: name.to_owned(),
        plot: Plot {
            title: title.to_owned(),
            x_label: x_label.to_owned(),
            y_label: y_label.to_owned(),
            x_log,
            y_log: true,
            series,
        },
        caption: "The worst over all other axes of the sweep.".to_owned(),
    }
}

fn depth_plot(study: &Study) -> NamedPlot {
    let mut series = Vec::new();
    for kind in DepthKind::ALL {
        let rows = || study.depth.iter().filter(move |row| row.kind == kind);
        series.push(Series {
            name: format!("{}: step", kind.name()),
            points: rows().map(|row| [row.distance_m, row.step_m]).collect(),
            style: SeriesStyle::Line,
        });
        series.push(Series {
            name: String::new(),
            points: rows()
                .map(|row| [row.distance_m, row.gpu_gap_m.unwrap_or(row.cpu_gap_m)])
                .collect(),
            style: SeriesStyle::Points,
        });
    }
    NamedPlot {
        name: "depth".to_owned(),
        plot: Plot {
            title: "What the depth test tells apart, near plane at 10 cm".to_owned(),
            x_label: "distance, m".to_owned(),
            y_label: "gap, m".to_owned(),
            x_log: true,
            y_log: true,
            series,
        },
        caption:
            "Lines: the step between neighbouring depths by the formula. Points, in the colour \
                  next to the line's: the smallest gap found by drawing two squares."
                .to_owned(),
    }
}

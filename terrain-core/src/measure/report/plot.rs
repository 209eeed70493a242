use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::Axis;

/// Why a plot could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// There is no room for axes and their labels.
    #[error("a plot of {0} x {1} px is too small (at least {min_w} x {min_h} px)",
        min_w = MIN_SIZE_PX[0], min_h = MIN_SIZE_PX[1])]
    TooSmall(u32, u32),
    /// The drawing itself.
    #[error("cannot draw the plot: {0}")]
    Drawing(String),
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SeriesStyle {
    /// Straight lines from point to point.
    #[default]
    Line,
    /// Broken lines from point to point.
    Dashed,
    /// A dot a point.
    Points,
    /// Each point's y holds until the next point's x.
    Step,
}

/// Points that belong together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// What the legend says; empty keeps the series out of the legend.
    pub name: String,
    /// x and y. A point that is not finite, or not positive on a logarithmic axis, is a gap.
    pub points: Vec<[f64; 2]>,
    /// How the points are drawn.
    pub style: SeriesStyle,
}

/// A diagram of one or more series over common axes.
///
/// Colours are those of Masataka Okabe and Kei Ito, "Color Universal Design" (2008), which people of
/// every kind of colour vision tell apart; they begin anew after seven series.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// Stands above the diagram; empty leaves no room for it.
    pub title: String,
    /// What x is, with its unit.
    pub x_label: String,
    /// What y is, with its unit.
    pub y_label: String,
    /// Whether x is logarithmic.
    pub x_log: bool,
    /// Whether y is logarithmic.
    pub y_log: bool,
    /// Later series are drawn over earlier ones.
    pub series: Vec<Series>,
}

/// Width and height below which labels would leave no room for the diagram.
const MIN_SIZE_PX: [u32; 2] = [240, 160];
/// The drawing library places everything on whole units; four of them make a pixel.
const UNITS_PER_PX: u32 = 4;
const FONT: &str = "Helvetica, Arial, sans-serif";
const INK: RGBColor = RGBColor(34, 34, 34);
const GRID: RGBColor = RGBColor(224, 224, 224);
const TITLE_PX: u32 = 15;
const LABEL_PX: u32 = 12;
const LEGEND_ROW_PX: u32 = 18;
const DOT_PX: u32 = 3;
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

impl Plot {
    /// The plot as an SVG document of this width and height in pixels.
    ///
    /// # Errors
    /// [`PlotError::TooSmall`] where axes and labels find no room.
    pub fn to_svg(&self, size_px: [u32; 2]) -> Result<String, PlotError> {
        let [width, height] = size_px;
        if width < MIN_SIZE_PX[0] || height < MIN_SIZE_PX[1] {
            return Err(PlotError::TooSmall(width, height));
        }
        let units = size_px.map(|px| px.saturating_mul(UNITS_PER_PX));
        let mut svg = String::new();
        let root = SVGBackend::with_string(&mut svg, units.into()).into_drawing_area();
        self.draw(&root).map_err(|error| PlotError::Drawing(error.to_string()))?;
        drop(root);
        let drawn_size = format!("width=\"{}\" height=\"{}\"", units[0], units[1]);
        Ok(svg.replacen(&drawn_size, &format!("width=\"{width}\" height=\"{height}\""), 1))
    }

    fn draw(&self, root: &Area) -> Result<(), Box<dyn std::error::Error>> {
        root.fill(&WHITE)?;
        let title_px = if self.title.is_empty() { 6 } else { TITLE_PX + 12 };
        let (title, rest) = root.split_vertically(units(title_px));
        let title_style = text(TITLE_PX, INK).pos(Pos::new(HPos::Left, VPos::Center));
        title.draw_text(&self.title, &title_style, (units(14), units(title_px / 2 + 2)))?;
        let (width, _) = rest.dim_in_pixel();
        let (diagram, legend) = rest.split_horizontally(width as i32 - self.legend_units(width));
        self.draw_legend(&legend)?;
        self.draw_diagram(&diagram)
    }

    /// Width of the column for the legend: none where there is nothing to tell apart.
    fn legend_units(&self, width: u32) -> i32 {
        let names = self.named_series().map(|(_, series)| series.name.chars().count());
        let longest = if self.named_series().count() < 2 { 0 } else { names.max().unwrap_or(0) };
        if longest == 0 {
            return units(10);
        }
        // Sans-serif letters are a little more than half as wide as they are high.
        let names_px = longest as u32 * LABEL_PX * 56 / 100;
        units(names_px + 48).min(width as i32 * 2 / 5)
    }

    fn named_series(&self) -> impl Iterator<Item = (usize, &Series)> {
        self.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty())
    }

    fn draw_legend(&self, area: &Area) -> Result<(), Box<dyn std::error::Error>> {
        if self.named_series().count() < 2 {
            return Ok(());
        }
        let style = text(LABEL_PX, INK).pos(Pos::new(HPos::Left, VPos::Center));
        for (row, (index, series)) in self.named_series().enumerate() {
            let y = units(14 + row as u32 * LEGEND_ROW_PX);
            let sample = [(units(6), y), (units(28), y)];
            let colour = colour(index);
            match series.style {
                SeriesStyle::Points => {
                    area.draw(&Circle::new((units(17), y), units(DOT_PX), colour.filled()))?;
                }
                SeriesStyle::Dashed => {
                    area.draw(&dashes(sample.to_vec(), colour))?;
                }
                SeriesStyle::Line | SeriesStyle::Step => {
                    area.draw(&PathElement::new(sample.to_vec(), stroke(colour)))?;
                }
            }
            area.draw_text(&series.name, &style, (units(34), y))?;
        }
        Ok(())
    }

    fn draw_diagram(&self, area: &Area) -> Result<(), Box<dyn std::error::Error>> {
        let values = |axis: usize| {
            self.series.iter().flat_map(move |s| s.points.iter().map(move |p| p[axis]))
        };
        let x = Axis::over(values(0), self.x_log);
        let y = Axis::over(values(1), self.y_log);
        let mut chart = ChartBuilder::on(area)
            .margin_right(units(6))
            .margin_top(units(4))
            .x_label_area_size(units(46))
            .y_label_area_size(units(66))
            .build_cartesian_2d(x.clone(), y.clone())?;
        chart
            .configure_mesh()
            .bold_line_style(GRID.stroke_width(UNITS_PER_PX))
            .axis_style(INK.stroke_width(UNITS_PER_PX))
            .set_all_tick_mark_size(units(4))
            .label_style(text(LABEL_PX, INK))
            .axis_desc_style(text(LABEL_PX, INK))
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .draw()?;
        for (index, series) in self.series.iter().enumerate() {
            draw_series(&mut chart, series, (&x, &y), colour(index))?;
        }
        Ok(())
    }
}

fn draw_series(
    chart: &mut Chart,
    series: &Series,
    axes: (&Axis, &Axis),
    colour: RGBColor,
) -> Result<(), Box<dyn std::error::Error>> {
    for run in runs(&series.points, axes) {
        // A point between two gaps makes no line, but must not be lost.
        if series.style == SeriesStyle::Points || run.len() == 1 {
            let dot = |place| Circle::new(place, units(DOT_PX), colour.filled());
            chart.draw_series(run.into_iter().map(dot))?;
            continue;
        }
        match series.style {
            SeriesStyle::Dashed => chart.draw_series([dashes(run, colour)])?,
            SeriesStyle::Step => {
                chart.draw_series([PathElement::new(steps(&run), stroke(colour))])?
            }
            SeriesStyle::Line | SeriesStyle::Points => {
                chart.draw_series([PathElement::new(run, stroke(colour))])?
            }
        };
    }
    Ok(())
}

/// The places of the points, apart at each gap.
fn runs(points: &[[f64; 2]], (x, y): (&Axis, &Axis)) -> Vec<Vec<(f64, f64)>> {
    let place = |point: &[f64; 2]| Some((x.place(point[0])?, y.place(point[1])?));
    points
        .split(|point| place(point).is_none())
        .filter(|run| !run.is_empty())
        .map(|run| run.iter().filter_map(place).collect())
        .collect()
}

/// The corners of a stair through the points.
fn steps(run: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let corners = run.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    corners.chain(run.last().copied()).collect()
}

fn dashes<C: Clone + 'static>(
    points: Vec<C>,
    colour: RGBColor,
) -> DashedPathElement<std::vec::IntoIter<C>, i32> {
    DashedPathElement::new(points, units(7), units(4), stroke(colour))
}

fn units(px: u32) -> i32 {
    (px * UNITS_PER_PX) as i32
}

fn stroke(colour: RGBColor) -> ShapeStyle {
    colour.stroke_width(UNITS_PER_PX * 7 / 4)
}

fn text(size_px: u32, colour: RGBColor) -> TextStyle<'static> {
    // The library sets text at its size divided by 1.24.
    (FONT, f64::from(size_px * UNITS_PER_PX) * 1.24).into_font().color(&colour)
}

fn colour(index: usize) -> RGBColor {
    PALETTE[index % PALETTE.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: &[[f64; 2]], style: SeriesStyle) -> Plot {
        let series = |name: &str| Series { name: name.into(), points: points.to_vec(), style };
        Plot {
            title: "Error & bytes".into(),
            x_label: "bytes".into(),
            y_label: "error".into(),
            series: vec![series("a <b>"), series("c")],
            ..Default::default()
        }
    }

    #[test]
    fn what_is_not_finite_is_a_gap_in_the_line() {
        let whole = plot(&[[0.0, 1.0], [1.0, 2.0], [2.0, 1.0], [3.0, 4.0]], SeriesStyle::Line);
        let mut broken = whole.clone();
        for series in &mut broken.series {
            series.points.insert(2, [1.5, f64::NAN]);
        }
        let lines = |plot: &Plot| plot.to_svg([400, 300]).unwrap().matches("<polyline").count();
        assert_eq!(lines(&broken), lines(&whole) + 2, "one more run a series");
    }

    #[test]
    fn a_point_between_gaps_is_a_dot() {
        let points = [[0.0, f64::NAN], [1.0, 2.0], [2.0, f64::INFINITY]];
        let mut plot = plot(&points, SeriesStyle::Line);
        plot.series.truncate(1);
        assert_eq!(plot.to_svg([400, 300]).unwrap().matches("<circle").count(), 1);
    }

    #[test]
    fn nothing_to_draw_is_an_empty_diagram() {
        use SeriesStyle::{Dashed, Line, Points, Step};
        for points in [&[][..], &[[f64::NAN, 1.0]], &[[0.0, 0.0]], &[[-1.0, -1.0]]] {
            for style in [Line, Dashed, Points, Step] {
                for (x_log, y_log) in [(false, false), (true, true)] {
                    let svg = Plot { x_log, y_log, ..plot(points, style) }.to_svg([400, 300]);
                    assert!(svg.unwrap().trim_end().ends_with("</svg>"));
                }
            }
        }
        assert!(Plot::default().to_svg([240, 160]).is_ok());
    }

    #[test]
    fn text_is_escaped_and_the_size_is_the_one_asked_for() {
        let svg = plot(&[[0.0, 1.0], [2.0, 3.0]], SeriesStyle::Step).to_svg([400, 300]).unwrap();
        assert!(svg.contains("Error &amp; bytes") && svg.contains("a &lt;b&gt;"), "{svg}");
        assert!(svg.starts_with("<svg width=\"400\" height=\"300\" viewBox=\"0 0 1600 1200\""));
    }

    #[test]
    fn a_size_without_room_is_an_error() {
        let error = Plot::default().to_svg([0, 0]).unwrap_err();
        assert!(matches!(error, PlotError::TooSmall(0, 0)));
    }

    #[test]
    fn a_step_holds_until_the_next_point() {
        let stair = steps(&[(0.0, 1.0), (2.0, 3.0)]);
        assert_eq!(stair, [(0.0, 1.0), (2.0, 1.0), (2.0, 3.0)]);
    }
}

//! The options of every command that draws.

use std::str::FromStr;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use terrain_core::dataset::Shape;
use terrain_core::residency::page_table::{FaceCulling, PageFeedback};
use terrain_core::selection::{Shortening, Strategy, Visibility};
use terrain_core::{AntiAliasing, DebugView, RendererSettings};

use crate::arg_values::{exaggeration, number_within};

/// How to draw.
#[derive(Clone, Copy, Debug, Args)]
pub struct DrawingArgs {
    /// How terrain is brought to the GPU: rtt-quadtree, tiles by the region the GPU sees, subdivided,
    /// regularised and merged; rtt-quadtree-gpu, the same on the GPU, with the caches' slots and
    /// tables; cpu-frustum, tiles by the view frustum and screen-space error; cpu-mesh, a
    /// triangulation made on the CPU for the view and sent as geometry; clipmap, windows round the
    /// eye instead of tiles; page-table, imagery as one virtual texture, of which the GPU finds the
    /// tiles that pixels need; texture-map, the same texture, its tiles found by laying the ground's
    /// triangles into it. Only page-table draws a dataset of the globe as a globe, all others draw it as
    /// a map [default: page-table for a globe, else rtt-quadtree]
    #[arg(long, value_name = "STRATEGY", value_parser = strategies())]
    strategy: Option<Strategy>,

    /// What counts as visible for rtt-quadtree and rtt-quadtree-gpu: box, all of the box round what the
    /// GPU saw; exact, only the tiles its pixels lie on
    #[arg(long, value_name = "VISIBILITY", default_value_t, value_parser = visibilities())]
    visibility: Visibility,

    /// How page-table learns what pixels need: list, duplicates removed on the GPU; full, every pixel
    /// read back; jittered, one pixel of each 8x8 block in turn
    #[arg(long, value_name = "FEEDBACK", default_value_t, value_parser = page_feedbacks())]
    page_feedback: PageFeedback,

    /// Where texture-map drops triangles that turn their backs on the eye: compute, in a pass before they
    /// are rasterised; vertex, in the vertex stage; fragment, afterwards
    #[arg(long, value_name = "STAGE", default_value_t, value_parser = face_cullings())]
    face_culling: FaceCulling,

    /// How rtt-quadtree and rtt-quadtree-gpu make a list of too many tiles short: farthest, the farthest
    /// tiles are merged; least-error, those whose parent shows the smallest error, and tiles of which
    /// nothing shows are left out
    #[arg(long, value_name = "HOW", default_value_t, value_parser = shortenings())]
    shortening: Shortening,

    /// Factor on all heights, from 0.01 to 1000
    #[arg(
        long,
        value_name = "FACTOR",
        value_parser = exaggeration(),
        allow_hyphen_values = true
    )]
    exaggeration: Option<f64>,

    /// Slots of the tile caches: columns x rows
    #[arg(long, value_name = "MxN", default_value = "6x6", value_parser = cache_slots)]
    cache: Size,

    /// Most tiles a selection may have, level 0 included; never more than there are slots [default:
    /// seven eighths of the slots, so that tiles that come and go need not be sent each time]
    #[arg(long, value_name = "N", value_parser = tile_count, allow_hyphen_values = true)]
    max_tiles: Option<usize>,

    /// A tile is split while its texels are drawn larger than this many pixels, from 0.1 to 64
    #[arg(
        long,
        value_name = "PIXELS",
        default_value_t = 1.0,
        value_parser = number_within(0.1, 64.0),
        allow_hyphen_values = true
    )]
    texel_px: f64,

    /// Size of the mesh's triangles in pixels, from 1 to 64 [default: by the adapter]
    #[arg(
        long,
        value_name = "PIXELS",
        value_parser = number_within(1.0, 64.0),
        allow_hyphen_values = true
    )]
    triangle_px: Option<f64>,

    /// Smooth edges by drawing four samples a pixel, or not [default: by the adapter; pictures of
    /// terrain render are smoothed]
    #[arg(long, value_enum, value_name = "HOW")]
    anti_aliasing: Option<Smoothing>,

    /// Most KiB of tiles to upload in a frame
    #[arg(long, value_name = "KIB")]
    upload_kib: Option<u64>,

    /// What to show of how the picture comes about
    #[arg(long, value_enum, value_name = "VIEW", default_value_t)]
    debug_view: Shown,
}

/// What the picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Shown {
    /// The ground as it is.
    #[default]
    Off,
    /// The borders of the tiles that each pixel is drawn from.
    TileBorders,
    /// Their levels as colours, and the borders.
    Levels,
    /// The light on the slopes alone.
    Shading,
}

/// How edges are smoothed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Smoothing {
    /// Not at all.
    Off,
    /// Four samples a pixel.
    #[value(name = "4x")]
    FourSamples,
}

/// A width and a height, or columns and rows: `1280x720`. Both at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub [u32; 2]);

impl DrawingArgs {
    /// The renderer's settings for ground of a shape; `exaggeration` where the user gives none.
    pub fn settings(&self, shape: Shape, exaggeration: f64) -> RendererSettings {
        let strategy = match shape {
            Shape::Plane => Strategy::default(),
            Shape::Globe => Strategy::PageTable,
        };
        let defaults = RendererSettings::default();
        let [cache_columns, cache_rows] = self.cache.0;
        let most_tiles = RendererSettings::most_tiles_of(cache_columns, cache_rows);
        RendererSettings {
            strategy: self.strategy.unwrap_or(strategy),
            visibility: self.visibility,
            page_feedback: self.page_feedback,
            face_culling: self.face_culling,
            shortening: self.shortening,
            cache_columns,
            cache_rows,
            max_tiles: self.max_tiles.unwrap_or(most_tiles),
            texel_px: self.texel_px,
            triangle_px: self.triangle_px.unwrap_or(defaults.triangle_px),
            vertical_exaggeration: self.exaggeration.unwrap_or(exaggeration),
            anti_aliasing: match self.anti_aliasing {
                None => defaults.anti_aliasing,
                Some(Smoothing::Off) => AntiAliasing::Off,
                Some(Smoothing::FourSamples) => AntiAliasing::FourSamples,
            },
            debug_view: match self.debug_view {
                Shown::Off => DebugView::Off,
                Shown::TileBorders => DebugView::TileBorders,
                Shown::Levels => DebugView::Levels,
                Shown::Shading => DebugView::Shading,
            },
            upload_budget_bytes: self
                .upload_kib
                .map_or(defaults.upload_budget_bytes, |kib| kib.saturating_mul(1024)),
            ..defaults
        }
        .checked()
    }
}

/// A strategy by its name; all names are in the help.
pub fn strategies() -> impl TypedValueParser<Value = Strategy> {
    PossibleValuesParser::new(Strategy::ALL.map(Strategy::name))
        .try_map(|name| name.parse::<Strategy>())
}

/// A visibility by its name.
fn visibilities() -> impl TypedValueParser<Value = Visibility> {
    PossibleValuesParser::new(Visibility::ALL.map(Visibility::name))
        .try_map(|name| name.parse::<Visibility>())
}

/// A page feedback by its name.
fn page_feedbacks() -> impl TypedValueParser<Value = PageFeedback> {
    PossibleValuesParser::new(PageFeedback::ALL.map(PageFeedback::name))
        .try_map(|name| name.parse::<PageFeedback>())
}

/// A face culling by its name.
fn face_cullings() -> impl TypedValueParser<Value = FaceCulling> {
    PossibleValuesParser::new(FaceCulling::ALL.map(FaceCulling::name))
        .try_map(|name| name.parse::<FaceCulling>())
}

/// A way to shorten by its name.
fn shortenings() -> impl TypedValueParser<Value = Shortening> {
    PossibleValuesParser::new(Shortening::ALL.map(Shortening::name))
        .try_map(|name| name.parse::<Shortening>())
}

/// Slots of a cache: what a texture and the numbers of a table's entries have room for.
fn cache_slots(text: &str) -> Result<Size, String> {
    let slots = text.parse::<Size>().ok();
    let fits = |size: &Size| size.0.iter().all(|side| *side <= RendererSettings::MOST_SLOTS_A_SIDE);
    slots.filter(fits).ok_or_else(|| {
        let most = RendererSettings::MOST_SLOTS_A_SIDE;
        format!("give two numbers from 1 to {most}, such as 6x6")
    })
}

/// How many tiles a selection may have.
fn tile_count(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| *count > 0);
    count.ok_or_else(|| "give a whole number from 1".to_owned())
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sides = text.split_once(['x', 'X']).and_then(|(width, height)| {
            Some([width.trim().parse::<u32>().ok()?, height.trim().parse::<u32>().ok()?])
        });
        match sides {
            Some(sides) if sides.iter().all(|side| (1..=16_384).contains(side)) => Ok(Self(sides)),
            _ => Err("give two numbers from 1 to 16384, such as 1280x720".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        drawing: DrawingArgs,
    }

    #[test]
    fn sizes_are_two_positive_numbers() {
        assert_eq!("1280x720".parse(), Ok(Size([1280, 720])));
        for text in ["1280", "0x720", "1280x", "x", "-1x5", "99999x1", "3x4x5"] {
            assert!(text.parse::<Size>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_cache_has_as_many_slots_as_a_texture_holds() {
        assert_eq!(cache_slots("8x40"), Ok(Size([8, 40])));
        for text in ["0x0", "41x1", "6", ""] {
            assert!(cache_slots(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_most_tiles_follow_the_cache_unless_given() {
        let settings = |line: &[&str]| {
            let line = ["draw"].iter().chain(line);
            Line::try_parse_from(line).unwrap().drawing.settings(Shape::Plane, 2.0)
        };
        assert_eq!(settings(&["--cache", "8x8"]).max_tiles, 56);
        assert_eq!(settings(&["--cache", "8x8", "--max-tiles", "20"]).max_tiles, 20);
        assert_eq!(settings(&[]).vertical_exaggeration, 2.0);
        assert_eq!(settings(&["--exaggeration", "3"]).vertical_exaggeration, 3.0);
        assert_eq!(settings(&[]).strategy, Strategy::RttQuadtree);
        assert_eq!(settings(&["--strategy", "cpu-frustum"]).strategy, Strategy::CpuFrustum);
        assert_eq!(settings(&[]).anti_aliasing, AntiAliasing::ByAdapter);
        assert_eq!(settings(&["--anti-aliasing", "4x"]).anti_aliasing, AntiAliasing::FourSamples);
        assert_eq!(settings(&["--anti-aliasing", "off"]).anti_aliasing, AntiAliasing::Off);
        assert_eq!(settings(&["--upload-kib", "64"]).upload_budget_bytes, 65_536);
        assert_eq!(settings(&["--debug-view", "levels"]).debug_view, DebugView::Levels);
        assert_eq!(settings(&["--debug-view", "tile-borders"]).debug_view, DebugView::TileBorders);
    }

    #[test]
    fn a_globe_is_drawn_as_one_unless_told_otherwise() {
        let strategy = |line: &[&str], shape| {
            let line = ["draw"].iter().chain(line);
            Line::try_parse_from(line).unwrap().drawing.settings(shape, 1.0).strategy
        };
        assert_eq!(strategy(&[], Shape::Globe), Strategy::PageTable);
        assert_eq!(strategy(&[], Shape::Plane), Strategy::RttQuadtree);
        assert_eq!(strategy(&["--strategy", "clipmap"], Shape::Globe), Strategy::Clipmap);
    }

    #[test]
    fn sizes_in_pixels_are_drawn_as_given_or_refused() {
        let parse = |option: &str, value: &str| Line::try_parse_from(["draw", option, value]);
        for value in ["0.1", "2", "64"] {
            let texel_px =
                parse("--texel-px", value).unwrap().drawing.settings(Shape::Plane, 1.0).texel_px;
            assert_eq!(texel_px, value.parse::<f64>().unwrap());
        }
        for value in ["1", "64"] {
            let settings =
                parse("--triangle-px", value).unwrap().drawing.settings(Shape::Plane, 1.0);
            assert_eq!(settings.triangle_px, value.parse::<f64>().unwrap());
        }
        for (option, values) in [
            ("--texel-px", ["0", "-1", "nan", "65"]),
            ("--triangle-px", ["0", "-8", "nan", "65"]),
            ("--max-tiles", ["0", "-1", "1.5", ""]),
            ("--exaggeration", ["0", "-1", "nan", "1e4"]),
        ] {
            for value in values {
                let refused = parse(option, value).err().unwrap().to_string();
                let has_range = refused.contains("give a") && refused.contains("number from");
                assert!(has_range, "{option} {value}: {refused}");
            }
        }
    }
}

use glam::{DVec2, dvec2};

use super::{Decoded, EncodedPoint, Encoding};
use crate::CameraView;
use crate::dataset::{HeightRanges, Shape};
use crate::frame_setup::frame_uniforms;
use crate::gpu::{FrameUniforms, TilePlace, ToldFrom};
use crate::renderer_settings::RendererSettings;
use crate::selection::{LayerTree, TileTree};
use crate::tiling::{
    FIXED_UNITS_PER_ROOT, FixedPosition, LayerLayout, MAX_LEVEL, TileId, TileSet, TilingScheme,
};

/// A layer of tiles as the renderer keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncodedLayer {
    /// How its tiles are cut.
    pub layout: LayerLayout,
    /// Which texel of a tile places are told from.
    pub told_from: ToldFrom,
}

impl EncodedLayer {
    /// Imagery, whose texels are the finest there are.
    pub const IMAGERY: Self = Self::of_size(384, ToldFrom::Corner);
    /// Heights, which lift every vertex.
    pub const HEIGHTS: Self = Self::of_size(128, ToldFrom::NearEye);

    const fn of_size(tile_size_texels: u32, told_from: ToldFrom) -> Self {
        let gutter_texels = LayerLayout::GUTTER_TEXELS;
        let level_count = MAX_LEVEL + 1;
        Self { layout: LayerLayout { tile_size_texels, gutter_texels, level_count }, told_from }
    }
}

/// An eye over a tiled ground: what points are encoded against.
pub struct EncodingScene {
    scheme: TilingScheme,
    layer: EncodedLayer,
    eye: DVec2,
    uniforms: FrameUniforms,
}

/// How far a decoded point is from the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointError {
    /// Metres between where the point is from the eye and where it was decoded.
    pub position_m: f64,
    /// Texels between its places in the tile's grid, on the worse axis. Where the renderer would read
    /// beyond a tile's gutter, this counts from the last texel that it can read.
    pub place_texels: f64,
}

impl EncodingScene {
    /// A scene whose uniforms are those of a frame drawn from `eye` (metres east and north).
    pub fn new(scheme: TilingScheme, layer: EncodedLayer, eye: DVec2) -> Self {
        let tree = TileTree {
            scheme,
            data_extent: scheme.root_extent(),
            shape: Shape::Plane,
            heights: LayerTree { layout: layer.layout, present: TileSet::default() },
            colours: None,
            height_ranges: HeightRanges { levels: Vec::new() },
        };
        let view = CameraView {
            eye: eye.extend(0.0),
            heading_deg: 0.0,
            pitch_deg: 0.0,
            fov_y_deg: 60.0,
            viewport_px: [1, 1],
        };
        let uniforms = frame_uniforms(&view, &tree, &RendererSettings::default(), 1.0);
        Self { scheme, layer, eye, uniforms }
    }

    /// Where the eye is, metres east and north.
    pub fn eye(&self) -> DVec2 {
        self.eye
    }

    /// The frame as the shaders see it.
    pub fn uniforms(&self) -> &FrameUniforms {
        &self.uniforms
    }

    /// Side of a texel of the level in metres.
    pub fn texel_size_m(&self, level: u8) -> f64 {
        self.layer.layout.texel_size_m(&self.scheme, level)
    }

    /// The ground that can be encoded.
    pub fn contains(&self, world: DVec2) -> bool {
        let root = self.scheme.root_extent();
        // The far borders belong to no tile in fixed point.
        root.contains(world) && world.x < root.max.x && world.y > root.min.y
    }

    /// The point moved on both axes to `beside_texels` of the nearest corner of its level's tiles.
    pub fn near_corner(&self, world: DVec2, level: u8, beside_texels: f64) -> DVec2 {
        let side_m = self.scheme.tile_size_m(level);
        let corner = ((world - self.scheme.origin) / side_m).round() * side_m;
        self.scheme.origin + corner + beside_texels * self.texel_size_m(level)
    }

    /// Encodes a point in its tile of the level; `None` outside the root.
    pub fn encode(&self, world: DVec2, level: u8) -> Option<EncodedPoint> {
        let tile = self.scheme.tile_at(level, world).filter(|_| self.contains(world))?;
        let eye_tile = self.scheme.tile_at(level, self.eye)?;
        let from_eye = (world - self.eye).as_vec2();
        let place = self.tile_place(tile, [0, 0]);
        let found = self.found_tile(from_eye.to_array(), level)?;
        let shipped = self.tile_place(found, self.told_from_texel(found));
        let corner = self.scheme.tile_origin(tile);
        let fixed = |point| {
            let FixedPosition { x, y } = self.scheme.fixed_from_world(point);
            [x, y]
        };
        let units_per_tile = f64::from(FIXED_UNITS_PER_ROOT >> level);
        Some(EncodedPoint {
            world: high(world),
            world_low: low(world),
            eye: high(self.eye),
            eye_low: low(self.eye),
            corner: high(corner),
            corner_low: low(corner),
            from_eye: from_eye.to_array(),
            corner_from_eye: place.origin_from_eye_m,
            shipped_corner_from_eye: shipped.origin_from_eye_m,
            fraction: self.fraction(tile, world),
            eye_fraction: self.fraction(eye_tile, self.eye),
            tile: index(tile),
            eye_tile: index(eye_tile),
            fixed: fixed(world),
            eye_fixed: fixed(self.eye),
            corner_fixed: index(tile).map(|index| index << (30 - u32::from(level))),
            tile_size_m: self.scheme.tile_size_m(level) as f32,
            texels_per_m: place.texels_per_m,
            tile_size_texels: self.layer.layout.tile_size_texels as f32,
            unit_m: (self.scheme.root_size_m / f64::from(FIXED_UNITS_PER_ROOT)) as f32,
            texels_per_unit: (f64::from(self.layer.layout.tile_size_texels) / units_per_tile)
                as f32,
            padding: 0,
        })
    }

    /// The tile in which the renderer's lookup finds a point this far from the eye; `None` where it
    /// finds it outside the root.
    pub fn found_tile(&self, from_eye_m: [f32; 2], level: u8) -> Option<TileId> {
        self.found_position(from_eye_m).tile_at(level)
    }

    /// The renderer's fixed-point position of a point this far from the eye.
    pub fn found_position(&self, from_eye_m: [f32; 2]) -> FixedPosition {
        let [x, y] = self.uniforms.anchor_fixed.to_array();
        let anchor_from_eye = self.uniforms.anchor_from_eye_m.to_array();
        let from_anchor = [from_eye_m[0] - anchor_from_eye[0], from_eye_m[1] - anchor_from_eye[1]];
        FixedPosition::from_offset(FixedPosition { x, y }, from_anchor, self.uniforms.units_per_m)
    }

    /// Compares a decoded point with the truth. The point must be one that was encoded at the level.
    pub fn error(
        &self,
        encoding: Encoding,
        (world, level): (DVec2, u8),
        point: &EncodedPoint,
        decoded: &Decoded,
    ) -> PointError {
        let relative_m = DVec2::from(decoded.relative_m.map(f64::from));
        let mut place = DVec2::from(decoded.place_texels.map(f64::from));
        let mut tile = TileId { level, row: point.tile[1] as u32, column: point.tile[0] as u32 };
        if encoding == Encoding::Shipped {
            tile = self.found_tile(point.from_eye, level).unwrap_or(tile);
            let margin = self.readable_margin_texels();
            let size = f64::from(self.layer.layout.tile_size_texels);
            place += DVec2::from(self.told_from_texel(tile).map(f64::from));
            place = place.clamp(DVec2::splat(-margin), DVec2::splat(size + margin));
        }
        let from_corner = world - self.scheme.tile_origin(tile);
        let exact = dvec2(from_corner.x, -from_corner.y) / self.texel_size_m(level);
        PointError {
            position_m: (relative_m - (world - self.eye)).length(),
            place_texels: (place - exact).abs().max_element(),
        }
    }

    fn tile_place(&self, tile: TileId, texel: [u32; 2]) -> TilePlace {
        TilePlace::new(&self.scheme, &self.layer.layout, tile, self.eye, texel, [0, 0])
    }

    fn told_from_texel(&self, tile: TileId) -> [u32; 2] {
        self.layer.told_from.texel(&self.scheme, &self.layer.layout, tile, self.eye)
    }

    /// How far beyond a tile's border a filtered lookup can be centred: the gutter less half a texel of
    /// the coarsest of the slot's three mips.
    fn readable_margin_texels(&self) -> f64 {
        f64::from(self.layer.layout.gutter_texels) - 2.0
    }

    fn fraction(&self, tile: TileId, world: DVec2) -> [f32; 2] {
        let from_corner = world - self.scheme.tile_origin(tile);
        let side_m = self.scheme.tile_size_m(tile.level);
        [(from_corner.x / side_m) as f32, (-from_corner.y / side_m) as f32]
    }
}

fn high(place: DVec2) -> [f32; 2] {
    place.as_vec2().to_array()
}

fn low(place: DVec2) -> [f32; 2] {
    (place - place.as_vec2().as_dvec2()).as_vec2().to_array()
}

fn index(tile: TileId) -> [i32; 2] {
    [tile.column as i32, tile.row as i32]
}

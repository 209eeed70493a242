use glam::DVec2;

use super::eye_units::{EyeUnits, HeightUnits, SplitDistances};
use super::ground_units::GroundUnits;
use super::{SelectionConfig, Shortening, TileTree};
use crate::CameraView;
use crate::tiling::{FIXED_UNITS_PER_ROOT, TileId};

/// What a selection on the GPU goes by: the `SelectionParams` of `common/selection.wgsl`, where the
/// members are told.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct SelectionParams {
    pub eye: [i32; 3],
    pub doublings: u32,
    pub anchor: [i32; 2],
    pub anchor_from_origin_m: [f32; 2],
    pub eye_ground: [i32; 2],
    pub layer_finest: [u32; 2],
    pub units_per_m: f32,
    pub max_tiles: u32,
    pub height_levels: u32,
    pub is_exact: u32,
    pub is_by_error: u32,
    pub padding: u32,
    pub split_below: [[u32; 2]; 27],
}

impl SelectionParams {
    /// For the view, by an image whose offsets count from `image_origin`.
    pub fn new(
        tree: &TileTree,
        view: &CameraView,
        config: &SelectionConfig,
        image_origin: DVec2,
        is_exact: bool,
    ) -> Self {
        let eye = EyeUnits::new(tree, view.eye, config.vertical_exaggeration);
        let ground = GroundUnits::new(&tree.scheme, image_origin);
        let below = eye.split_below(tree, config.texel_px * view.pixel_angle_rad());
        let colours = tree.colours.as_ref().map_or(0, |layer| layer.layout.finest_level());
        Self {
            eye: eye.eye,
            doublings: eye.doublings,
            anchor: [ground.anchor.x, ground.anchor.y],
            anchor_from_origin_m: ground.anchor_from_origin_m,
            eye_ground: eye_ground(&eye),
            layer_finest: [tree.heights.layout.finest_level(), colours].map(u32::from),
            units_per_m: ground.units_per_m,
            max_tiles: u32::try_from(config.max_tiles).unwrap_or(u32::MAX),
            height_levels: tree.height_ranges.levels.len() as u32,
            is_exact: u32::from(is_exact),
            is_by_error: u32::from(config.shortening == Shortening::LeastError),
            padding: 0,
            split_below: words(&below),
        }
    }
}

fn words(below: &SplitDistances) -> [[u32; 2]; 27] {
    let mut words = [[0; 2]; 27];
    for (words, distance) in words.iter_mut().zip(below) {
        *words = [*distance as u32, (distance >> 32) as u32];
    }
    words
}

/// The unit of the root below or next to the eye, counted without doublings.
pub(super) fn eye_ground(eye: &EyeUnits) -> [i32; 2] {
    [eye.eye[0], eye.eye[1]].map(|units| {
        let unit = i64::from(units) << eye.doublings;
        unit.clamp(0, i64::from(FIXED_UNITS_PER_ROOT) - 1) as i32
    })
}

/// The lowest and the highest ground of the tiles whose heights are known, in units as the view and the
/// exaggeration make them, level by level in the order of rows and columns.
pub(crate) fn height_units(
    tree: &TileTree,
    view: &CameraView,
    vertical_exaggeration: f64,
) -> Vec<HeightUnits> {
    let eye = EyeUnits::new(tree, view.eye, vertical_exaggeration);
    let levels = 0..tree.height_ranges.levels.len() as u8;
    let tiles = levels.flat_map(|level| {
        let side = 1_u32 << level;
        (0..side * side).map(move |i| TileId::new(level, i / side, i % side))
    });
    tiles.map(|tile| eye.heights(tree.height_ranges.range(tile))).collect()
}

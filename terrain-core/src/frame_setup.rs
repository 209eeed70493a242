//! From a camera to what the shaders need to know of it. Pure; everything is computed in f64 and
//! only differences from the eye are narrowed to f32.

use glam::{DVec2, DVec3, IVec2, Vec3, dvec2};

use crate::CameraView;
use crate::gpu::FrameUniforms;
use crate::renderer_settings::RendererSettings;
use crate::selection::TileTree;
use crate::tiling::{FIXED_UNITS_PER_ROOT, FixedPosition, TilingScheme};

/// Distance of the near plane in metres. Reverse depth in floats is as precise far away whatever
/// the near plane, so it can lie where nothing is ever clipped.
pub const NEAR_PLANE_M: f64 = 0.1;

/// Where the light comes from: north-west as on maps, 40 degrees up.
const SUN_AZIMUTH_DEG: f64 = 315.0;
const SUN_ELEVATION_DEG: f64 = 40.0;

/// Linear light of the sky at the horizon (and of the haze) and overhead.
pub(crate) const HAZE_COLOUR: Vec3 = Vec3::new(0.66, 0.76, 0.86);
pub(crate) const ZENITH_COLOUR: Vec3 = Vec3::new(0.10, 0.25, 0.56);

/// The camera-dependent part of the uniforms. Tables and texture sizes are filled in by the caller.
pub fn frame_uniforms(
    view: &CameraView,
    tree: &TileTree,
    settings: &RendererSettings,
    mesh_scale_m: f64,
) -> FrameUniforms {
    let exaggeration = settings.vertical_exaggeration;
    let eye_height_m = view.eye.z / exaggeration;
    // A whole number of metres: the difference of a stored height from it is exact in f32.
    let eye_height_coarse_m = eye_height_m.round();
    let anchor = Anchor::at(&tree.scheme, view.eye.truncate());
    let range = tree.height_ranges.range(crate::tiling::TileId::ROOT);
    let (height_min_m, height_max_m) = range.map_or((0.0, 0.0), |range| (range.min_m, range.max_m));
    let tint_span_m = f64::from(height_max_m - height_min_m).max(1.0);
    let haze = Haze::of(tree, exaggeration);
    let (forward, right, up) = picture_axes(view);
    let from_eye = |corner: DVec2| (corner - view.eye.truncate()).as_vec2();
    FrameUniforms {
        clip_from_relative: view.clip_from_relative(NEAR_PLANE_M),
        view_forward: forward.as_vec3(),
        view_right: right.as_vec3(),
        view_up: up.as_vec3(),
        units_per_m: (f64::from(FIXED_UNITS_PER_ROOT) / tree.scheme.root_size_m) as f32,
        mesh_scale_m: mesh_scale_m as f32,
        vertical_exaggeration: exaggeration as f32,
        anchor_fixed: IVec2::new(anchor.fixed.x, anchor.fixed.y),
        anchor_from_eye_m: anchor.from_eye_m.as_vec2(),
        data_min_from_eye_m: from_eye(tree.data_extent.min),
        data_max_from_eye_m: from_eye(tree.data_extent.max),
        eye_height_coarse_m: eye_height_coarse_m as f32,
        eye_height_rest_m: (eye_height_m - eye_height_coarse_m) as f32,
        haze_distance_m: haze.distance_m as f32,
        haze_scale_height_m: haze.scale_height_m as f32,
        sun_direction: direction(SUN_AZIMUTH_DEG, SUN_ELEVATION_DEG).as_vec3(),
        shading_strength: settings.shading_strength,
        haze_colour: HAZE_COLOUR,
        zenith_colour: ZENITH_COLOUR,
        eye_height_above_base_m: (view.eye.z - f64::from(height_min_m) * exaggeration) as f32,
        height_min_m,
        tint_at_eye: ((eye_height_m - f64::from(height_min_m)) / tint_span_m) as f32,
        tint_per_m: (1.0 / (tint_span_m * exaggeration)) as f32,
        height_tile_texels: tree.heights.layout.tile_size_texels as f32,
        height_gutter_texels: tree.heights.layout.gutter_texels as f32,
        has_colours: u32::from(tree.colours.is_some()),
        colour_tile_texels: tree.colours.as_ref().map_or(0, |l| l.layout.tile_size_texels) as f32,
        colour_gutter_texels: tree.colours.as_ref().map_or(0, |l| l.layout.gutter_texels) as f32,
        ..FrameUniforms::default()
    }
}

/// The scale of the circular mesh for an eye this high above the ground: a power of two at most the
/// height, so that near the eye a triangle is about as large in pixels as farther away, and so that
/// the vertices stay where they are while the height changes little.
pub fn mesh_scale_m(tree: &TileTree, clearance_m: f64) -> f64 {
    clearance_m.max(least_mesh_scale_m(tree)).log2().floor().exp2()
}

/// The least scale a mesh needs over the data: with it the vertices below the eye lie a hundred or
/// more to a cell of the finest heights, between which the ground is all but flat.
fn least_mesh_scale_m(tree: &TileTree) -> f64 {
    let layout = &tree.heights.layout;
    (layout.texel_size_m(&tree.scheme, layout.finest_level()) / 16.0).max(1.0)
}

/// Radius a mesh needs, in units of its scale, to reach all ground from any eye over the data at any
/// height; larger for an eye farther out.
pub fn mesh_radius(tree: &TileTree, eye: DVec2, scale_m: f64) -> f64 {
    let diagonal_m = tree.data_extent.size_m().length();
    let everywhere = diagonal_m / mesh_scale_m(tree, 0.0);
    everywhere.max(reach_m(tree, eye) / scale_m)
}

/// Distance in metres from the eye to the farthest corner of the data.
fn reach_m(tree: &TileTree, eye: DVec2) -> f64 {
    let far = (tree.data_extent.min - eye).abs().max((tree.data_extent.max - eye).abs());
    far.length()
}

/// The point of the root nearest to the eye, in fixed point, and where it lies from the eye.
struct Anchor {
    fixed: FixedPosition,
    from_eye_m: DVec2,
}

impl Anchor {
    fn at(scheme: &TilingScheme, eye: DVec2) -> Self {
        let root = scheme.root_extent();
        let fixed = scheme.fixed_from_world(eye.clamp(root.min, root.max));
        let unit_m = scheme.root_size_m / f64::from(FIXED_UNITS_PER_ROOT);
        // From the rounded position back, so that rounding does not shift the tiles.
        let place = scheme.origin + dvec2(f64::from(fixed.x), -f64::from(fixed.y)) * unit_m;
        Self { fixed, from_eye_m: place - eye }
    }
}

struct Haze {
    distance_m: f64,
    scale_height_m: f64,
}

impl Haze {
    /// Clear enough that the far end of the data shows through from the ground, never clearer than
    /// real air on a good day over a small area; thinning out upwards with the exaggerated relief.
    fn of(tree: &TileTree, exaggeration: f64) -> Self {
        let diagonal_m = tree.data_extent.size_m().length();
        Self {
            distance_m: (1.2 * diagonal_m).max(60_000.0),
            scale_height_m: (8_000.0 * exaggeration).max(0.03 * diagonal_m),
        }
    }
}

/// World direction of the picture's centre, and the steps from it to the right and upper borders.
fn picture_axes(view: &CameraView) -> (DVec3, DVec3, DVec3) {
    let half_height = (0.5 * view.fov_y_deg.to_radians()).tan();
    let axes = view.view_from_world();
    (-axes.row(2), axes.row(0) * (half_height * view.aspect()), axes.row(1) * half_height)
}

fn direction(azimuth_deg: f64, elevation_deg: f64) -> DVec3 {
    let (azimuth, elevation) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
    DVec3::new(azimuth.sin() * elevation.cos(), azimuth.cos() * elevation.cos(), elevation.sin())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_anchor_stays_within_a_hundredth_of_a_millimetre_over_a_million_frames_of_drift() {
        let scheme = TilingScheme { origin: dvec2(-2.0e7, 2.0e7), root_size_m: 4.0e7 };
        let unit_m = scheme.root_size_m / f64::from(FIXED_UNITS_PER_ROOT);
        // A step of no whole number of units, across the whole root and out of it.
        let step = dvec2(41.234_567_890_1, -40.987_654_321_1);
        let mut eye = dvec2(-2.01e7, 2.01e7);
        for frame in 0..1_000_000 {
            let anchor = Anchor::at(&scheme, eye);
            let from_eye_m = anchor.from_eye_m.as_vec2();
            let root = scheme.root_extent();
            let is_inside = eye.cmpge(root.min).all() && eye.cmple(root.max).all();
            if is_inside {
                // Within half a unit, so that a float holds it to far less than a millimetre.
                assert!(from_eye_m.abs().max_element() <= unit_m as f32, "frame {frame}");
            }
            let place = scheme.origin
                + dvec2(f64::from(anchor.fixed.x), -f64::from(anchor.fixed.y)) * unit_m;
            let error_m = (eye + from_eye_m.as_dvec2() - place).abs().max_element();
            // Outside, the anchor lies at the edge, as far as the eye does: a part in 2^24 of that.
            let bound_m = if is_inside { 1.0e-5 } else { anchor.from_eye_m.length() / 1.6e7 };
            assert!(error_m <= bound_m.max(1.0e-5), "frame {frame}: {error_m} m");
            eye += step;
        }
    }
}

use glam::{DVec2, dvec2};

use super::ground_units::{FixedBox, GroundUnits};
use crate::CameraView;
use crate::tiling::{Extent, TilingScheme};

/// What the coordinate pass saw: the ground under every pixel, and the view it was drawn for.
#[derive(Clone, Debug, PartialEq)]
pub struct CoordinateImage {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The point the offsets count from: x east and y north in metres of the CRS.
    pub origin: DVec2,
    /// Row by row from the top left: metres east and north of `origin`; NaN where there is sky.
    pub offsets: Vec<[f32; 2]>,
    /// The frame that drew the image.
    pub frame: u64,
    /// The camera that drew the image.
    pub view: CameraView,
}

/// The ground in view, as the paper takes it: the smallest axis-aligned box round all of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleRegion {
    /// The point the offsets count from: x east and y north in metres of the CRS.
    pub origin: DVec2,
    /// The box's south-west corner, metres east and north of `origin`.
    pub min_m: [f32; 2],
    /// Its north-east corner.
    pub max_m: [f32; 2],
    /// Pixels that see ground, at least 1.
    pub covered_pixels: u32,
}

/// The ground last seen, perhaps by a view some frames old.
#[derive(Clone, Copy, Debug)]
pub struct SeenGround<'a> {
    /// The box round it.
    pub region: &'a VisibleRegion,
    /// The image the box was found in, where only what its pixels saw counts as visible and not all of
    /// the box.
    pub image: Option<&'a CoordinateImage>,
}

impl<'a> SeenGround<'a> {
    /// All of the box counts as visible.
    pub fn of_box(region: &'a VisibleRegion) -> Self {
        Self { region, image: None }
    }
}

impl VisibleRegion {
    /// The region of all of an extent, with corners as near to the extent's as floats come.
    pub fn of_extent(extent: &Extent) -> Self {
        let max_m = extent.size_m().as_vec2().to_array();
        Self { origin: extent.min, min_m: [0.0; 2], max_m, covered_pixels: 1 }
    }

    /// The box, metres in the CRS.
    pub fn extent(&self) -> Extent {
        let corner =
            |[east, north]: [f32; 2]| self.origin + dvec2(f64::from(east), f64::from(north));
        Extent::new(corner(self.min_m), corner(self.max_m))
    }

    /// The region of what either saw.
    pub fn union(a: Option<Self>, b: Option<Self>) -> Option<Self> {
        let (Some(a), Some(b)) = (a, b) else { return a.or(b) };
        let moved = b.told_from(a.origin);
        let lesser = |i: usize| a.min_m[i].min(moved.min_m[i]);
        let greater = |i: usize| a.max_m[i].max(moved.max_m[i]);
        Some(Self {
            min_m: [lesser(0), lesser(1)],
            max_m: [greater(0), greater(1)],
            covered_pixels: a.covered_pixels.max(b.covered_pixels),
            ..a
        })
    }

    /// The region told from another point.
    fn told_from(self, origin: DVec2) -> Self {
        if origin == self.origin {
            return self;
        }
        let extent = self.extent();
        let from_origin = |corner: DVec2| (corner - origin).as_vec2().to_array();
        Self { origin, min_m: from_origin(extent.min), max_m: from_origin(extent.max), ..self }
    }

    /// The box in fixed-point units of the root.
    pub(super) fn fixed_box(&self, scheme: &TilingScheme) -> FixedBox {
        GroundUnits::new(scheme, self.origin).box_between(self.min_m, self.max_m)
    }
}

/// Pixels scanned side by side, so that the compiler can use vector registers.
const LANES: usize = 8;

/// Smallest and largest coordinates of the pixels scanned so far, and how many saw ground: lane by
/// lane, pixel i in lane i modulo [`LANES`].
struct Bounds {
    min_east: [f32; LANES],
    max_east: [f32; LANES],
    min_north: [f32; LANES],
    max_north: [f32; LANES],
    covered: [u32; LANES],
}

/// Step 1 of the paper's tile selection: minX, minY, maxX and maxY over the coordinate image.
///
/// `None` where no pixel sees ground. Pixels with an infinite or NaN coordinate count as sky.
///
/// The scan is one thread's work: at 512 x 288 pixels it takes about 85 microseconds, less than it
/// costs to wake a pool of threads.
pub fn visible_region(image: &CoordinateImage) -> Option<VisibleRegion> {
    let mut bounds = Bounds::EMPTY;
    let (chunks, rest) = image.offsets.as_chunks::<LANES>();
    for chunk in chunks {
        bounds.add(chunk);
    }
    let mut last = [[f32::NAN; 2]; LANES];
    last[..rest.len()].copy_from_slice(rest);
    bounds.add(&last);

    let covered_pixels = bounds.covered.iter().sum();
    (covered_pixels > 0).then(|| VisibleRegion {
        origin: image.origin,
        min_m: [smallest(bounds.min_east), smallest(bounds.min_north)],
        max_m: [largest(bounds.max_east), largest(bounds.max_north)],
        covered_pixels,
    })
}

impl Bounds {
    const EMPTY: Self = Self {
        min_east: [f32::INFINITY; LANES],
        max_east: [f32::NEG_INFINITY; LANES],
        min_north: [f32::INFINITY; LANES],
        max_north: [f32::NEG_INFINITY; LANES],
        covered: [0; LANES],
    };

    /// Without branches: sky adds values that change no bound.
    #[inline]
    fn add(&mut self, pixels: &[[f32; 2]; LANES]) {
        for (lane, &[east, north]) in pixels.iter().enumerate() {
            // Infinite or NaN if either is.
            let is_ground = (east.abs() + north.abs()) < f32::INFINITY;
            let or = |value: f32, other: f32| if is_ground { value } else { other };
            let lesser = |a: f32, b: f32| if a < b { a } else { b };
            let greater = |a: f32, b: f32| if a > b { a } else { b };
            self.min_east[lane] = lesser(or(east, f32::INFINITY), self.min_east[lane]);
            self.max_east[lane] = greater(or(east, f32::NEG_INFINITY), self.max_east[lane]);
            self.min_north[lane] = lesser(or(north, f32::INFINITY), self.min_north[lane]);
            self.max_north[lane] = greater(or(north, f32::NEG_INFINITY), self.max_north[lane]);
            self.covered[lane] += u32::from(is_ground);
        }
    }
}

fn smallest(lanes: [f32; LANES]) -> f32 {
    lanes.into_iter().fold(f32::INFINITY, f32::min)
}

fn largest(lanes: [f32; LANES]) -> f32 {
    lanes.into_iter().fold(f32::NEG_INFINITY, f32::max)
}

#[cfg(test)]
mod tests {
    use glam::dvec3;
    use proptest::prelude::*;

    use super::*;

    fn image(width: u32, offsets: Vec<[f32; 2]>) -> CoordinateImage {
        let view = CameraView {
            eye: dvec3(0.0, 0.0, 100.0),
            heading_deg: 0.0,
            pitch_deg: -20.0,
            fov_y_deg: 50.0,
            viewport_px: [640, 360],
        };
        let height = offsets.len() as u32 / width.max(1);
        let origin = dvec2(10_000_000.25, -3.5);
        CoordinateImage { width, height, origin, offsets, frame: 7, view }
    }

    #[test]
    fn only_sky_is_no_region() {
        assert_eq!(visible_region(&image(5, vec![[f32::NAN; 2]; 35])), None);
        assert_eq!(visible_region(&image(1, Vec::new())), None);
        assert_eq!(visible_region(&image(1, vec![[f32::INFINITY, 0.0]])), None);
    }

    #[test]
    fn one_pixel_is_a_degenerate_region() {
        let mut offsets = vec![[f32::NAN; 2]; 21];
        offsets[19] = [-2.5, 8.0];
        let region = visible_region(&image(7, offsets)).unwrap();
        assert_eq!(region.covered_pixels, 1);
        assert_eq!(region.extent().min, dvec2(9_999_997.75, 4.5));
        assert_eq!(region.max_m, region.min_m);
    }

    proptest! {
        #[test]
        fn the_box_is_that_of_a_plain_scan(
            pixels in prop::collection::vec(
                prop::option::of((-1.0e5f32..1.0e5, -1.0e5f32..1.0e5)), 0..200)
        ) {
            let offsets = pixels.iter().map(|p| p.map_or([f32::NAN; 2], |(x, y)| [x, y])).collect();
            let image = image(1, offsets);
            let ground: Vec<_> = pixels
                .iter()
                .flatten()
                .map(|&(x, y)| image.origin + dvec2(f64::from(x), f64::from(y)))
                .collect();
            let expected = ground
                .iter()
                .map(|&point| Extent::new(point, point))
                .reduce(|a, b| a.union(&b))
                .map(|extent| (extent, ground.len() as u32));
            let found = visible_region(&image);
            prop_assert_eq!(found.map(|r| (r.extent(), r.covered_pixels)), expected);
        }
    }
}

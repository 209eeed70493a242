use glam::{DVec2, dvec2};

use crate::CameraView;
use crate::tiling::Extent;

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
    /// The box.
    pub extent: Extent,
    /// Pixels that see ground, at least 1.
    pub covered_pixels: u32,
}

/// Smallest and largest coordinates of the pixels scanned so far, and how many saw ground.
#[derive(Clone, Copy)]
struct Bounds {
    min: [f32; 2],
    max: [f32; 2],
    covered: u32,
}

/// Pixels whose bounds are kept side by side, so that the compiler can use vector registers.
const LANES: usize = 8;

/// Step 1 of the paper's tile selection: minX, minY, maxX and maxY over the coordinate image.
///
/// `None` where no pixel sees ground. Pixels with an infinite or NaN coordinate count as sky.
///
/// The scan is one thread's work: at 512 x 288 pixels it takes tens of microseconds, less than it
/// costs to wake a pool of threads.
pub fn visible_region(image: &CoordinateImage) -> Option<VisibleRegion> {
    let mut lanes = [Bounds::EMPTY; LANES];
    let mut chunks = image.offsets.chunks_exact(LANES);
    for chunk in &mut chunks {
        for (lane, &offset) in lanes.iter_mut().zip(chunk) {
            lane.add(offset);
        }
    }
    for (lane, &offset) in lanes.iter_mut().zip(chunks.remainder()) {
        lane.add(offset);
    }
    let bounds = lanes.into_iter().fold(Bounds::EMPTY, Bounds::joined);
    let corner = |[east, north]: [f32; 2]| image.origin + dvec2(f64::from(east), f64::from(north));
    (bounds.covered > 0).then(|| VisibleRegion {
        extent: Extent::new(corner(bounds.min), corner(bounds.max)),
        covered_pixels: bounds.covered,
    })
}

impl Bounds {
    const EMPTY: Self = Self { min: [f32::INFINITY; 2], max: [f32::NEG_INFINITY; 2], covered: 0 };

    #[inline]
    fn add(&mut self, [east, north]: [f32; 2]) {
        // Without branches: sky adds values that change neither bound.
        let is_ground = (east.abs() < f32::INFINITY) & (north.abs() < f32::INFINITY);
        for (axis, value) in [east, north].into_iter().enumerate() {
            let low = if is_ground { value } else { f32::INFINITY };
            let high = if is_ground { value } else { f32::NEG_INFINITY };
            self.min[axis] = if low < self.min[axis] { low } else { self.min[axis] };
            self.max[axis] = if high > self.max[axis] { high } else { self.max[axis] };
        }
        self.covered += u32::from(is_ground);
    }

    fn joined(self, other: Self) -> Self {
        Self {
            min: [self.min[0].min(other.min[0]), self.min[1].min(other.min[1])],
            max: [self.max[0].max(other.max[0]), self.max[1].max(other.max[1])],
            covered: self.covered + other.covered,
        }
    }
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
        assert_eq!(region.extent.min, dvec2(9_999_997.75, 4.5));
        assert_eq!(region.extent.max, region.extent.min);
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
                .map(|extent| VisibleRegion { extent, covered_pixels: ground.len() as u32 });
            prop_assert_eq!(visible_region(&image), expected);
        }
    }
}

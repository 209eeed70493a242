use std::sync::LazyLock;

use glam::{DVec2, DVec3, Vec3, Vec4, dvec2};

/// The region of angular error of a point: what a cone cuts out of the surface. The cone's apex lies
/// at a distance on the surface's normal at the point, and its axis is that normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// The point, metres.
    pub centre: DVec3,
    /// Unit normal there.
    pub normal: DVec3,
    /// Distance of the apex from the point, metres.
    pub distance_m: f64,
    /// Full angle at the apex, radians; below pi.
    pub apex_angle_rad: f64,
}

impl Footprint {
    /// Where the cone's apex is.
    pub fn apex(&self) -> DVec3 {
        self.centre + self.normal * self.distance_m
    }

    /// Radius in metres of the circle that the cone cuts out of the tangent plane.
    pub fn radius_m(&self) -> f64 {
        self.distance_m * (0.5 * self.apex_angle_rad).tan()
    }

    /// Points of the tangent plane at places in that circle, its radius being 1.
    pub fn on_tangent_plane(
        &self,
        places: impl Iterator<Item = DVec2>,
    ) -> impl Iterator<Item = DVec3> {
        let (a, b) = self.normal.any_orthonormal_pair();
        let (centre, radius_m) = (self.centre, self.radius_m());
        let (a, b) = (a * radius_m, b * radius_m);
        places.map(move |place| centre + a * place.x + b * place.y)
    }
}

/// What gives a footprint its colour.
pub trait FootprintIntegral: Sync {
    /// The mean colour of the footprint, linear light.
    fn mean_colour(&self, footprint: &Footprint) -> Vec3;
}

/// A texture on a surface, by whatever projection: it is asked for points of the surface.
pub trait SurfaceTexture: Sync {
    /// Linear light at a point of the surface, multiplied by its coverage (the last part: 1 where
    /// there is texture, 0 where there is none). `sample_size_m` is the side of the square that the
    /// sample stands for; a texture may average over as much.
    fn colour(&self, point: DVec3, sample_size_m: f64) -> Vec4;
}

/// The shape of a surface around a footprint.
pub trait Relief: Sync {
    /// Where the ray from the apex through a point of the tangent plane meets the surface.
    fn meet(&self, apex: DVec3, through: DVec3) -> DVec3;
}

/// A surface that is its own tangent plane.
pub struct FlatRelief;

impl Relief for FlatRelief {
    fn meet(&self, _apex: DVec3, through: DVec3) -> DVec3 {
        through
    }
}

/// Integrates any texture over the footprint on any relief, by sampling until the mean stands.
///
/// The cone's cross-section is cut into n x n parts of equal area (the concentric map of Shirley and
/// Chiu, "A Low Distortion Map Between Disk and Square", 1997), each sampled in its middle. n grows
/// through 5, 8, 13, 21, 34 and 55, which share no factors so that two neighbours seldom agree by chance,
/// until the mean changes by no more than the tolerance in any channel.
pub struct ConvergedQuadrature<T, R> {
    /// The texture.
    pub texture: T,
    /// The surface.
    pub relief: R,
    /// Largest change of the mean that counts as standing, in linear light.
    pub tolerance: f32,
    /// The colour of ground without texture, linear light.
    pub bare_colour: Vec3,
}

impl<T, R> ConvergedQuadrature<T, R> {
    /// The tolerance of preparing: half a step of 255 in linear light.
    pub const TOLERANCE: f32 = 0.002;
}

impl<T: SurfaceTexture, R: Relief> ConvergedQuadrature<T, R> {
    /// The mean over the places of a pattern.
    fn mean_of(&self, footprint: &Footprint, pattern: &Pattern) -> Vec4 {
        let apex = footprint.apex();
        let sample_size_m = 2.0 * footprint.radius_m() / f64::from(pattern.side);
        let sum: Vec4 = footprint
            .on_tangent_plane(pattern.places.iter().copied())
            .map(|through| self.texture.colour(self.relief.meet(apex, through), sample_size_m))
            .sum();
        sum / pattern.places.len() as f32
    }

    fn over_bare(&self, mean: Vec4) -> Vec3 {
        if mean.w > 0.0 { mean.truncate() / mean.w } else { self.bare_colour }
    }
}

impl<T: SurfaceTexture, R: Relief> FootprintIntegral for ConvergedQuadrature<T, R> {
    fn mean_colour(&self, footprint: &Footprint) -> Vec3 {
        let mut mean = None;
        for pattern in &*PATTERNS {
            let finer = self.over_bare(self.mean_of(footprint, pattern));
            let stands = |before: Vec3| (finer - before).abs().max_element() <= self.tolerance;
            if mean.replace(finer).is_some_and(stands) {
                break;
            }
        }
        mean.unwrap_or(self.bare_colour)
    }
}

/// Samples a side. On a black and white edge that the texture does not average, the hardest there is,
/// the mean is within 0.002 of the exact one with the last of them, and within 0.03 where a sliver at
/// the footprint's rim escapes the first two.
const SIDES: [u32; 6] = [5, 8, 13, 21, 34, 55];

/// Places in the unit disc, each the middle of an equal area.
struct Pattern {
    side: u32,
    places: Vec<DVec2>,
}

static PATTERNS: LazyLock<[Pattern; 6]> = LazyLock::new(|| {
    SIDES.map(|side| {
        let middle = |index: u32| (f64::from(index) + 0.5) / f64::from(side) * 2.0 - 1.0;
        let squares = (0..side * side).map(|i| dvec2(middle(i % side), middle(i / side)));
        Pattern { side, places: squares.map(disc_from_square).collect() }
    })
});

/// Maps the square -1..1 onto the unit disc so that areas keep their proportions.
fn disc_from_square(square: DVec2) -> DVec2 {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
    if square == DVec2::ZERO {
        return DVec2::ZERO;
    }
    let (radius, angle) = if square.x.abs() > square.y.abs() {
        (square.x, FRAC_PI_4 * (square.y / square.x))
    } else {
        (square.y, FRAC_PI_2 - FRAC_PI_4 * (square.x / square.y))
    };
    radius * dvec2(angle.cos(), angle.sin())
}

/// The part of a circle's area that lies beyond a straight line: `line_m` from the centre to the line
/// in the direction of the part, negative where the centre lies beyond it too. Exact: a circular
/// segment.
pub fn disc_part_beyond(line_m: f64, radius_m: f64) -> f64 {
    let u = (line_m / radius_m).clamp(-1.0, 1.0);
    (u.acos() - u * (1.0 - u * u).sqrt()) / std::f64::consts::PI
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White where the dot product with the normal exceeds the offset.
    struct HalfPlane {
        normal: DVec2,
        offset_m: f64,
    }

    impl SurfaceTexture for HalfPlane {
        fn colour(&self, point: DVec3, _: f64) -> Vec4 {
            let white = point.truncate().dot(self.normal) > self.offset_m;
            Vec3::splat(f32::from(white)).extend(1.0)
        }
    }

    fn quadrature<T, R>(texture: T, relief: R) -> ConvergedQuadrature<T, R> {
        let tolerance = ConvergedQuadrature::<T, R>::TOLERANCE;
        ConvergedQuadrature { texture, relief, tolerance, bare_colour: Vec3::ZERO }
    }

    fn down_at(centre: DVec3, distance_m: f64) -> Footprint {
        Footprint { centre, normal: DVec3::Z, distance_m, apex_angle_rad: 0.02 }
    }

    #[test]
    fn a_part_of_a_disc_is_that_of_a_fine_count() {
        for line in [-1.5, -0.8, -0.1, 0.0, 0.3, 0.99, 2.0] {
            let side = 1000;
            let mut counts = [0; 2];
            for (x, y) in (0..side).flat_map(|x| (0..side).map(move |y| (x, y))) {
                let at = |i: i32| (f64::from(i) + 0.5) / 500.0 - 1.0;
                if at(x).hypot(at(y)) < 1.0 {
                    counts[0] += 1;
                    counts[1] += i32::from(at(x) > line);
                }
            }
            let expected = f64::from(counts[1]) / f64::from(counts[0]);
            assert!((disc_part_beyond(3.0 * line, 3.0) - expected).abs() < 1e-3, "{line}");
        }
    }

    #[test]
    fn an_edge_is_integrated_to_the_stated_error() {
        let mut worst = 0.0_f64;
        for index in 0..200 {
            let angle = 0.1 * f64::from(index);
            let offset_m = 12.0 * (1.7 * f64::from(index)).sin();
            let normal = dvec2(angle.cos(), angle.sin());
            let footprint = down_at(DVec3::new(3.0, -2.0, 5.0), 1000.0);
            let line_m = offset_m - footprint.centre.truncate().dot(normal);
            let exact = disc_part_beyond(line_m, footprint.radius_m());
            let mean =
                quadrature(HalfPlane { normal, offset_m }, FlatRelief).mean_colour(&footprint);
            worst = worst.max((f64::from(mean.x) - exact).abs());
        }
        println!("worst error of the quadrature at an edge: {worst:.5}");
        assert!(worst < 0.03);
        // With the most samples, whatever the change: what the constant's documentation states.
        let mut finest = 0.0_f64;
        for index in 0..200 {
            let angle = 0.37 * f64::from(index);
            let offset_m = 9.0 * (2.3 * f64::from(index)).cos();
            let normal = dvec2(angle.cos(), angle.sin());
            let footprint = down_at(DVec3::ZERO, 1000.0);
            let exact = disc_part_beyond(offset_m, footprint.radius_m());
            let quadrature = quadrature(HalfPlane { normal, offset_m }, FlatRelief);
            let mean = quadrature.mean_of(&footprint, &PATTERNS[5]);
            finest = finest.max((f64::from(mean.x) - exact).abs());
        }
        println!("with 55 x 55 samples: {finest:.5}");
        assert!(finest < 0.002);
    }

    /// Linear in x, so that its mean over a disc is its value in the middle.
    struct Ramp;

    impl SurfaceTexture for Ramp {
        fn colour(&self, point: DVec3, _: f64) -> Vec4 {
            Vec4::new(0.5 + 0.01 * point.x as f32, 0.25, 0.0, 1.0)
        }
    }

    #[test]
    fn the_footprint_of_a_slope_is_foreshortened_from_above() {
        let normal = DVec3::new(1.0, 0.0, 1.0).normalize();
        let footprint = Footprint { normal, ..down_at(DVec3::ZERO, 1000.0) };
        assert!((footprint.radius_m() - 10.0).abs() < 1e-2);
        let mut widest = DVec2::ZERO;
        for step in 0..360 {
            let angle = f64::from(step).to_radians();
            let rim = std::iter::once(dvec2(angle.cos(), angle.sin()));
            let point = footprint.on_tangent_plane(rim).next().unwrap();
            assert!(point.dot(normal).abs() < 1e-9);
            widest = widest.max(point.truncate().abs());
        }
        assert!((widest.y - footprint.radius_m()).abs() < 1e-2);
        assert!((widest.x - footprint.radius_m() * 0.5_f64.sqrt()).abs() < 1e-2);
        let mean = quadrature(Ramp, FlatRelief).mean_colour(&footprint);
        assert!((mean - Vec3::new(0.5, 0.25, 0.0)).length() < 1e-4);
    }

    /// A step down by 100 m east of x = 0.
    struct Cliff;

    impl Relief for Cliff {
        fn meet(&self, apex: DVec3, through: DVec3) -> DVec3 {
            if through.x < 0.0 {
                return through;
            }
            apex + (through - apex) * ((apex.z + 100.0) / apex.z)
        }
    }

    #[test]
    fn the_cone_is_cut_by_the_surface_not_by_its_tangent_plane() {
        let mean = quadrature(Ramp, Cliff).mean_colour(&down_at(DVec3::ZERO, 1000.0));
        // East of the cliff places lie a tenth farther out; a half disc's centroid is 4 r / (3 pi).
        let shift_m = 0.5 * 0.1 * 4.0 * 10.0 / (3.0 * std::f64::consts::PI);
        assert!((f64::from(mean.x) - 0.5 - 0.01 * shift_m).abs() < 2e-4, "{}", mean.x);
    }

    /// Nothing at all.
    struct Bare;

    impl SurfaceTexture for Bare {
        fn colour(&self, _: DVec3, _: f64) -> Vec4 {
            Vec4::ZERO
        }
    }

    #[test]
    fn ground_without_texture_has_the_bare_colour() {
        let bare = ConvergedQuadrature {
            bare_colour: Vec3::new(0.1, 0.2, 0.3),
            ..quadrature(Bare, FlatRelief)
        };
        assert_eq!(bare.mean_colour(&down_at(DVec3::ZERO, 10.0)), Vec3::new(0.1, 0.2, 0.3));
    }
}

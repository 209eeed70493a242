use std::f64::consts::PI;

use glam::{DVec2, dvec2};

use crate::tiling::{Extent, TilingScheme};

/// The plate carrée of WGS 84 (EPSG:32662): longitude and latitude as lengths along a circle of the equator's
/// radius. Snyder, "Map Projections: A Working Manual" (1987), equidistant cylindrical, sphere.
pub struct PlateCarree;

impl PlateCarree {
    /// The EPSG code.
    pub const EPSG: u32 = 32662;
    /// Radius of the equator, metres.
    pub const RADIUS_M: f64 = 6_378_137.0;
    /// Length of the equator, metres.
    pub const EQUATOR_M: f64 = 2.0 * PI * Self::RADIUS_M;

    /// Where the tiles of a globe lie: the root is a square of the equator's length a side, the upper half of which is
    /// the Earth.
    pub fn scheme() -> TilingScheme {
        let origin = dvec2(-0.5 * Self::EQUATOR_M, 0.25 * Self::EQUATOR_M);
        TilingScheme { origin, root_size_m: Self::EQUATOR_M }
    }

    /// All longitudes and latitudes.
    pub fn extent() -> Extent {
        let corner = dvec2(0.5 * Self::EQUATOR_M, 0.25 * Self::EQUATOR_M);
        Extent::new(-corner, corner)
    }

    /// East and north in metres of a longitude and latitude in degrees.
    pub fn metres_from_degrees(degrees: DVec2) -> DVec2 {
        dvec2(degrees.x.to_radians(), degrees.y.to_radians()) * Self::RADIUS_M
    }

    /// The reverse of [`Self::metres_from_degrees`].
    pub fn degrees_from_metres(metres: DVec2) -> DVec2 {
        let radians = metres / Self::RADIUS_M;
        dvec2(radians.x.to_degrees(), radians.y.to_degrees())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy::{CoordinateSystem, CoordinateTransform};

    #[test]
    fn it_is_the_projection_of_its_code() {
        let wgs84 = CoordinateSystem::from_epsg(CoordinateSystem::WGS84).unwrap();
        let own = CoordinateSystem::from_epsg(PlateCarree::EPSG).unwrap();
        let transform = CoordinateTransform::new(&wgs84, &own);
        for degrees in [dvec2(-180.0, 90.0), dvec2(12.5, -41.75), dvec2(179.0, -90.0)] {
            let metres = PlateCarree::metres_from_degrees(degrees);
            let expected = transform.apply(degrees).unwrap();
            assert!((metres - expected).length() < 1.0e-6, "{degrees}: {metres} {expected}");
            assert!((PlateCarree::degrees_from_metres(metres) - degrees).length() < 1.0e-12);
        }
    }
}

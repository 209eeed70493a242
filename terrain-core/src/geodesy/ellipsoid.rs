use glam::{DMat3, DVec2, DVec3, dvec2, dvec3};

use super::PlateCarree;

/// The ellipsoid of WGS 84 (NIMA, "Department of Defense World Geodetic System 1984", TR8350.2, 2000).
///
/// Places are earth-centred and earth-fixed: metres, x towards longitude 0 on the equator, y towards longitude
/// 90 degrees east, z towards the north pole.
pub struct Wgs84;

/// A place by angles: radians, as all trigonometry has them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geodetic {
    /// Radians east of Greenwich.
    pub longitude_rad: f64,
    /// Radians north of the equator: the angle of the ellipsoid's normal with its plane.
    pub latitude_rad: f64,
    /// Metres above the ellipsoid along its normal.
    pub height_m: f64,
}

impl Wgs84 {
    /// Radius of the equator, metres.
    pub const EQUATOR_RADIUS_M: f64 = PlateCarree::RADIUS_M;
    /// How much shorter the polar radius is, in parts of the equator's.
    pub const FLATTENING: f64 = 1.0 / 298.257_223_563;
    /// Distance of the poles from the centre, metres.
    pub const POLAR_RADIUS_M: f64 = Self::EQUATOR_RADIUS_M * (1.0 - Self::FLATTENING);
    /// Square of the first eccentricity.
    pub const ECCENTRICITY_SQUARED: f64 = Self::FLATTENING * (2.0 - Self::FLATTENING);

    /// Radius of curvature in metres across the meridian, where the latitude has this sine: how far along the
    /// normal the axis is.
    pub fn normal_radius_m(sin_latitude: f64) -> f64 {
        Self::EQUATOR_RADIUS_M / (1.0 - Self::ECCENTRICITY_SQUARED * sin_latitude.powi(2)).sqrt()
    }

    /// Radius of curvature in metres along the meridian, where the latitude has this sine.
    pub fn meridian_radius_m(sin_latitude: f64) -> f64 {
        let across_m = Self::normal_radius_m(sin_latitude);
        let ratio = across_m / Self::EQUATOR_RADIUS_M;
        across_m * (1.0 - Self::ECCENTRICITY_SQUARED) * ratio.powi(2)
    }

    /// The place so many metres above the point of the ellipsoid that has this unit normal.
    pub fn ecef_from_normal(normal: DVec3, height_m: f64) -> DVec3 {
        let radius_m = Self::normal_radius_m(normal.z);
        let polar_m = radius_m * (1.0 - Self::ECCENTRICITY_SQUARED);
        normal * dvec3(radius_m, radius_m, polar_m) + normal * height_m
    }

    /// The place in earth-centred coordinates.
    pub fn ecef_from_geodetic(place: &Geodetic) -> DVec3 {
        Self::ecef_from_normal(place.normal(), place.height_m)
    }

    /// The angles and height of a place; longitude within -pi..=pi.
    ///
    /// Bowring's formula, repeated: exact to the last bits of f64 from the ground to far beyond the Moon after
    /// three steps. B. R. Bowring, "Transformation from spatial to geographical coordinates", Survey Review 23
    /// (1976). At the earth's centre the latitude is some number.
    pub fn geodetic_from_ecef(place: DVec3) -> Geodetic {
        const STEPS: u32 = 3;
        let (a, b) = (Self::EQUATOR_RADIUS_M, Self::POLAR_RADIUS_M);
        let e2 = Self::ECCENTRICITY_SQUARED;
        let from_axis_m = place.x.hypot(place.y);
        // Sine and cosine of the reduced latitude.
        let mut reduced = dvec2(from_axis_m * b, place.z * a).normalize_or(DVec2::X);
        let mut meridian = DVec2::X;
        for _ in 0..STEPS {
            let east = from_axis_m - e2 * a * reduced.x.powi(3);
            let north = place.z + e2 * a * a / b * reduced.y.powi(3);
            meridian = dvec2(east, north).normalize_or(DVec2::X);
            reduced =
                dvec2(meridian.x, meridian.y * (1.0 - Self::FLATTENING)).normalize_or(DVec2::X);
        }
        let on_ground_m = a * (1.0 - e2 * meridian.y.powi(2)).sqrt();
        Geodetic {
            longitude_rad: place.y.atan2(place.x),
            latitude_rad: meridian.y.atan2(meridian.x),
            height_m: from_axis_m * meridian.x + place.z * meridian.y - on_ground_m,
        }
    }
}

impl Geodetic {
    /// Of a place on a globe whose coordinates are those of the [`PlateCarree`]: metres east and north along the
    /// equator's circle, and above the ellipsoid. Longitudes beyond half a turn count on, latitudes beyond a pole
    /// are the pole's.
    pub fn from_plate_carree(place: DVec3) -> Self {
        let angles = place.truncate() / PlateCarree::RADIUS_M;
        let quarter = std::f64::consts::FRAC_PI_2;
        Self {
            longitude_rad: angles.x,
            latitude_rad: angles.y.clamp(-quarter, quarter),
            height_m: place.z,
        }
    }

    /// Of a point that an eye over a globe sees: both in metres on the [`PlateCarree`] and above the ellipsoid, the
    /// point as the eye's place and what there is from it to the point in the eye's directions east, north and up.
    pub fn of_seen(eye: DVec3, point: DVec3) -> Self {
        let place = Self::from_plate_carree(eye);
        let ecef = Wgs84::ecef_from_geodetic(&place) + place.ecef_from_local() * (point - eye);
        Wgs84::geodetic_from_ecef(ecef)
    }

    /// Metres east and north on the [`PlateCarree`].
    pub fn plate_carree(&self) -> DVec2 {
        dvec2(self.longitude_rad, self.latitude_rad) * PlateCarree::RADIUS_M
    }

    /// The ellipsoid's unit normal.
    pub fn normal(&self) -> DVec3 {
        let (sin_lat, cos_lat) = self.latitude_rad.sin_cos();
        let (sin_lon, cos_lon) = self.longitude_rad.sin_cos();
        dvec3(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
    }

    /// The unit directions east, north and up as columns, in earth-centred coordinates. At a pole east is that of
    /// the longitude.
    pub fn ecef_from_local(&self) -> DMat3 {
        let (sin_lat, cos_lat) = self.latitude_rad.sin_cos();
        let (sin_lon, cos_lon) = self.longitude_rad.sin_cos();
        DMat3::from_cols(
            dvec3(-sin_lon, cos_lon, 0.0),
            dvec3(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat),
            dvec3(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat),
        )
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn at_degrees(longitude: f64, latitude: f64, height_m: f64) -> Geodetic {
        let (longitude_rad, latitude_rad) = (longitude.to_radians(), latitude.to_radians());
        Geodetic { longitude_rad, latitude_rad, height_m }
    }

    #[test]
    fn the_figures_are_the_published_ones() {
        // TR8350.2, tables 3.1 and 3.3.
        assert!((Wgs84::POLAR_RADIUS_M - 6_356_752.314_2).abs() < 5.0e-5);
        assert!((Wgs84::ECCENTRICITY_SQUARED - 6.694_379_990_14e-3).abs() < 5.0e-15);
        let pole_radius_m = Wgs84::EQUATOR_RADIUS_M.powi(2) / Wgs84::POLAR_RADIUS_M;
        assert!((pole_radius_m - 6_399_593.625_8).abs() < 5.0e-5, "{pole_radius_m}");
        for radius in [Wgs84::normal_radius_m(1.0), Wgs84::meridian_radius_m(1.0)] {
            assert!((radius - pole_radius_m).abs() < 1.0e-8, "both meet at a pole");
        }
    }

    #[test]
    fn a_published_place_is_where_it_should_be() {
        // The worked example of EPSG guidance note 7-2, method 9602: WGS 84.
        let place = at_degrees(
            2.0 + 7.0 / 60.0 + 46.38 / 3600.0,
            53.0 + 48.0 / 60.0 + 33.82 / 3600.0,
            73.0,
        );
        let ecef = Wgs84::ecef_from_geodetic(&place);
        assert!(
            (ecef - dvec3(3_771_793.968, 140_253.342, 5_124_304.349)).length() < 1.0e-3,
            "{ecef}"
        );
    }

    #[test]
    fn what_an_eye_sees_is_at_its_own_place() {
        let eye = PlateCarree::metres_from_degrees(dvec2(-179.99, 62.0)).extend(2.0e5);
        let below = Geodetic::of_seen(eye, eye - 2.0e5 * DVec3::Z);
        assert!((below.plate_carree() - eye.truncate()).length() < 1.0e-6, "{below:?}");
        assert!(below.height_m.abs() < 1.0e-6, "{below:?}");
        // West across the date line.
        let there = at_degrees(179.99, 62.0, 0.0);
        let place = Geodetic::from_plate_carree(eye);
        let step = Wgs84::ecef_from_geodetic(&there) - Wgs84::ecef_from_geodetic(&place);
        let seen = Geodetic::of_seen(eye, eye + place.ecef_from_local().transpose() * step);
        assert!((seen.longitude_rad - there.longitude_rad).abs() < 1.0e-12, "{seen:?}");
        assert!((seen.latitude_rad - there.latitude_rad).abs() < 1.0e-12, "{seen:?}");
    }

    #[test]
    fn on_the_axis_and_at_the_centre_it_stays_finite() {
        for (z, latitude) in [(7.0e6, 90.0), (-6.4e6, -90.0)] {
            let place = Wgs84::geodetic_from_ecef(dvec3(0.0, 0.0, z));
            assert!((place.latitude_rad.to_degrees() - latitude).abs() < 1.0e-12, "{place:?}");
            assert!(
                (place.height_m - (z.abs() - Wgs84::POLAR_RADIUS_M)).abs() < 2.0e-9,
                "{place:?}"
            );
        }
        let centre = Wgs84::geodetic_from_ecef(DVec3::ZERO);
        assert!(centre.latitude_rad.is_finite() && centre.height_m.is_finite());
    }

    proptest! {
        #[test]
        fn there_and_back_is_the_same_place(
            longitude in -180.0..180.0,
            latitude in -90.0..=90.0,
            exponent in -1.0..8.0,
            sign in prop::bool::ANY,
        ) {
            let away_m = 10.0_f64.powf(exponent);
            let height_m = if sign { away_m } else { -away_m.min(1.2e4) };
            let place = at_degrees(longitude, latitude, height_m);
            let ecef = Wgs84::ecef_from_geodetic(&place);
            let back = Wgs84::geodetic_from_ecef(ecef);
            let missed_m = (Wgs84::ecef_from_geodetic(&back) - ecef).length();
            // A last bit of a coordinate is 0.93e-9 m at the surface, and one of either angle moves as far.
            prop_assert!(missed_m < 5.0e-9 * (1.0 + height_m.max(0.0) / 6.4e6), "{missed_m}");
            prop_assert!((back.height_m - height_m).abs() < 5.0e-9 * (1.0 + height_m.abs() / 6.4e6));
            prop_assert!((back.latitude_rad - place.latitude_rad).abs() < 1.0e-15);
        }

        #[test]
        fn the_frame_follows_the_ground(longitude in -180.0..180.0, latitude in -89.9..89.9) {
            let here = at_degrees(longitude, latitude, 0.0);
            let frame = here.ecef_from_local();
            let step = 1.0e-6;
            let ecef = |lon: f64, lat: f64| {
                Wgs84::ecef_from_geodetic(&Geodetic {
                    longitude_rad: here.longitude_rad + lon,
                    latitude_rad: here.latitude_rad + lat,
                    height_m: 0.0,
                })
            };
            let (sin_lat, cos_lat) = here.latitude_rad.sin_cos();
            let east = (ecef(step, 0.0) - ecef(-step, 0.0)) / (2.0 * step);
            let north = (ecef(0.0, step) - ecef(0.0, -step)) / (2.0 * step);
            prop_assert!((east - frame.x_axis * Wgs84::normal_radius_m(sin_lat) * cos_lat).length() < 0.01);
            prop_assert!((north - frame.y_axis * Wgs84::meridian_radius_m(sin_lat)).length() < 0.01);
            prop_assert!((frame.x_axis.cross(frame.y_axis) - frame.z_axis).length() < 1.0e-15);
            prop_assert!((frame.z_axis - here.normal()).length() < 1.0e-15);
        }
    }
}

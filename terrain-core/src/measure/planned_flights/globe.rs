use glam::{DVec2, dvec2};

use super::{FlightGround, PlannedFlight};
use crate::dataset::Shape;
use crate::geodesy::{CoordinateSystem, PlateCarree};
use crate::measure::{Flight, FlightError};
use crate::tiling::Extent;

/// Side of the ground that flights over a globe are made for: small enough to be all but flat from as high as low
/// flights go, large enough for high ones to see the Earth's edge.
const SIDE_M: f64 = 2.0e6;
/// Latitudes beyond which no highest ground is looked for: nearer to a pole such ground would be far from a square.
const MOST_LATITUDE_DEG: f64 = 55.0;
/// Columns and rows of the grid that the highest ground is looked for on.
const SURVEY: [u32; 2] = [180, 60];
/// Where to fly where no ground is higher than any other: the north of Italy.
const LEVEL_GROUND_DEG: DVec2 = dvec2(10.0, 45.0);

impl PlannedFlight {
    /// The flight over a globe: over the ground round its highest, as if that were a plane.
    ///
    /// `sample_m` and `height_m` are those of a [`FlightGround`], at positions in metres of the plate carrée.
    ///
    /// # Errors
    /// Never in practice: the ground has an area and its places are on Earth.
    pub fn over_globe(
        self,
        sample_m: f64,
        height_m: &dyn Fn(DVec2, f64) -> Option<f64>,
    ) -> Result<Flight, FlightError> {
        let centre_deg = highest_deg(height_m);
        let stretch = dvec2(1.0 / centre_deg.y.to_radians().cos(), 1.0);
        let degrees =
            |local_m: DVec2| centre_deg + PlateCarree::degrees_from_metres(local_m * stretch);
        let local_height_m = |local_m: DVec2, spacing_m: f64| {
            height_m(Shape::Globe.world_from_user(degrees(local_m)), spacing_m)
        };
        let corner = DVec2::splat(0.5 * SIDE_M);
        let ground = FlightGround {
            crs: "local".to_owned(),
            extent: Extent::new(-corner, corner),
            sample_m,
            height_m: &local_height_m,
        };
        let flight = self.over(&ground)?;
        flight.placed(format!("EPSG:{}", CoordinateSystem::WGS84), degrees)
    }
}

/// The longitude and latitude of the highest ground of a survey.
fn highest_deg(height_m: &dyn Fn(DVec2, f64) -> Option<f64>) -> DVec2 {
    let [columns, rows] = SURVEY.map(f64::from);
    let spacing_m = PlateCarree::EQUATOR_M / columns;
    let surveyed = (0..SURVEY[0] * SURVEY[1]).map(|index| {
        let place = dvec2(f64::from(index % SURVEY[0]) + 0.5, f64::from(index / SURVEY[0]) + 0.5);
        let longitude_deg = 360.0 * place.x / columns - 180.0;
        let latitude_deg = MOST_LATITUDE_DEG * (1.0 - 2.0 * place.y / rows);
        let place_deg = dvec2(longitude_deg, latitude_deg);
        let height_m = height_m(PlateCarree::metres_from_degrees(place_deg), spacing_m);
        (place_deg, height_m.filter(|height_m| height_m.is_finite()).unwrap_or(0.0))
    });
    let (mut highest, mut lowest_m) = ((LEVEL_GROUND_DEG, f64::NEG_INFINITY), f64::INFINITY);
    for found in surveyed {
        lowest_m = lowest_m.min(found.1);
        if found.1 > highest.1 {
            highest = found;
        }
    }
    if highest.1 > lowest_m { highest.0 } else { LEVEL_GROUND_DEG }
}

//! Where a place is: coordinate reference systems by EPSG code and the transforms between them.
//!
//! Pure f64. Geographic coordinates are longitude, latitude in *degrees* everywhere outside this
//! module; projected ones are x east, y north in the CRS's own unit.

mod coordinate_system;
mod coordinate_transform;
mod ellipsoid;
mod epsg_names;
mod plate_carree;

pub use coordinate_system::{CoordinateSystem, CrsError};
pub use coordinate_transform::CoordinateTransform;
pub use ellipsoid::{Geodetic, Wgs84};
pub use epsg_names::{epsg_name, utm_epsg};
pub use plate_carree::PlateCarree;

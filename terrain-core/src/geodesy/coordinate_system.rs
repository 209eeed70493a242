use proj4rs::Proj;

use super::epsg_name;

/// A coordinate reference system known by its EPSG code.
#[derive(Clone)]
pub struct CoordinateSystem {
    epsg: u32,
    proj: Proj,
}

/// Why a coordinate reference system cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CrsError {
    /// No such code, or a projection that is not supported.
    #[error("EPSG:{epsg} is not a coordinate reference system this program knows ({reason})")]
    Unknown {
        /// The code asked for.
        epsg: u32,
        /// What the projection library said.
        reason: String,
    },
}

impl CoordinateSystem {
    /// WGS 84 longitude and latitude.
    pub const WGS84: u32 = 4326;

    /// Looks the code up.
    pub fn from_epsg(epsg: u32) -> Result<Self, CrsError> {
        let unknown = |reason: String| CrsError::Unknown { epsg, reason };
        let code = u16::try_from(epsg).map_err(|_| unknown("no such code".to_owned()))?;
        let proj = Proj::from_epsg_code(code).map_err(|error| unknown(error.to_string()))?;
        Ok(Self { epsg, proj })
    }

    /// The EPSG code.
    pub fn epsg(&self) -> u32 {
        self.epsg
    }

    /// A name for people.
    pub fn name(&self) -> String {
        epsg_name(self.epsg)
    }

    /// Whether coordinates are longitude and latitude in degrees.
    pub fn is_geographic(&self) -> bool {
        self.proj.is_latlong()
    }

    /// Metres one unit of a projected system stands for.
    pub fn metres_per_unit(&self) -> f64 {
        self.proj.to_meter()
    }

    /// Longitude in degrees of the central meridian; 0 where the system has none.
    pub fn central_meridian_deg(&self) -> f64 {
        let meridian_deg = self.proj.longitude_of_origin().to_degrees();
        if meridian_deg.is_finite() { meridian_deg } else { 0.0 }
    }

    /// The latitudes in degrees the system can show: a Mercator map runs to infinity at the poles
    /// and is cut where it is square.
    pub fn latitude_limits_deg(&self) -> [f64; 2] {
        const SQUARE_MERCATOR_DEG: f64 = 85.051_128_779_8;
        match self.proj.projname() {
            "merc" | "webmerc" => [-SQUARE_MERCATOR_DEG, SQUARE_MERCATOR_DEG],
            _ => [-90.0, 90.0],
        }
    }

    pub(super) fn proj(&self) -> &Proj {
        &self.proj
    }
}

impl std::fmt::Debug for CoordinateSystem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "EPSG:{}", self.epsg)
    }
}

impl PartialEq for CoordinateSystem {
    fn eq(&self, other: &Self) -> bool {
        self.epsg == other.epsg
    }
}

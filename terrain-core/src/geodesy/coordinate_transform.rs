use glam::{DVec2, dvec2};
use proj4rs::adaptors::transform_xy;

use super::CoordinateSystem;

/// Takes positions from one coordinate reference system to another.
#[derive(Clone, Debug)]
pub struct CoordinateTransform {
    from: CoordinateSystem,
    to: CoordinateSystem,
}

impl CoordinateTransform {
    /// The transform between two systems; nothing is computed where they are the same.
    pub fn new(from: &CoordinateSystem, to: &CoordinateSystem) -> Self {
        Self { from: from.clone(), to: to.clone() }
    }

    /// Whether positions come back unchanged.
    pub fn is_identity(&self) -> bool {
        self.from == self.to
    }

    /// The position in the target system, or `None` where it has none (outside the projection's
    /// domain, or not finite). Geographic positions are degrees, longitude first.
    pub fn apply(&self, position: DVec2) -> Option<DVec2> {
        if self.is_identity() {
            return position.is_finite().then_some(position);
        }
        let input = to_radians_if(self.from.is_geographic(), position);
        let (x, y) = transform_xy(self.from.proj(), self.to.proj(), input.x, input.y).ok()?;
        let output = to_degrees_if(self.to.is_geographic(), dvec2(x, y));
        output.is_finite().then_some(output)
    }
}

fn to_radians_if(geographic: bool, position: DVec2) -> DVec2 {
    if geographic { dvec2(position.x.to_radians(), position.y.to_radians()) } else { position }
}

fn to_degrees_if(geographic: bool, position: DVec2) -> DVec2 {
    if geographic { dvec2(position.x.to_degrees(), position.y.to_degrees()) } else { position }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn system(epsg: u32) -> CoordinateSystem {
        CoordinateSystem::from_epsg(epsg).unwrap()
    }

    /// Positions computed with an independent program (PROJ 9).
    #[test]
    fn known_positions_in_many_systems() {
        let cases = [
            (32632, dvec2(8.286, 61.512), dvec2(462_006.373_691, 6_820_026.478_034)),
            (32632, dvec2(10.0, 45.0), dvec2(578_815.302_917, 4_983_436.768_349)),
            (3857, dvec2(10.0, 45.0), dvec2(1_113_194.907_933, 5_621_521.486_192)),
            (3395, dvec2(10.0, 45.0), dvec2(1_113_194.907_933, 5_591_295.918_553)),
            (4087, dvec2(10.0, 45.0), dvec2(1_113_194.907_933, 5_009_377.085_697)),
            (6933, dvec2(8.286, 61.512), dvec2(799_485.318_159, 6_446_617.952_791)),
            (3035, dvec2(8.286, 61.512), dvec2(4_229_434.912_460, 4_269_003.392_364)),
        ];
        for (epsg, geographic, projected) in cases {
            let there = CoordinateTransform::new(&system(4326), &system(epsg));
            let got = there.apply(geographic).unwrap();
            assert!((got - projected).length() < 1e-4, "EPSG:{epsg} {got} {projected}");
            let back = CoordinateTransform::new(&system(epsg), &system(4326));
            let again = back.apply(got).unwrap();
            assert!((again.y - geographic.y).abs() < 1e-9, "EPSG:{epsg} {again}");
        }
    }

    #[test]
    fn an_unknown_code_is_an_error() {
        assert!(CoordinateSystem::from_epsg(1).is_err());
        assert!(CoordinateSystem::from_epsg(999_999).is_err());
    }
}

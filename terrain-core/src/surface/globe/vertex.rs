use glam::{DVec3, IVec3};
use half::f16;

/// A vertex of the globe as the GPU gets it: the `GlobeVertex` of `common/globe_vertex.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct GlobeVertex {
    /// Earth-centred place in whole steps of [`SplitPlace::COARSE_M`].
    pub coarse: [i32; 3],
    /// What is beyond them, in steps of [`SplitPlace::FINE_M`]; the last is 0.
    pub fine: [u16; 4],
    /// Metres above the ellipsoid, exaggerated as the place is.
    pub height_m: f32,
    /// Metres up per metre east and north, without exaggeration: two half floats.
    pub slope: [u16; 2],
}

/// An earth-centred place in whole numbers, so that differences from an eye are exact and the same for all who
/// share the place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SplitPlace {
    /// Steps of [`Self::COARSE_M`], rounded down.
    pub coarse: IVec3,
    /// The rest in steps of [`Self::FINE_M`]: 0 to 65535 each.
    pub fine: IVec3,
}

impl SplitPlace {
    /// Metres: differences between places within half a million kilometres fit an i32.
    pub const COARSE_M: f64 = 0.25;
    /// Metres: four thousandths of a millimetre.
    pub const FINE_M: f64 = Self::COARSE_M / 65_536.0;
    /// Farthest place from the centre along an axis, metres.
    const FARTHEST_M: f64 = 4.0e8;

    /// The nearest such place; farther out than 400,000 km that far.
    pub fn nearest(place: DVec3) -> Self {
        let inside = place.clamp(DVec3::splat(-Self::FARTHEST_M), DVec3::splat(Self::FARTHEST_M));
        let steps = (inside / Self::FINE_M).round().to_array().map(|steps| steps as i64);
        Self {
            coarse: IVec3::from_array(steps.map(|steps| (steps >> 16) as i32)),
            fine: IVec3::from_array(steps.map(|steps| (steps & 0xffff) as i32)),
        }
    }

    /// Where it is, metres.
    pub fn place(&self) -> DVec3 {
        self.coarse.as_dvec3() * Self::COARSE_M + self.fine.as_dvec3() * Self::FINE_M
    }
}

impl GlobeVertex {
    /// A vertex at an earth-centred place.
    pub fn new(place: DVec3, height_m: f64, slope: [f64; 2]) -> Self {
        let SplitPlace { coarse, fine } = SplitPlace::nearest(place);
        let [x, y, z] = fine.to_array().map(|fine| fine as u16);
        Self {
            coarse: coarse.to_array(),
            fine: [x, y, z, 0],
            height_m: height_m as f32,
            slope: slope.map(|slope| f16::from_f64(slope).to_bits()),
        }
    }

    /// Its place.
    pub fn split_place(&self) -> SplitPlace {
        let [x, y, z, _] = self.fine.map(i32::from);
        SplitPlace { coarse: IVec3::from_array(self.coarse), fine: IVec3::new(x, y, z) }
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    #[test]
    fn places_come_back_to_within_half_a_step() {
        for place in [
            dvec3(6_378_137.123_456, -0.000_001, 6.0e6),
            dvec3(-6_356_752.9, 1.0 / 3.0, -1.0e8),
            DVec3::ZERO,
        ] {
            let split = SplitPlace::nearest(place);
            let missed_m = (split.place() - place).abs().max_element();
            assert!(missed_m <= 0.5 * SplitPlace::FINE_M + 1.0e-8, "{place}: {missed_m}");
            let vertex = GlobeVertex::new(place, 12.0, [0.5, -0.25]);
            assert_eq!(vertex.split_place(), split);
        }
        assert_eq!(SplitPlace::nearest(dvec3(1.0e12, 0.0, 0.0)).place().x, 4.0e8);
    }
}

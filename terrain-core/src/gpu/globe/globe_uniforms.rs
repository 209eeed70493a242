use encase::{ShaderSize, ShaderType, UniformBuffer};
use glam::{DVec3, IVec2, IVec3, Mat3, Vec2, Vec3, dvec2};

use crate::geodesy::{Geodetic, Wgs84};
use crate::residency::page_table::PageLayout;
use crate::surface::globe::{GlobeAir, GlobeGround, SplitPlace};
use crate::tiling::TilingScheme;

/// Declares the struct and the list of its members' names, which a test holds against the shader.
macro_rules! uniforms {
    ($(#[$meta:meta])* struct $name:ident { $($member:ident: $type:ty,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, ShaderType)]
        pub(crate) struct $name { $(pub $member: $type,)+ }

        #[cfg(test)]
        impl $name {
            pub(in crate::gpu) const MEMBER_NAMES: &[&str] = &[$(stringify!($member)),+];
        }
    };
}

uniforms! {
/// What the globe's shaders know of the eye: the `Globe` of `common/globe.wgsl`, where the members are explained.
struct GlobeUniforms {
    relative_from_ecef: Mat3,
    unit_from_relative: Mat3,
    unit_eye: Vec3,
    air_per_unit: f32,
    eye_coarse: IVec3,
    eye_height_m: f32,
    eye_fine: IVec3,
    texels_per_radian: f32,
    sky_per_m: Vec3,
    sin_latitude: f32,
    haze_per_m: Vec3,
    cos_latitude: f32,
    anchor_texel: IVec2,
    anchor_part: Vec2,
    anchor_from_axis_m: f32,
    anchor_radius_m: f32,
}
}

impl GlobeUniforms {
    /// Size in bytes on the GPU.
    pub const BYTES: u64 = Self::SHADER_SIZE.get();

    /// As seen from an eye in metres on the plate carrée and above the ellipsoid, with a texture of all longitudes
    /// and latitudes whose pages are a tiling's tiles.
    pub fn new(layout: &PageLayout, scheme: &TilingScheme, eye: DVec3, exaggeration: f64) -> Self {
        let within = GlobeGround::within(eye.truncate());
        let place = Geodetic::from_plate_carree(within.extend(eye.z));
        let split = SplitPlace::nearest(Wgs84::ecef_from_geodetic(&place));
        let air = GlobeAir::new(&place, exaggeration);
        let texel_m =
            scheme.tile_size_m(layout.coarsest_level) / f64::from(layout.tile_size_texels);
        let from_origin = dvec2(within.x - scheme.origin.x, scheme.origin.y - within.y) / texel_m;
        let texel = from_origin.floor();
        let (sin_latitude, cos_latitude) = place.latitude_rad.sin_cos();
        let radius_m = Wgs84::normal_radius_m(sin_latitude);
        Self {
            relative_from_ecef: place.ecef_from_local().transpose().as_mat3(),
            unit_from_relative: air.unit_from_relative.as_mat3(),
            unit_eye: air.unit_eye.as_vec3(),
            air_per_unit: air.air_per_unit as f32,
            eye_coarse: split.coarse,
            eye_height_m: eye.z as f32,
            eye_fine: split.fine,
            texels_per_radian: (Wgs84::EQUATOR_RADIUS_M / texel_m) as f32,
            sky_per_m: air.sky_per_m.as_vec3(),
            sin_latitude: sin_latitude as f32,
            haze_per_m: air.haze_per_m.as_vec3(),
            cos_latitude: cos_latitude as f32,
            anchor_texel: texel.as_ivec2(),
            anchor_part: (from_origin - texel).as_vec2(),
            anchor_from_axis_m: (radius_m * cos_latitude) as f32,
            anchor_radius_m: radius_m as f32,
        }
    }

    /// The bytes as the GPU reads them.
    pub fn to_bytes(self) -> Vec<u8> {
        let mut buffer = UniformBuffer::new(Vec::with_capacity(Self::BYTES as usize));
        #[expect(clippy::expect_used, reason = "a Vec grows as needed: writing cannot fail")]
        buffer.write(&self).expect("writing into a Vec");
        buffer.into_inner()
    }
}

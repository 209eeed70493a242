//! The shaders, put together from the pass's own file and the common parts it needs.

/// One shader: its name and its whole WGSL text.
pub struct Shader {
    /// The pass that runs it.
    pub name: &'static str,
    parts: &'static [&'static str],
    #[cfg(test)]
    part_names: &'static [&'static str],
}

macro_rules! shader {
    ($name:literal $(, $common:literal)*) => {
        Shader {
            name: $name,
            parts: &[
                $(include_str!(concat!("../../../shaders/common/", $common, ".wgsl")),)*
                include_str!(concat!("../../../shaders/", $name, ".wgsl")),
            ],
            #[cfg(test)]
            part_names: &[$($common),*],
        }
    };
}

/// Displacement of the mesh's vertices.
pub static DISPLACE: Shader = shader!("displace", "frame", "tile_lookup", "height_sample", "mesh");
/// Triangles within one tile told from those across a border.
pub static SORT_TRIANGLES: Shader = shader!("sort_triangles", "frame", "tile_lookup", "mesh");
/// The picture of the terrain.
pub static TERRAIN: Shader =
    shader!("terrain", "frame", "tile_lookup", "surface_sample", "colour_sample", "atmosphere");
/// The sky behind it.
pub static SKY: Shader = shader!("sky", "frame", "atmosphere");
/// Coordinates of the ground under each pixel.
pub static COORDINATES: Shader = shader!("coordinates", "frame", "tile_lookup", "surface_sample");
/// Decoding and halving of uploaded heights.
pub static DERIVE_HEIGHTS: Shader = shader!("derive_heights");
/// Halving of uploaded colours.
pub static DERIVE_COLOURS: Shader = shader!("derive_colours");
/// The lookup by itself, so that it can be compared with its twin on the CPU.
pub static LOOKUP_PROBE: Shader = shader!("lookup_probe", "frame", "tile_lookup", "height_sample");
/// Pictures of the renderer's own textures.
pub static DEBUG_IMAGE: Shader = shader!("debug_image");
/// Rays on a limit-triangulated surface.
pub static LIMIT_SURFACE: Shader = shader!("limit_surface");

/// Every shader of the library, for tests that look at all of them.
pub static ALL: [&Shader; 10] = [
    &DISPLACE,
    &SORT_TRIANGLES,
    &TERRAIN,
    &SKY,
    &COORDINATES,
    &DERIVE_HEIGHTS,
    &DERIVE_COLOURS,
    &LOOKUP_PROBE,
    &DEBUG_IMAGE,
    &LIMIT_SURFACE,
];

impl Shader {
    /// The whole text, common parts first.
    pub fn source(&self) -> String {
        self.parts.concat()
    }

    /// Names of the common parts.
    #[cfg(test)]
    pub fn part_names(&self) -> impl Iterator<Item = &'static str> {
        self.part_names.iter().copied()
    }

    /// Compiles the shader. A compile error reaches [`super::GpuContext::check`].
    pub fn module(&self, device: &wgpu::Device) -> wgpu::ShaderModule {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(self.name),
            source: wgpu::ShaderSource::Wgsl(self.source().into()),
        })
    }
}

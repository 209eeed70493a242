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
pub static DISPLACE: Shader =
    shader!("displace", "frame", "tile_lookup", "bilinear_height", "height_sample", "mesh");
/// Triangles within one tile told from those across a border.
pub static SORT_TRIANGLES: Shader = shader!("sort_triangles", "frame", "tile_lookup", "mesh");
/// The picture of the terrain.
pub static TERRAIN: Shader = shader!(
    "terrain",
    "frame",
    "tile_lookup",
    "surface_sample",
    "colour_sample",
    "atmosphere",
    "ground_light",
    "ground_slopes",
    "tile_ground"
);
/// The picture of terrain whose imagery comes through a page table.
pub static PAGE_TERRAIN: Shader = shader!(
    "page_terrain",
    "frame",
    "tile_lookup",
    "surface_sample",
    "page_table",
    "page_colour",
    "page_ground",
    "atmosphere",
    "ground_light",
    "ground_slopes",
    "page_debug"
);
/// Ground made of triangles with imagery through a page table.
pub static PAGE_TIN: Shader = shader!(
    "page_tin",
    "frame",
    "page_table",
    "page_colour",
    "page_request",
    "page_ground",
    "atmosphere",
    "ground_light",
    "page_debug"
);
/// What pages of a virtual texture each pixel asks for.
pub static PAGE_REQUESTS: Shader = shader!(
    "page_requests",
    "frame",
    "tile_lookup",
    "surface_sample",
    "page_table",
    "page_request",
    "page_ground"
);
/// Each page that pixels ask for once, on a list.
pub static GATHER_PAGES: Shader = shader!("gather_pages", "page_table", "page_marks");
/// What one pixel of every block asks for.
pub static SAMPLE_PAGES: Shader = shader!("sample_pages");
/// The ground's triangles, laid into the texture map.
pub static MAP_GROUND: Shader = shader!(
    "map_ground",
    "frame",
    "tile_lookup",
    "mesh",
    "page_table",
    "page_request",
    "page_marks",
    "page_ground",
    "texture_map",
    "map_triangles"
);
/// The triangles of models, laid into the map of their texture.
pub static MAP_OBJECTS: Shader = shader!(
    "map_objects",
    "frame",
    "page_table",
    "page_request",
    "page_marks",
    "object",
    "texture_map",
    "map_triangles"
);
/// The farthest depth of a mip's texels, for the next mip.
pub static HALVE_DEPTH: Shader = shader!("halve_depth");
/// The page table's functions by themselves, so that they can be compared with their twins on the CPU.
pub static PAGE_PROBE: Shader = shader!("page_probe", "page_table", "page_request", "page_colour");
/// The picture of models.
pub static OBJECTS: Shader = shader!(
    "objects",
    "frame",
    "page_table",
    "page_colour",
    "object",
    "atmosphere",
    "ground_light",
    "page_debug"
);
/// What pages of their virtual texture the pixels of models ask for.
pub static OBJECT_REQUESTS: Shader =
    shader!("object_requests", "frame", "page_table", "page_request", "object");
/// The picture of a mesh made on the CPU for the view.
pub static VIEW_MESH: Shader = shader!(
    "view_mesh",
    "frame",
    "tile_lookup",
    "surface_sample",
    "colour_sample",
    "atmosphere",
    "ground_light",
    "tile_ground",
    "view_mesh_vertex"
);
/// Coordinates of the ground of such a mesh under each pixel.
pub static VIEW_MESH_COORDINATES: Shader =
    shader!("view_mesh_coordinates", "frame", "view_mesh_vertex");
/// Changes of such a mesh, carried out.
pub static VIEW_MESH_UPDATE: Shader = shader!("view_mesh_update");
/// The picture of the globe.
pub static GLOBE: Shader = shader!(
    "globe",
    "frame",
    "globe",
    "page_table",
    "page_colour",
    "globe_place",
    "globe_air",
    "atmosphere",
    "ground_light",
    "page_debug"
);
/// What pages of its virtual texture each pixel of the globe asks for.
pub static GLOBE_REQUESTS: Shader =
    shader!("globe_requests", "frame", "globe", "page_table", "page_request", "globe_place");
/// Coordinates of the globe under each pixel.
pub static GLOBE_COORDINATES: Shader = shader!("globe_coordinates", "frame", "globe");
/// The sky round the globe.
pub static GLOBE_SKY: Shader = shader!("globe_sky", "frame", "globe", "globe_air");
/// Places on the globe by themselves, so that they can be compared with f64.
pub static GLOBE_PROBE: Shader =
    shader!("globe_probe", "frame", "globe", "page_table", "globe_place", "globe_air");
/// The sky behind it.
pub static SKY: Shader = shader!("sky", "frame", "atmosphere");
/// Coordinates of the ground under each pixel.
pub static COORDINATES: Shader = shader!("coordinates", "frame", "tile_lookup", "surface_sample");
/// Decoding and halving of uploaded heights.
pub static DERIVE_HEIGHTS: Shader = shader!("derive_heights", "stored_heights");
/// Halving of uploaded colours.
pub static DERIVE_COLOURS: Shader = shader!("derive_colours");
/// Heights sent to a clipmap, brought to where they wrap round to.
pub static CLIPMAP_HEIGHTS: Shader = shader!("clipmap_heights", "stored_heights");
/// The picture of a clipmap's ground.
pub static CLIPMAP: Shader = shader!(
    "clipmap",
    "frame",
    "clip_levels",
    "bilinear_height",
    "clip_heights",
    "clip_mesh",
    "clip_surface",
    "atmosphere",
    "ground_light"
);
/// Coordinates of a clipmap's ground under each pixel.
pub static CLIPMAP_COORDINATES: Shader = shader!(
    "clipmap_coordinates",
    "frame",
    "clip_levels",
    "bilinear_height",
    "clip_heights",
    "clip_mesh",
    "clip_surface"
);
/// Slots given to selected tiles.
pub static MANAGE_TILES: Shader =
    shader!("manage_tiles", "packed_tile", "tile_presence", "workgroup_scan");
/// The tables of the shown tiles.
pub static BUILD_TILE_TABLE: Shader = shader!("build_tile_table", "packed_tile", "workgroup_scan");
/// The tables' entries as seen from the eye.
pub static PLACE_TILES: Shader = shader!("place_tiles", "packed_tile");
/// The box round all ground in the coordinate image.
pub static REDUCE_REGION: Shader = shader!("reduce_region", "seen_ground", "coordinate_image");
/// The tiles that pixels of the coordinate image saw.
pub static MARK_SEEN_TILES: Shader =
    shader!("mark_seen_tiles", "whole_numbers", "selection", "seen_ground", "coordinate_image");
/// Selection's quadtree subdivision.
pub static SUBDIVIDE_TILES: Shader = shader!(
    "subdivide_tiles",
    "whole_numbers",
    "selection",
    "seen_ground",
    "tile_arena",
    "tile_presence",
    "workgroup_scan"
);
/// The order in which selection merges tiles.
pub static RANK_TILES: Shader = shader!("rank_tiles", "whole_numbers", "selection", "tile_arena");
/// Selection's regularisation and merging.
pub static MERGE_TILES: Shader =
    shader!("merge_tiles", "whole_numbers", "selection", "tile_arena", "workgroup_scan");
/// The selected tiles in order.
pub static LIST_TILES: Shader = shader!("list_tiles", "tile_arena");
/// The lookup by itself, so that it can be compared with its twin on the CPU.
pub static LOOKUP_PROBE: Shader =
    shader!("lookup_probe", "frame", "tile_lookup", "bilinear_height", "height_sample");
/// Pictures of the renderer's own textures.
pub static DEBUG_IMAGE: Shader = shader!("debug_image");
/// Rays on a limit-triangulated surface.
pub static LIMIT_SURFACE: Shader = shader!("limit_surface");
/// Places on Earth decoded from every encoding.
pub static PRECISION_ENCODINGS: Shader = shader!("precision_encodings", "frame", "tile_lookup");
/// Bits of a span's dot products, tried one by one.
pub static PRECISION_SPAN: Shader = shader!("precision_span", "real_f32");
/// A texture coordinate computed in the device's own floats.
pub static PRECISION_NATIVE: Shader = shader!("precision_native", "real_f32");
/// Operations that tricks for more precision rest on.
pub static PRECISION_FLOATS: Shader = shader!("precision_floats");
/// Squares one behind the other, for the depth test.
pub static PRECISION_DEPTH: Shader = shader!("precision_depth");

/// [`PRECISION_SPAN`] in f64, for devices that have it.
pub static PRECISION_SPAN_F64: Shader = shader!("precision_span", "real_f64");
/// [`PRECISION_NATIVE`] in f64, for devices that have it.
pub static PRECISION_NATIVE_F64: Shader = shader!("precision_native", "real_f64");
/// [`PRECISION_NATIVE`] in f16, for devices that have it.
pub static PRECISION_NATIVE_F16: Shader = shader!("precision_native", "real_f16");

/// Every shader of the library that needs no optional feature, for tests that look at all of them.
pub static ALL: [&Shader; 46] = [
    &DISPLACE,
    &SORT_TRIANGLES,
    &TERRAIN,
    &PAGE_TERRAIN,
    &PAGE_TIN,
    &PAGE_REQUESTS,
    &GATHER_PAGES,
    &MAP_GROUND,
    &MAP_OBJECTS,
    &HALVE_DEPTH,
    &SAMPLE_PAGES,
    &PAGE_PROBE,
    &OBJECTS,
    &OBJECT_REQUESTS,
    &VIEW_MESH,
    &VIEW_MESH_COORDINATES,
    &VIEW_MESH_UPDATE,
    &GLOBE,
    &GLOBE_REQUESTS,
    &GLOBE_COORDINATES,
    &GLOBE_SKY,
    &GLOBE_PROBE,
    &SKY,
    &COORDINATES,
    &DERIVE_HEIGHTS,
    &DERIVE_COLOURS,
    &CLIPMAP_HEIGHTS,
    &CLIPMAP,
    &CLIPMAP_COORDINATES,
    &MANAGE_TILES,
    &BUILD_TILE_TABLE,
    &PLACE_TILES,
    &REDUCE_REGION,
    &MARK_SEEN_TILES,
    &SUBDIVIDE_TILES,
    &RANK_TILES,
    &MERGE_TILES,
    &LIST_TILES,
    &LOOKUP_PROBE,
    &DEBUG_IMAGE,
    &LIMIT_SURFACE,
    &PRECISION_ENCODINGS,
    &PRECISION_SPAN,
    &PRECISION_NATIVE,
    &PRECISION_FLOATS,
    &PRECISION_DEPTH,
];

/// The shaders that compute in f64 or f16, for tests that look at all of them.
#[cfg(test)]
pub static WITH_OTHER_FLOATS: [&Shader; 3] =
    [&PRECISION_SPAN_F64, &PRECISION_NATIVE_F64, &PRECISION_NATIVE_F16];

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

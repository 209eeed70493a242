//! What a user can set about drawing.

use serde::{Deserialize, Serialize};

use crate::residency::page_table::{FaceCulling, PageFeedback};
use crate::selection::{SelectionConfig, Shortening, Strategy, Visibility};

/// What the picture shows instead of, or on top of, the terrain as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum DebugView {
    /// The terrain as it is.
    #[default]
    Off,
    /// The borders of the tiles each pixel is drawn from.
    TileBorders,
    /// The level of the tile each pixel is drawn from, as a colour, and the borders.
    Levels,
    /// The light on the slopes alone.
    Shading,
}

impl DebugView {
    /// The number the shader knows the view by.
    pub(crate) fn code(self) -> u32 {
        match self {
            Self::Off => 0,
            Self::TileBorders => 1,
            Self::Levels => 2,
            Self::Shading => 3,
        }
    }
}

/// How the edges of the ground against the sky, and against ground behind it, are smoothed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum AntiAliasing {
    /// Left to the adapter.
    #[default]
    ByAdapter,
    /// Not at all: each pixel is all of one surface.
    Off,
    /// Four samples of coverage and depth a pixel, one of colour: multisampling.
    FourSamples,
}

impl AntiAliasing {
    /// Samples a pixel.
    pub(crate) fn samples(self) -> u32 {
        match self {
            Self::ByAdapter | Self::Off => 1,
            Self::FourSamples => 4,
        }
    }
}

/// How shaders find the finest cached tile of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum LookupMethod {
    /// Descent of a quadtree over the cached tiles: a load a level.
    #[default]
    Descend,
    /// The paper's linear search through the table, finest level first.
    Linear,
}

/// What a user can set about drawing. All fields are public; [`Self::checked`] brings them in range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RendererSettings {
    /// How ground is brought to the GPU and drawn. Between strategies that only choose tiles, what is
    /// cached stays when it changes.
    pub strategy: Strategy,
    /// What counts as visible, for strategies that go by what the GPU saw.
    pub visibility: Visibility,
    /// How a page table learns what pixels need.
    pub page_feedback: PageFeedback,
    /// Where a texture map drops triangles that turn their backs on the eye.
    pub face_culling: FaceCulling,
    /// How too long a list is made short, for the same strategies.
    pub shortening: Shortening,
    /// Slots of the caches from west to east: the paper's m.
    pub cache_columns: u32,
    /// Slots of the caches from north to south: the paper's n.
    pub cache_rows: u32,
    /// Most tiles a selection may have, level 0 included: the paper's MaxofTiles.
    pub max_tiles: usize,
    /// A tile is split while its texels are drawn larger than this many pixels. Of a clipmap, the
    /// most that texels of a level are to measure where the level begins: a window has 4 / (`texel_px`
    /// times a pixel's angle in radians) texels a side.
    pub texel_px: f64,
    /// Size that the mesh's triangles are to have in pixels; 0 leaves it to the adapter. A mesh of more
    /// than about a million vertices is made coarser.
    pub triangle_px: f64,
    /// Factor on all heights, 0.01 to 1000.
    pub vertical_exaggeration: f64,
    /// Most bytes of tiles to bring to the GPU in a frame; one tile a layer always goes through.
    pub upload_budget_bytes: u64,
    /// Width and height of the coordinate pass in pixels.
    pub coordinate_size_px: [u32; 2],
    /// Frames that a coordinate image is held back before tiles are selected by it, for measuring what
    /// a late readback costs.
    pub readback_latency_frames: u32,
    /// Most taps of the anisotropic filter on imagery; 1 is isotropic, 0 leaves it to the adapter.
    pub anisotropy: u32,
    /// How edges are smoothed. A target whose format cannot be multisampled is drawn without.
    pub anti_aliasing: AntiAliasing,
    /// How much the sun's light on slopes shows: 0 not at all, 1 fully.
    pub shading_strength: f32,
    /// Keep the selection as it is whatever the camera does.
    pub freeze_selection: bool,
    /// What the picture shows.
    pub debug_view: DebugView,
    /// Draw the mesh's edges instead of its faces (needs a device with a line mode).
    pub wireframe: bool,
    /// How shaders find tiles.
    pub lookup: LookupMethod,
}

impl Default for RendererSettings {
    fn default() -> Self {
        Self {
            strategy: Strategy::RttQuadtree,
            visibility: Visibility::Box,
            page_feedback: PageFeedback::List,
            face_culling: FaceCulling::Compute,
            shortening: Shortening::Farthest,
            cache_columns: 6,
            cache_rows: 6,
            max_tiles: Self::most_tiles_of(6, 6),
            texel_px: 1.0,
            triangle_px: Self::BY_ADAPTER_PX,
            vertical_exaggeration: 1.0,
            upload_budget_bytes: 1 << 20,
            coordinate_size_px: [160, 90],
            readback_latency_frames: 0,
            anisotropy: Self::BY_ADAPTER_TAPS,
            anti_aliasing: AntiAliasing::ByAdapter,
            shading_strength: 0.7,
            freeze_selection: false,
            debug_view: DebugView::Off,
            wireframe: false,
            lookup: LookupMethod::Descend,
        }
    }
}

impl RendererSettings {
    /// The settings with what is left to the adapter filled in: fine triangles, much filtering and smooth
    /// edges on hardware, less on a program on the CPU, where all three are dear.
    pub fn for_adapter(mut self, is_software: bool) -> Self {
        let (triangle_px, anisotropy) = if is_software { (20.0, 1) } else { (8.0, 8) };
        if self.triangle_px == Self::BY_ADAPTER_PX {
            self.triangle_px = triangle_px;
        }
        if self.anisotropy == Self::BY_ADAPTER_TAPS {
            self.anisotropy = anisotropy;
        }
        if self.anti_aliasing == AntiAliasing::ByAdapter {
            let hardware = AntiAliasing::FourSamples;
            self.anti_aliasing = if is_software { AntiAliasing::Off } else { hardware };
        }
        self.checked()
    }

    /// What of the settings a selection goes by.
    pub(crate) fn selection_config(&self) -> SelectionConfig {
        SelectionConfig {
            max_tiles: self.max_tiles,
            texel_px: self.texel_px,
            vertical_exaggeration: self.vertical_exaggeration,
            shortening: self.shortening,
        }
    }

    /// The most tiles a selection should have for caches of so many slots: an eighth of them stays for
    /// what was wanted a moment ago. Without it every tile that comes and goes at the selection's far
    /// end is sent anew each time.
    pub const fn most_tiles_of(cache_columns: u32, cache_rows: u32) -> usize {
        let slots = (cache_columns as usize).saturating_mul(cache_rows as usize);
        slots - slots / 8
    }

    /// Most slots of a cache along either side: tables number tiles with 16 bits, and a texture has at
    /// most 16384 texels a side.
    pub const MOST_SLOTS_A_SIDE: u32 = 40;
    /// The value of `triangle_px` that leaves it to the adapter.
    pub const BY_ADAPTER_PX: f64 = 0.0;
    /// The value of `anisotropy` that leaves it to the adapter.
    pub const BY_ADAPTER_TAPS: u32 = 0;

    /// The settings with every value brought into its range.
    pub fn checked(mut self) -> Self {
        self.cache_columns = self.cache_columns.clamp(1, Self::MOST_SLOTS_A_SIDE);
        self.cache_rows = self.cache_rows.clamp(1, Self::MOST_SLOTS_A_SIDE);
        let slots = (self.cache_columns * self.cache_rows) as usize;
        self.max_tiles = self.max_tiles.clamp(1, slots);
        self.texel_px = finite(self.texel_px, 1.0).clamp(0.1, 64.0);
        if self.triangle_px != Self::BY_ADAPTER_PX {
            self.triangle_px = finite(self.triangle_px, 8.0).clamp(1.0, 64.0);
        }
        self.vertical_exaggeration = finite(self.vertical_exaggeration, 1.0).clamp(0.01, 1000.0);
        self.coordinate_size_px = self.coordinate_size_px.map(|size| size.clamp(8, 2048));
        self.anisotropy = self.anisotropy.min(16);
        self.shading_strength = self.shading_strength.clamp(0.0, 1.0);
        self
    }
}

fn finite(value: f64, otherwise: f64) -> f64 {
    if value.is_finite() { value } else { otherwise }
}

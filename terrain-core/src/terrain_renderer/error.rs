use crate::CameraError;
use crate::dataset::LoadError;
use crate::gpu::GpuError;
use crate::layer_loading::OpenTerrainError;

/// Why a frame could not be drawn, or a renderer not be made.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The GPU.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The view asked for is none.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A tile without which nothing can be drawn.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The cache's texture would be larger than the device can make one.
    #[error(
        "a cache of {columns} x {rows} tiles of {tile_texels} texels a side is more than the \
         adapter's textures hold ({most_texels} texels a side); choose a smaller cache"
    )]
    CacheTooLarge {
        /// Slots across.
        columns: u32,
        /// Slots down.
        rows: u32,
        /// Side of a slot of the layer with the larger tiles, gutter counted, in texels.
        tile_texels: u32,
        /// Longest side of a texture, in texels.
        most_texels: u32,
    },
    /// The adapter cannot draw a texture map.
    #[error(
        "--strategy texture-map needs fragments that write storage, which {0} does not have; choose another strategy, \
         or another adapter with --adapter"
    )]
    NoTextureMap(String),
    /// The system gives no threads for loading.
    #[error("cannot start the threads that load tiles: {0}")]
    Threads(#[from] std::io::Error),
    /// Models that cannot be drawn.
    #[error("{0}")]
    Models(String),
    /// The dataset has no level 0.
    #[error("the dataset holds no heights: its coarsest tile is missing; prepare it again")]
    NoHeights,
}

impl From<OpenTerrainError> for RenderError {
    fn from(error: OpenTerrainError) -> Self {
        match error {
            OpenTerrainError::Load(error) => Self::Load(error),
            OpenTerrainError::Threads(error) => Self::Threads(error),
        }
    }
}

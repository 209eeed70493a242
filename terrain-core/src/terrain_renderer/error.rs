use crate::CameraError;
use crate::dataset::LoadError;
use crate::gpu::GpuError;
use crate::resident_terrain::OpenTerrainError;

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
    /// The system gives no threads for loading.
    #[error("cannot start the threads that load tiles: {0}")]
    Threads(#[from] std::io::Error),
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

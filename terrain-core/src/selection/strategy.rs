use serde::{Deserialize, Serialize};

use super::cpu_frustum::CpuFrustum;
use super::rtt_quadtree::RttQuadtree;
use super::{SeenGround, Selection, SelectionConfig, TileTree};
use crate::CameraView;
use crate::by_name::by_name;

/// A way to choose the tiles a view is drawn with.
///
/// Cache, uploads, drawing and measurement are the same for all strategies, so that a comparison of
/// two compares nothing but how they choose.
pub trait SelectionStrategy: Sync {
    /// Whether the choice needs to know what ground the GPU saw. Where it does not, no coordinate
    /// pass is drawn and nothing is read back.
    fn needs_region(&self) -> bool;

    /// The tiles for the view; the same for the same arguments.
    ///
    /// * `seen`: the ground last seen, perhaps by a view some frames old; `None` for an empty view and
    ///   wherever [`Self::needs_region`] is false.
    /// * `view`: the camera of the frame to be drawn.
    ///
    /// Whatever the strategy, level 0 is on the selection, every other tile exists in a layer of the
    /// tree, none is on it twice, there are at most [`SelectionConfig::max_tiles`] (0 is taken as 1),
    /// and they are in order of [`Selection::tiles`].
    fn select(
        &self,
        tree: &TileTree,
        seen: Option<SeenGround<'_>>,
        view: &CameraView,
        config: &SelectionConfig,
    ) -> Selection;
}

/// The strategies there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// The tile-scheduling paper's own: the box of what the GPU saw, subdivided, regularised and
    /// merged; see [`select()`](super::select()).
    #[default]
    RttQuadtree,
    /// The paper's future work: the same choice made on the GPU, the cache's slots assigned there as
    /// well, so that only the list of missing tiles is read back.
    RttQuadtreeGpu,
    /// The traditional way: a quadtree against the view frustum by screen-space error; see
    /// [`select_by_frustum()`](super::select_by_frustum()).
    CpuFrustum,
    /// A triangulation made on the CPU for the view and sent as geometry; see
    /// [`ViewMesh`](crate::surface::view_mesh::ViewMesh). Imagery is chosen as by
    /// [`Self::CpuFrustum`].
    CpuMesh,
    /// Geometry clipmap for heights and clipmap for colours: windows round the eye instead of tiles.
    Clipmap,
    /// Imagery as one virtual texture behind a page table, its tiles those that the GPU finds pixels to
    /// need; heights in tiles of the same ground.
    PageTable,
    /// The same virtual texture, its tiles those that a texture map marks: the ground's triangles
    /// rasterised at their places in the texture, back faces dropped before.
    TextureMap,
}

/// There is no strategy of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no strategy {0:?}; there are {names}", names = Strategy::ALL.map(Strategy::name).join(", "))]
pub struct UnknownStrategy(pub String);

impl Strategy {
    /// Every strategy.
    pub const ALL: [Self; 7] = [
        Self::RttQuadtree,
        Self::RttQuadtreeGpu,
        Self::CpuFrustum,
        Self::CpuMesh,
        Self::Clipmap,
        Self::PageTable,
        Self::TextureMap,
    ];

    /// The name on the command line, in records and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::RttQuadtree => "rtt-quadtree",
            Self::RttQuadtreeGpu => "rtt-quadtree-gpu",
            Self::CpuFrustum => "cpu-frustum",
            Self::CpuMesh => "cpu-mesh",
            Self::Clipmap => "clipmap",
            Self::PageTable => "page-table",
            Self::TextureMap => "texture-map",
        }
    }

    /// How tiles are chosen, as far as they are on the CPU: of a strategy that chooses on the GPU the
    /// twin, which gives the same; `None` where there are no tiles to choose, or where pixels choose them.
    pub fn implementation(self) -> Option<&'static dyn SelectionStrategy> {
        match self {
            Self::RttQuadtree | Self::RttQuadtreeGpu => Some(&RttQuadtree),
            Self::CpuFrustum | Self::CpuMesh => Some(&CpuFrustum),
            Self::Clipmap | Self::PageTable | Self::TextureMap => None,
        }
    }
}

by_name!(Strategy, UnknownStrategy);

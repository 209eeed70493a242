use serde::{Deserialize, Serialize};

use crate::by_name::by_name;

/// Where triangles that turn their backs on the eye are dropped before a texture map is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaceCulling {
    /// In a compute pass, whose survivors an indirect draw rasterises.
    #[default]
    Compute,
    /// In the vertex stage, which gives them no area.
    Vertex,
    /// In the fragment stage, once a texel of the map: after rasterisation, for comparison.
    Fragment,
}

/// There is no face culling of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no face culling {0:?}; there are compute, vertex and fragment")]
pub struct UnknownFaceCulling(pub String);

impl FaceCulling {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Compute, Self::Vertex, Self::Fragment];

    /// The name on the command line and in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Compute => "compute",
            Self::Vertex => "vertex",
            Self::Fragment => "fragment",
        }
    }
}

by_name!(FaceCulling, UnknownFaceCulling);

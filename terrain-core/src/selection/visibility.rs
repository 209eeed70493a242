use serde::{Deserialize, Serialize};

use crate::by_name::by_name;

/// What of the ground counts as visible, for strategies that ask the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Visibility {
    /// All of the smallest box round what pixels saw, as the paper has it: what mountains hide within
    /// it is selected as well, and is there already when the camera moves.
    #[default]
    Box,
    /// What pixels saw, tile for tile: the cache holds nothing that is hidden.
    Exact,
}

/// There is no visibility of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no visibility {0:?}; there are box and exact")]
pub struct UnknownVisibility(pub String);

impl Visibility {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Box, Self::Exact];

    /// The name on the command line and in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Exact => "exact",
        }
    }
}

by_name!(Visibility, UnknownVisibility);

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

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

impl fmt::Display for Visibility {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Visibility {
    type Err = UnknownVisibility;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let found = Self::ALL.into_iter().find(|visibility| visibility.name() == name);
        found.ok_or_else(|| UnknownVisibility(name.to_owned()))
    }
}

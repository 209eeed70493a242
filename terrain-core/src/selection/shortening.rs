use serde::{Deserialize, Serialize};

use crate::by_name::by_name;

/// How the list of tiles is made short, steps 3 and 4 of the paper's selection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shortening {
    /// As the paper has it: a tile goes where all four of its children are on the list, and of too long a
    /// list the farthest tiles are merged.
    #[default]
    Farthest,
    /// A tile goes where all of its children that are in view are on the list, and of too long a list
    /// those tiles are merged whose parent shows the smallest error. What is left is every tile that
    /// shows, at one bound on the error for all.
    LeastError,
}

/// There is no shortening of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no way to shorten {0:?}; there are farthest and least-error")]
pub struct UnknownShortening(pub String);

impl Shortening {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Farthest, Self::LeastError];

    /// The name on the command line and in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Farthest => "farthest",
            Self::LeastError => "least-error",
        }
    }
}

by_name!(Shortening, UnknownShortening);

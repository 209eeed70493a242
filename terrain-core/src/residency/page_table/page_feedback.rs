use serde::{Deserialize, Serialize};

use crate::by_name::by_name;

/// How it is found out which pages of a virtual texture a frame's pixels need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PageFeedback {
    /// The paper's way: duplicates are removed on the GPU, and only the list of pages is read back.
    #[default]
    List,
    /// What every pixel needs is read back, and duplicates are removed on the CPU: the way the paper argues
    /// against.
    Full,
    /// What one pixel of every block of 8 x 8 needs is read back, another one each frame, as current engines
    /// do it: what a frame needs is known after 64 of them.
    Jittered,
}

/// There is no feedback of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no page feedback {0:?}; there are list, full and jittered")]
pub struct UnknownPageFeedback(pub String);

impl PageFeedback {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::List, Self::Full, Self::Jittered];

    /// The name on the command line and in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::List => "list",
            Self::Full => "full",
            Self::Jittered => "jittered",
        }
    }
}

by_name!(PageFeedback, UnknownPageFeedback);

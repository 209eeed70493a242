//! What is wrong between frames rather than in one: ground that swims, tiles that pop up, frames that
//! come late. `docs/measures.md` has the formulas.

mod drawn_surface;
mod jank;
mod popping;
mod swim;

pub use jank::{FRAME_BUDGET_MS, jank_sum_ms};
pub use popping::popping;
pub use swim::swim_px;

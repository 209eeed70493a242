use std::sync::Arc;

use terrain_core::gpu::{AdapterChoice, GpuContext};

#[expect(clippy::print_stderr, reason = "a skipped test is to be seen")]
/// A GPU without a window, or `None` (said on stderr) where there is none.
///
/// # Panics
/// Where there is none although `TERRAIN_REQUIRE_GPU=1` demands one: a skipped test is no test.
pub fn gpu() -> Option<Arc<GpuContext>> {
    match GpuContext::headless(&AdapterChoice::Best) {
        Ok(gpu) => Some(Arc::new(gpu)),
        Err(error) => {
            let required = std::env::var("TERRAIN_REQUIRE_GPU").is_ok_and(|value| value == "1");
            assert!(!required, "TERRAIN_REQUIRE_GPU=1, but: {error}");
            eprintln!("SKIPPED, no GPU: {error}");
            None
        }
    }
}

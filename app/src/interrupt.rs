//! Stopping at Ctrl-C.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

/// A flag that Ctrl-C raises instead of ending the program, for work that leaves nothing half done.
///
/// # Errors
/// Where Ctrl-C cannot be caught, for instance because it is already.
pub fn flag_on_ctrl_c() -> anyhow::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    ctrlc::set_handler(move || raised.store(true, Ordering::Relaxed))
        .context("cannot catch Ctrl-C")?;
    Ok(flag)
}

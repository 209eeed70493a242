//! The `terrain` command as its users see it: what it prints, what it writes, how it ends.

#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a test fails by panicking")]
#![expect(clippy::print_stderr, reason = "a skipped test is to be seen")]

mod compare;
#[cfg(unix)]
mod documents;
mod drawing;
mod flights;
mod globe;
mod harness;
mod models;
mod precision;
#[cfg(unix)]
mod preparing;
mod tin;
mod usage;
mod window;

//! The `terrain` command as its users see it: what it prints, what it writes, how it ends.

mod drawing;
mod harness;
mod usage;
mod window;

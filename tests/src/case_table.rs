use std::sync::Arc;

use terrain_core::gpu::GpuContext;
use terrain_core::selection::Strategy;

use crate::gpu;

/// What holds for every strategy that is not excepted, with the reason.
pub struct Case {
    /// Panics where it does not hold for the strategy.
    pub holds: fn(&Arc<GpuContext>, Strategy),
    /// Whom it does not apply to, and why.
    pub exceptions: &'static [(Strategy, &'static str)],
}

impl Case {
    #[expect(clippy::print_stdout, reason = "a failed case is to say which strategy failed it")]
    /// Tries the case on each strategy there is, each on a device of its own.
    ///
    /// # Panics
    /// Where the case does not hold.
    pub fn check(&self) {
        for strategy in Strategy::ALL {
            match self.exceptions.iter().find(|(excepted, _)| *excepted == strategy) {
                Some((_, reason)) => println!("{strategy}: not so, since {reason}"),
                None => {
                    let Some(gpu) = gpu() else { return };
                    println!("{strategy}");
                    (self.holds)(&gpu, strategy);
                }
            }
        }
    }
}

/// A table of [`Case`]s, each a test: its room and name, and whom it does not apply to.
///
/// ```text
/// cases! {
///     room::what_holds_for_all {}
///     room::what_holds_for_others { Clipmap: "it has no tiles" }
/// }
/// ```
#[macro_export]
macro_rules! cases {
    ($($room:ident::$name:ident { $($strategy:ident: $reason:literal),* $(,)? })*) => {
        $(
            #[test]
            fn $name() {
                let exceptions = &[$((::terrain_core::selection::Strategy::$strategy, $reason)),*];
                $crate::Case { holds: $room::$name, exceptions }.check();
            }
        )*
    };
}

//! The contract of the renderer's encoding of places, on the CPU's twin of the shaders and on the GPU.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::convert::Infallible;

use terrain_core::precision::encodings::{
    Contract, Encoding, EncodingErrors, SweepAxes, Verdict, decode_on_cpu, measure_encodings,
    verdicts,
};

fn on_cpu(axes: &SweepAxes) -> EncodingErrors {
    let decode = |_: &_, points: &[_]| Ok::<_, Infallible>(decode_on_cpu(points));
    measure_encodings(axes, decode).unwrap()
}

fn verdict(errors: &EncodingErrors, encoding: Encoding) -> Verdict {
    verdicts(errors, &Contract::SHIPPED).into_iter().find(|v| v.encoding == encoding).unwrap()
}

#[test]
fn the_shipped_encoding_keeps_the_contract_anywhere_on_earth() {
    let errors = on_cpu(&SweepAxes::quick());
    for encoding in Encoding::ALL {
        println!("{:?}", verdict(&errors, encoding));
    }
    let shipped = verdict(&errors, Encoding::Shipped);
    assert_eq!(shipped.holds, [true; 3], "{shipped:?}");
}

/// The contract is one that can be broken: the naive encodings break it, each where theory says.
#[test]
fn the_contract_tells_encodings_apart() {
    let errors = on_cpu(&SweepAxes::quick());
    assert!(!verdict(&errors, Encoding::AbsoluteFloat).holds[0]);
    assert!(!verdict(&errors, Encoding::AbsoluteFloat).holds[2]);
    assert!(!verdict(&errors, Encoding::FixedPoint).holds[0], "a unit is 4 cm on the Earth");
    assert!(!verdict(&errors, Encoding::FixedPoint).holds[2], "and several texels of level 24");
}

//! Flights to repeat, and what is counted while they are flown.

mod camera_spec;
mod demo_flights;
mod flight;
mod flight_recorder;
mod frame_record;
mod ledger;
mod monotone_curve;
pub mod report;

pub use camera_spec::{CameraHeight, CameraSpec, CameraSpecError};
pub use flight::{Flight, FlightError, Keyframe};
pub use flight_recorder::FlightRecorder;
pub use frame_record::FrameRecord;
pub use ledger::{ByteCause, ByteTotals, FrameLedger};

#[cfg(test)]
mod tests;

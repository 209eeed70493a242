//! Flights to repeat, what is counted while they are flown, and how far their pictures are from the
//! exact ones.

mod camera_spec;
pub mod equal_error;
pub mod error;
mod flight;
mod flight_recorder;
mod frame_record;
mod ledger;
mod monotone_curve;
pub mod motion;
mod planned_flights;
pub mod report;
pub mod rest;
pub mod sweep;

pub use camera_spec::{CameraHeight, CameraSpec, CameraSpecError};
pub use flight::{Flight, FlightError, Keyframe};
pub use flight_recorder::FlightRecorder;
pub use frame_record::FrameRecord;
pub use ledger::{ByteCause, ByteTotals, FrameLedger};
pub use planned_flights::{FlightGround, PlannedFlight, UnknownFlight};

#[cfg(test)]
mod tests;

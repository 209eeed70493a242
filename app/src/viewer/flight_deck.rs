//! Recording a flight and playing one.

use terrain_core::CameraView;
use terrain_core::dataset::Shape;
use terrain_core::measure::{Flight, FlightError, FlightRecorder};

/// Frames a second that recorded flights ask for.
const RECORDED_FPS: f64 = 60.0;

/// The flight at hand, and whether it is being played or another one recorded.
pub struct FlightDeck {
    /// What recorded flights are in, and over.
    place: (String, Shape),
    flight: Option<Flight>,
    /// Seconds since the flight began to play.
    playing_s: Option<f64>,
    recording: Option<Recording>,
}

#[derive(Default)]
struct Recording {
    recorder: FlightRecorder,
    elapsed_s: f64,
}

impl FlightDeck {
    /// A deck for flights in this CRS over a dataset of this shape, with a flight to play where there is one.
    pub fn new(place: (String, Shape), flight: Option<Flight>) -> Self {
        Self { place, flight, playing_s: None, recording: None }
    }

    /// Whether there is a flight to play.
    pub fn has_flight(&self) -> bool {
        self.flight.is_some()
    }

    /// Whether a flight is being played.
    pub fn is_playing(&self) -> bool {
        self.playing_s.is_some()
    }

    /// Whether a flight is being recorded.
    pub fn is_recording(&self) -> bool {
        self.recording.is_some()
    }

    /// Plays the flight from its beginning; returns whether there is one.
    pub fn play(&mut self) -> bool {
        self.playing_s = self.flight.is_some().then_some(0.0);
        self.is_playing()
    }

    /// Stops to play.
    pub fn stop(&mut self) {
        self.playing_s = None;
    }

    /// Begins to record; a flight that plays goes on.
    pub fn record(&mut self) {
        self.recording = Some(Recording::default());
    }

    /// Ends the recording, which becomes the flight at hand. `None` where nothing was recorded.
    ///
    /// # Errors
    /// Where what was recorded makes no flight.
    pub fn finish_recording(&mut self) -> Result<Option<&Flight>, FlightError> {
        let Some(recording) = self.recording.take() else { return Ok(None) };
        if recording.recorder.is_empty() {
            return Ok(None);
        }
        self.flight = Some(recording.recorder.finish(self.place.clone(), RECORDED_FPS)?);
        self.stop();
        Ok(self.flight.as_ref())
    }

    /// Lets `dt_s` seconds pass; returns where the played flight puts the camera. At its end the
    /// flight stops by itself.
    pub fn advance(&mut self, dt_s: f64, viewport_px: [u32; 2]) -> Option<CameraView> {
        let (flight, playing_s) = (self.flight.as_ref()?, self.playing_s.as_mut()?);
        *playing_s += dt_s;
        let elapsed_s = *playing_s;
        if elapsed_s >= flight.duration_s() {
            self.playing_s = None;
        }
        let [start_s, _] = flight.time_range_s();
        Some(flight.view_at(start_s + elapsed_s, viewport_px))
    }

    /// Takes the view of a frame into the recording, `dt_s` seconds after the one before it.
    pub fn take_view(&mut self, dt_s: f64, view: &CameraView) {
        if let Some(recording) = &mut self.recording {
            recording.elapsed_s += dt_s;
            recording.recorder.record(recording.elapsed_s, view);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    fn view(x: f64) -> CameraView {
        CameraView {
            eye: dvec3(x, 0.0, 500.0),
            heading_deg: 10.0,
            pitch_deg: -20.0,
            fov_y_deg: 60.0,
            viewport_px: [640, 480],
        }
    }

    #[test]
    fn what_was_recorded_can_be_played() {
        let mut deck = FlightDeck::new(("EPSG:32632".to_owned(), Shape::Plane), None);
        assert!(!deck.play(), "there is no flight yet");
        deck.record();
        for step in 0..=40 {
            deck.take_view(0.1, &view(f64::from(step) * 10.0));
        }
        let flight = deck.finish_recording().unwrap().unwrap();
        assert_eq!(flight.crs(), "EPSG:32632");
        assert!((flight.duration_s() - 4.0).abs() < 1e-9);
        assert!(deck.play());
        let half = deck.advance(2.0, [640, 480]).unwrap();
        assert!((half.eye.x - 200.0).abs() < 5.0, "{}", half.eye.x);
        let end = deck.advance(5.0, [640, 480]).unwrap();
        assert_eq!(end.eye.x, 400.0);
        assert!(!deck.is_playing() && deck.advance(0.1, [640, 480]).is_none());
    }

    #[test]
    fn ending_without_a_frame_leaves_the_old_flight() {
        let mut deck = FlightDeck::new(("EPSG:32632".to_owned(), Shape::Plane), None);
        deck.record();
        assert!(deck.finish_recording().unwrap().is_none());
        assert!(!deck.is_recording() && !deck.has_flight());
    }
}

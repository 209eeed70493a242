//! The window, on a virtual display where the X server for it is installed.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::harness::{assert_fails_naming, dataset, has_gpu, terrain};

/// Two seconds over Asia.
const SHORT_FLIGHT: &str = r#"{"crs": "EPSG:3395", "fps": 30, "keyframes": [
    {"t": 0, "x": 5e6, "y": 4e6, "height": 9e5, "heading": 90, "pitch": -30, "fov": 50},
    {"t": 2, "x": 6e6, "y": 4e6, "height": 9e5, "heading": 90, "pitch": -30, "fov": 50}]}"#;

/// How long to wait for what takes a second or two on an idle machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// A virtual display that goes away with its last user.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// A new display, or `None` (loudly) where there is no server for it.
    fn start() -> Option<Self> {
        let spawned = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "800x600x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let Ok(mut server) = spawned else {
            eprintln!("SKIPPED, no Xvfb");
            return None;
        };
        let mut number = String::new();
        let pipe = server.stdout.take().unwrap();
        BufReader::new(pipe).read_line(&mut number).unwrap();
        Some(Self { server, name: format!(":{}", number.trim()) })
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Waits for a process to end by itself; `false` where it had to be killed.
fn ends_by_itself(child: &mut Child) -> bool {
    let started = Instant::now();
    while started.elapsed() < PATIENCE {
        if child.try_wait().unwrap().is_some() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let _ = child.kill();
    let _ = child.wait();
    false
}

#[test]
fn without_a_display_there_is_one_clear_line() {
    let output = terrain(["fly"]).arg(dataset()).output().unwrap();
    assert_fails_naming(&output, &["DISPLAY", "--headless"]);
}

#[test]
fn a_display_that_is_not_there_is_an_error_and_no_crash() {
    let output = terrain(["fly"]).arg(dataset()).env("DISPLAY", ":59999").output().unwrap();
    assert_fails_naming(&output, &["window"]);
}

#[test]
fn two_strategies_share_a_window() {
    if !has_gpu() {
        return;
    }
    let Some(display) = Display::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let flight = folder.path().join("short.json");
    std::fs::write(&flight, SHORT_FLIGHT).unwrap();
    let mut command = terrain(["fly", "--compare", "cpu-frustum", "--close-at-end", "--flight"]);
    command.arg(&flight).arg(dataset()).env("DISPLAY", &display.name);
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    assert!(ends_by_itself(&mut child), "the window closes by itself");
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_window_flies_a_flight_and_saves_its_recording() {
    if !has_gpu() {
        return;
    }
    let Some(display) = Display::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (flight, recording) = (folder.path().join("short.json"), folder.path().join("flown.json"));
    std::fs::write(&flight, SHORT_FLIGHT).unwrap();
    let mut command = terrain(["fly", "--close-at-end", "--flight"]);
    command.arg(&flight).arg("--record").arg(&recording);
    command.arg(dataset()).env("DISPLAY", &display.name);
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    assert!(ends_by_itself(&mut child), "the window closes by itself");
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let flown: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&recording).unwrap()).unwrap();
    assert_eq!(flown["crs"], "EPSG:3395");
    let keyframes = flown["keyframes"].as_array().unwrap();
    let x = |keyframe: Option<&serde_json::Value>| keyframe.unwrap()["x"].as_f64().unwrap();
    assert!(x(keyframes.first()) < 5.7e6, "{:?}", keyframes.first());
    assert!((x(keyframes.last()) - 6.0e6).abs() < 1.0, "{:?}", keyframes.last());
}

//! Running the command, and a small dataset for it to work on.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use tempfile::TempDir;

/// The repository's root folder.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The command with these arguments, without a display.
pub fn terrain<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrain"));
    command.args(arguments).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    // Mesa complains on stderr where this is not set.
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
    }
    command
}

/// Runs the command and waits for it.
pub fn run<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Output {
    terrain(arguments).output().expect("the command can be started")
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// What was said on stderr, without the lines of graphics drivers.
pub fn stderr(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr);
    let ours = |line: &&str| !line.contains("XDG_RUNTIME_DIR") && !line.starts_with("MESA");
    text.lines().filter(ours).map(|line| format!("{line}\n")).collect()
}

/// Asserts success, showing what was said otherwise.
#[track_caller]
pub fn assert_success(output: &Output) {
    assert!(output.status.success(), "{:?}: {}", output.status.code(), stderr(output));
}

/// Asserts that the command failed with exit code 1 and one line that begins as errors do and names
/// all of this.
#[track_caller]
pub fn assert_fails_naming(output: &Output, words: &[&str]) {
    let said = stderr(output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(said.starts_with("terrain: "), "{said}");
    for word in words {
        assert!(said.contains(word), "{said} does not name {word}");
    }
}

/// Whether there is a GPU to draw with. Without one a test is skipped, loudly, or fails where
/// `TERRAIN_REQUIRE_GPU` is set to 1.
pub fn has_gpu() -> bool {
    static ANSWER: OnceLock<bool> = OnceLock::new();
    let found = *ANSWER.get_or_init(|| run(["doctor"]).status.success());
    if !found {
        let required = std::env::var("TERRAIN_REQUIRE_GPU").is_ok_and(|value| value == "1");
        assert!(!required, "TERRAIN_REQUIRE_GPU is set, and there is no GPU");
        eprintln!("SKIPPED, no GPU");
    }
    found
}

/// A dataset made of the demo's heights alone, once for all tests.
pub fn dataset() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    static DATASET: OnceLock<PathBuf> = OnceLock::new();
    DATASET.get_or_init(|| {
        let folder = FOLDER.get_or_init(|| TempDir::new().expect("a temporary folder"));
        let path = folder.path().join("demo");
        let dem = root().join("data/demo/dem.tif");
        let arguments = ["prepare".as_ref(), "--dem".as_ref(), dem.as_os_str(), "--crs".as_ref()];
        let output = terrain(arguments).arg("EPSG:3395").arg("--out").arg(&path).output();
        assert_success(&output.expect("the command can be started"));
        path
    })
}

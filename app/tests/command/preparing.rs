//! `terrain prepare` interrupted, killed, and on a disk that is too small.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use tempfile::TempDir;

use crate::harness::{assert_fails_naming, assert_success, run, stdout, terrain};

/// Rough heights of 400 x 400 cells and a picture of `picture_side` squared pixels of the same
/// ground.
fn sources(picture_side: u32) -> TempDir {
    const SIDE: u32 = 400;
    let folder = TempDir::new().unwrap();
    let noise = |x: u32, y: u32| (x ^ y << 11).wrapping_mul(2_654_435_761) >> 20;
    let height = |x, y| image::Luma([noise(x, y) as u16]);
    let heights = image::ImageBuffer::<_, Vec<u16>>::from_fn(SIDE, SIDE, height);
    heights.save(folder.path().join("dem.png")).unwrap();
    let colour = |x, y| image::Rgb([noise(x, y) as u8, x as u8, y as u8]);
    let picture = image::RgbImage::from_fn(picture_side, picture_side, colour);
    picture.save(folder.path().join("dom.png")).unwrap();
    for (name, side) in [("dem.pgw", SIDE), ("dom.pgw", picture_side)] {
        let cell_m = 12_000.0 / f64::from(side);
        let [x, y] = [432_000.0 + 0.5 * cell_m, 6_850_000.0 - 0.5 * cell_m];
        let text = format!("{cell_m}\n0\n0\n-{cell_m}\n{x}\n{y}\n");
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// The arguments that prepare the sources to `out`.
fn arguments(sources: &Path, out: &Path) -> Vec<OsString> {
    let [dem, dom] = ["dem.png", "dom.png"].map(|name| sources.join(name).into_os_string());
    let words = ["prepare", "--crs", "EPSG:32632", "--dem"].map(OsString::from);
    let rest = [dem, "--dom".into(), dom, "--out".into(), out.as_os_str().to_owned()];
    words.into_iter().chain(rest).collect()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

/// Every file of a dataset.
fn contents(dataset: &Path) -> BTreeMap<String, Vec<u8>> {
    names(dataset)
        .into_iter()
        .map(|n| (n.clone(), std::fs::read(dataset.join(n)).unwrap()))
        .collect()
}

/// Starts the command and waits until something fulfils the condition.
fn start_until(command: &mut Command, is_reached: impl Fn() -> bool) -> Child {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    while !is_reached() {
        assert!(child.try_wait().unwrap().is_none(), "it ended too early");
        std::thread::sleep(Duration::from_millis(1));
    }
    child
}

#[test]
fn an_interrupt_leaves_nothing() {
    let sources = sources(2000);
    let folder = TempDir::new().unwrap();
    let mut command = terrain(arguments(sources.path(), &folder.path().join("dataset")));
    let child = start_until(&mut command, || !names(folder.path()).is_empty());
    let sent = Command::new("kill").arg("-INT").arg(child.id().to_string()).status().unwrap();
    assert!(sent.success());
    assert_fails_naming(&child.wait_with_output().unwrap(), &["stopped"]);
    assert!(names(folder.path()).is_empty(), "{:?}", names(folder.path()));
}

#[test]
fn a_killed_preparation_is_gone_on_with() {
    let sources = sources(2000);
    let folder = TempDir::new().unwrap();
    let [resumed, whole] = ["resumed", "whole"].map(|name| folder.path().join(name));
    let with_resume = || {
        let mut command = terrain(arguments(sources.path(), &resumed));
        command.arg("--resume");
        command
    };
    let finished = folder.path().join(".resumed.resume/heights.finished");
    let mut child = start_until(&mut with_resume(), || finished.exists());
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(finished.exists() && !resumed.exists());
    let heights = finished.with_extension("pmtiles");
    let written_at = heights.metadata().unwrap().modified().unwrap();

    assert_success(&with_resume().output().unwrap());
    let kept_at = resumed.join("heights.pmtiles").metadata().unwrap().modified().unwrap();
    assert_eq!(written_at, kept_at, "the heights were written again");
    assert_success(&run(arguments(sources.path(), &whole)));
    assert!(contents(&resumed) == contents(&whole));
    let mut left = names(folder.path());
    left.sort();
    assert_eq!(left, ["resumed", "whole"]);
}

/// Runs the preparation where no file may be longer than some half kilobytes.
fn run_with_file_limit(half_kilobytes: u64, arguments: &[OsString]) -> Output {
    // Ignoring the signal makes the write itself fail, as it does on a full disk.
    let script = format!("trap '' XFSZ; ulimit -f {half_kilobytes}; exec \"$@\"");
    let program = terrain::<OsString>([]).get_program().to_owned();
    Command::new("sh").args(["-c", &script, "sh"]).arg(program).args(arguments).output().unwrap()
}

#[test]
fn a_write_that_fails_is_named_and_leaves_nothing() {
    let sources = sources(600);
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("dataset");
    let arguments = arguments(sources.path(), &out);
    assert_success(&run(&arguments));
    let size = |name: &str| std::fs::metadata(out.join(name)).unwrap().len() / 512;
    let (heights, colours) = (size("heights.pmtiles"), size("colours.pmtiles"));
    assert!(heights < colours, "the limits below meet both archives");
    std::fs::remove_dir_all(&out).unwrap();
    for limit in [0, 1, 40, heights / 2, heights, heights + 40, colours / 2, colours] {
        let output = run_with_file_limit(limit, &arguments);
        let file = if limit <= heights { "heights.pmtiles" } else { "colours.pmtiles" };
        assert_fails_naming(&output, &[file, "too large"]);
        assert!(names(folder.path()).is_empty(), "{limit}: {:?}", names(folder.path()));
    }
    assert_success(&run_with_file_limit(colours + 1, &arguments));
}

#[test]
fn a_full_disk_is_named_and_left_empty() {
    let mount = ["-rm", "sh", "-c", "mount -t tmpfs none /tmp"];
    let may_mount = Command::new("unshare").args(mount).output();
    if !may_mount.is_ok_and(|output| output.status.success()) {
        eprintln!("SKIPPED, no file system can be mounted here (unshare -rm)");
        return;
    }
    let sources = sources(600);
    let disk = TempDir::new().unwrap();
    let arguments = arguments(sources.path(), &disk.path().join("dataset"));
    let script = "mount -t tmpfs -o size=$1 none \"$0\" || exit 9; \
                  shift; \"$@\"; code=$?; ls -A \"$0\"; exit $code";
    let program = terrain::<OsString>([]).get_program().to_owned();
    for (size, file) in [("100k", "heights.pmtiles"), ("200k", "colours.pmtiles")] {
        let mut command = Command::new("unshare");
        command.args(["-rm", "sh", "-c", script]).arg(disk.path()).arg(size);
        let output = command.arg(&program).args(&arguments).output().unwrap();
        assert_fails_naming(&output, &[file, "No space left"]);
        assert_eq!(stdout(&output), "", "left on the disk");
    }
}

//! The commands that README.md and data/README.md show in `sh` blocks do what they are shown for.
//!
//! A line with `terrain` is run here, beside the repository's data and stand-ins for the files a reader
//! would bring; a line with `make` is one that the continuous checks run as it stands.

use std::path::Path;

use tempfile::TempDir;

use crate::harness::{assert_success, root, run, stdout, terrain};

/// The lines of the `sh` blocks of a document, without their remarks.
fn shown_commands(document: &str) -> Vec<String> {
    let text = std::fs::read_to_string(root().join(document)).unwrap();
    let blocks = text.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next());
    let lines = blocks.flat_map(str::lines).map(|line| line.split('#').next().unwrap_or_default());
    lines.map(|line| line.trim().to_owned()).filter(|line| !line.is_empty()).collect()
}

/// Heights of one SRTM tile of 3 seconds, sloping.
fn write_hgt(path: &Path) {
    const SIDE: u32 = 1201;
    let height_m = |index: u32| (400 + index / SIDE + index % SIDE) as i16;
    let samples: Vec<u8> = (0..SIDE * SIDE).flat_map(|i| height_m(i).to_be_bytes()).collect();
    std::fs::write(path, samples).unwrap();
}

/// A folder with the repository's data and what the commands expect of a reader.
fn readers_folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    let data = root().join("data").canonicalize().unwrap();
    std::os::unix::fs::symlink(&data, folder.path().join("data")).unwrap();
    for name in ["N46E007.hgt", "N46E008.hgt"] {
        write_hgt(&folder.path().join(name));
    }
    // A picture with a place, of the ground that the heights lie on.
    std::os::unix::fs::symlink(data.join("demo/dom.tif"), folder.path().join("sentinel2.tif"))
        .unwrap();
    folder
}

#[test]
fn shown_commands_run() {
    let folder = readers_folder();
    let checks = std::fs::read_to_string(root().join(".ci/run")).unwrap();
    let mut datasets = 0;
    for document in ["README.md", "data/README.md"] {
        for line in shown_commands(document) {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("make") => {
                    assert!(checks.contains(&line), "{document}: {line} is not checked")
                }
                Some("terrain") => {
                    let words: Vec<_> = words.collect();
                    let output = terrain(&words).current_dir(folder.path()).output().unwrap();
                    assert_success(&output);
                    let out = words.iter().skip_while(|word| **word != "--out").nth(1);
                    if let (Some(&"prepare"), Some(out)) = (words.first(), out) {
                        let dataset = folder.path().join(out);
                        let info = run(["info".as_ref(), dataset.as_os_str(), "--verify".as_ref()]);
                        assert_success(&info);
                        assert!(stdout(&info).contains("all checksums match"), "{line}");
                        datasets += 1;
                    }
                }
                _ => panic!("{document}: {line} is neither run here nor by the checks"),
            }
        }
    }
    assert!(datasets >= 2, "the demo's dataset and a finer area");
}

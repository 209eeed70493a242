//! Help, exit codes and errors.

use crate::harness::{assert_fails_naming, assert_success, run, stderr, stdout, terrain};

const COMMANDS: [&str; 8] =
    ["prepare", "synth", "info", "fly", "render", "precision", "limit", "doctor"];

#[test]
fn every_command_has_help_with_an_example() {
    let list = stdout(&run(["--help"]));
    for command in COMMANDS {
        assert!(list.contains(command), "{list}");
        let output = run([command, "--help"]);
        assert_success(&output);
        assert!(stdout(&output).contains(&format!("  terrain {command}")), "{}", stdout(&output));
    }
}

#[test]
fn wrong_usage_exits_with_2() {
    for arguments in [
        vec!["nonsense"],
        vec!["render"],
        vec!["fly", "x", "--csv", "f.csv"],
        vec!["render", "x", "--camera", "x=1"],
        vec!["render", "x", "--camera", "x=1,y=2,height=3", "--size", "0x5"],
    ] {
        let output = run(&arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
        assert!(stdout(&output).is_empty());
    }
}

#[test]
fn what_is_not_a_dataset_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nothing here");
    let name = path.to_string_lossy().into_owned();
    assert_fails_naming(&run(["info", &name]), &[&name]);
    assert_fails_naming(&run(["fly", &name]), &[&name, "terrain prepare"]);
    let render = run(["render", &name, "--camera", "x=1,y=2,height=3", "--out", "x.png"]);
    assert_fails_naming(&render, &[&name, "terrain prepare"]);
}

#[test]
fn a_raster_that_is_none_is_named_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let dem = folder.path().join("words.tif");
    std::fs::write(&dem, "these are words").unwrap();
    let out = folder.path().join("dataset");
    let output = terrain(["prepare", "--dem"]).arg(&dem).arg("--out").arg(&out).output().unwrap();
    assert_fails_naming(&output, &["words.tif"]);
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().flatten().collect();
    assert_eq!(left.len(), 1, "{left:?}");
}

#[test]
fn the_doctor_tells_data_and_fails_without_an_adapter() {
    let output = run(["doctor", "--json"]);
    let findings: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(findings["adapters"].is_array() && findings["display"].is_null());
    let left_out = findings["left_out"].to_string();
    assert!(left_out.contains("DISPLAY"), "{left_out}");
    let output = run(["doctor", "--adapter", "no such adapter"]);
    assert_fails_naming(&output, &["no such adapter"]);
    assert!(stdout(&output).contains("left out"), "the page is printed all the same");
}

//! Help, exit codes and errors.

use crate::harness::{assert_fails_naming, assert_success, dataset, run, stderr, stdout, terrain};

/// The commands that the help of this one lists.
fn commands_of(command: &[&str]) -> Vec<String> {
    let help = stdout(&run([command, &["--help"]].concat()));
    let after_title = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let list = after_title.take_while(|line| !line.is_empty());
    // A name stands two spaces in; what goes on from the line above it stands further in.
    let names = list.filter_map(|line| line.strip_prefix("  ").filter(|l| !l.starts_with(' ')));
    let names = names.filter_map(|line| line.split_whitespace().next());
    names.filter(|name| *name != "help").map(str::to_owned).collect()
}

#[test]
fn every_command_has_help_with_an_example() {
    let commands = commands_of(&[]);
    assert!(commands.len() >= 9 && commands.iter().any(|name| name == "compare"), "{commands:?}");
    let limits = commands_of(&["limit"]);
    assert_eq!(limits, ["prepare", "study"]);
    let limits = limits.iter().map(|task| vec!["limit", task.as_str()]);
    for command in commands.iter().map(|name| vec![name.as_str()]).chain(limits) {
        let output = run([command.as_slice(), &["--help"]].concat());
        assert_success(&output);
        let example = format!("  terrain {}", command.join(" "));
        assert!(stdout(&output).contains(&example), "{}", stdout(&output));
    }
}

#[test]
fn wrong_usage_exits_with_2() {
    for arguments in [
        vec!["nonsense"],
        vec!["render"],
        vec!["fly", "x", "--headless", "--compare", "cpu-frustum"],
        vec!["fly", "x", "--csv", "f.csv"],
        vec!["render", "x", "--camera", "x=1"],
        vec!["render", "x", "--camera", "x=1,y=2,height=3", "--size", "0x5", "--json"],
        vec!["limit", "prepare", "x", "--exaggeration", "nan"],
        vec!["limit", "prepare", "x", "--exaggeration", "-1"],
        vec!["limit", "prepare", "x", "--colour-error", "nan"],
        vec!["limit", "prepare", "x", "--memory-mb", "nan"],
        vec!["limit", "prepare", "x", "--area", "1,2,x,3,4"],
        vec!["prepare", "--dem", "x", "--out", "y", "--dom-extent", "1,2,x,3,4"],
    ] {
        let output = run(&arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
        assert!(stdout(&output).is_empty());
    }
}

#[test]
fn a_number_out_of_range_is_answered_with_the_range() {
    for (option, value, range) in [
        ("--exaggeration", "0", "0.01 to 1000"),
        ("--exaggeration", "nan", "0.01 to 1000"),
        ("--exaggeration", "-2", "0.01 to 1000"),
        ("--texel-px", "0", "0.1 to 64"),
        ("--max-tiles", "0", "from 1"),
        ("--max-tiles", "-1", "from 1"),
    ] {
        let output = run(["fly", "x", "--headless", option, value]);
        assert_eq!(output.status.code(), Some(2), "{option} {value}: {}", stderr(&output));
        assert!(stderr(&output).contains(range), "{option} {value}: {}", stderr(&output));
    }
}

#[test]
fn a_picture_is_drawn_for_something() {
    let output = run(["render", "x", "--camera", "x=1,y=2,height=3"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    for way in ["--out", "--coordinates", "--json"] {
        assert!(stderr(&output).contains(way), "{}", stderr(&output));
    }
}

#[test]
fn a_manifest_cut_short_is_named_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("manifest.json"), "{\"version\": ").unwrap();
    let output = run(["info".as_ref(), folder.path().as_os_str()]);
    assert_fails_naming(&output, &["manifest.json", "damaged", "prepare the dataset anew"]);
}

#[test]
fn a_cause_is_told_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.json");
    std::fs::write(&path, "{}").unwrap();
    let mut command = terrain(["fly"]);
    command.arg(dataset()).args(["--headless", "--flight"]).arg(&path);
    let output = command.output().unwrap();
    assert_fails_naming(&output, &["flight.json: not a flight: missing field"]);
    assert_eq!(stderr(&output).matches("missing field").count(), 1, "{}", stderr(&output));
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

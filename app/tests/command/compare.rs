//! Comparisons: their files, and that they can be repeated.

use std::path::Path;

use crate::harness::{
    assert_fails_naming, assert_success, dataset, has_gpu, root, run, stderr, stdout, terrain,
};

fn compare(out: &Path, more: &[&str]) -> std::process::Output {
    let mut command = terrain(["compare"]);
    command.arg(dataset()).arg("--flight").arg(root().join("data/demo/flight.json"));
    command.args(["--exaggeration", "15", "--size", "96x54", "--frames-at", "5", "--settle"]);
    command.args(["--error-every", "2"]).args(more).arg("--out").arg(out).output().unwrap()
}

/// The table's rows as (column, value), times left out.
fn rows_without_times(folder: &Path) -> Vec<Vec<(String, String)>> {
    let text = std::fs::read_to_string(folder.join("frames.csv")).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned));
    let header: Vec<String> = lines.next().unwrap().collect();
    let is_time = |name: &str| name.ends_with("_ms");
    let row = |line: Vec<String>| {
        assert_eq!(line.len(), header.len());
        header.iter().cloned().zip(line).filter(|(name, _)| !is_time(name)).collect()
    };
    lines.map(|line| row(line.collect())).collect()
}

#[test]
fn a_sweep_leaves_a_table_a_summary_a_report_and_pictures_and_can_be_repeated() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    for out in [&first, &second] {
        assert_success(&compare(out, &["--sweep", "texel-px=1,8"]));
    }
    let rows = rows_without_times(&first);
    assert_eq!(rows, rows_without_times(&second), "two runs give the same bytes, tiles and errors");
    assert_eq!(rows.len(), 10, "a row a frame and run");
    let value = |row: usize, column: &str| {
        let found = rows[row].iter().find(|(name, _)| name == column);
        found.unwrap_or_else(|| panic!("no column {column}")).1.clone()
    };
    for column in ["flip_mean", "psnr_db", "height_rmse_m", "screen_error_px_p99"] {
        for row in [0, 2, 4, 5, 7, 9] {
            let error: f64 = value(row, column).parse().unwrap();
            assert!(error.is_finite() && error >= 0.0, "{column} of row {row}: {error}");
        }
        assert_eq!(value(1, column), "", "only every second frame is measured");
    }
    assert_eq!(
        (value(0, "run"), value(5, "run")),
        ("\"texel-px=1\"".into(), "\"texel-px=8\"".into())
    );

    let summary = summary(&first);
    let of_run =
        |run: usize, error: &str| summary["runs"][run]["mean_errors"][error].as_f64().unwrap();
    assert!(
        of_run(0, "height_rmse_m") < of_run(1, "height_rmse_m"),
        "coarser tiles, larger errors"
    );
    let upload = |run: usize| summary["runs"][run]["bytes_a_frame"]["upload"].as_f64().unwrap();
    assert!(upload(0) > upload(1));
    assert!(!summary["pareto_fronts"][0]["runs"].as_array().unwrap().is_empty());

    let report = std::fs::read_to_string(first.join("report.html")).unwrap();
    assert!(report.contains("<svg") && report.contains("Pareto front"));
    for outside in ["src=\"http", "href=", "<script", "@import"] {
        assert!(!report.contains(outside), "the report is self-contained: {outside}");
    }
    let size = image::image_dimensions(first.join("texel-px=8-worst-1.png")).unwrap();
    assert_eq!(size, (3 * 96 + 16, 54));
    let left = std::fs::read_dir(&first).unwrap().map(|entry| entry.unwrap().path());
    assert!(left.into_iter().all(|path| path.extension().is_some_and(|kind| kind != "part")));
}

#[test]
fn strategies_fly_the_same_course() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let output = compare(folder.path(), &["--strategies", "rtt-quadtree,cpu-frustum"]);
    assert_success(&output);
    assert_eq!(stdout(&output).lines().count(), 2, "a line a strategy");
    let rows = rows_without_times(folder.path());
    let strategies = rows.iter().map(|row| row[0].1.as_str()).collect::<Vec<_>>();
    assert_eq!(strategies, [["rtt-quadtree"; 5], ["cpu-frustum"; 5]].concat());
    let frame = |row: usize| &rows[row][1..3];
    assert!((0..5).all(|row| frame(row) == frame(row + 5)), "the same frames");
}

/// A comparison over flights made for the dataset.
fn compare_flights(out: &Path, more: &[&str]) {
    let mut command = terrain(["compare"]);
    command.arg(dataset()).args(["--flights", "hover,teleport", "--strategies", "all", "--settle"]);
    command.args(["--exaggeration", "15", "--size", "96x54", "--frames-at", "4"]).args(more);
    assert_success(&command.args(["--error-every", "3"]).arg("--out").arg(out).output().unwrap());
}

fn summary(folder: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join("summary.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn strategies_are_compared_at_equal_error_and_the_same_way_again() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    let equal = ["--equal-error", "--sweep", "texel-px=1,2,8", "--only-measured", "--warm"];
    for out in [&first, &second] {
        compare_flights(out, &equal);
    }
    assert_eq!(rows_without_times(&first), rows_without_times(&second));

    let summary = summary(&first);
    let runs = summary["runs"].as_array().unwrap();
    let comparisons = summary["comparisons"].as_array().unwrap();
    assert_eq!(comparisons.len(), 3, "as given, at equal FLIP, at equal screen-space error");
    let flights = comparisons[1]["flights"].as_array().unwrap();
    assert_eq!(
        (&flights[0]["flight"], &flights[1]["flight"]),
        (&"hover".into(), &"teleport".into())
    );
    for flight in flights {
        let of = |strategy: &serde_json::Value| {
            let runs = runs.iter().filter(|run| run["flight"] == flight["flight"]);
            let errors = runs.filter(|run| run["strategy"] == *strategy);
            let errors = errors.map(|run| run["mean_errors"]["flip_mean"].as_f64().unwrap());
            errors.fold(f64::INFINITY, f64::min)
        };
        let strategies = comparisons[1]["strategies"].as_array().unwrap();
        let tightest = strategies.iter().map(of).fold(0.0, f64::max);
        let error = flight["error"].as_f64().unwrap();
        assert!((error / (1.02 * tightest) - 1.0).abs() < 1e-9, "{error} for {tightest}");
        for costs in flight["costs"].as_array().unwrap() {
            assert_ne!(costs["upload_kib"], "not_reached", "all reach it");
        }
    }
    for run in runs.iter().filter(|run| run["flight"] == "hover") {
        assert_eq!(run["churn_at_rest"], 0);
        let warm = |cause: &str| run["warm_bytes_a_frame"][cause].as_f64().unwrap();
        assert_eq!((warm("upload"), warm("disk")), (0.0, 0.0), "the second time all is there");
        assert!(run["bytes_a_frame"]["upload"].as_f64().unwrap() > 0.0);
    }
    let report = std::fs::read_to_string(first.join("report.html")).unwrap();
    for part in ["712.45", "At equal FLIP", "At equal screen-space error", "Film strips", "warm"] {
        assert!(report.contains(part), "{part}");
    }
}

#[test]
fn frames_without_pictures_move_the_same_tiles_and_bytes() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let [all, few] = ["all", "few"].map(|name| folder.path().join(name));
    compare_flights(&all, &[]);
    compare_flights(&few, &["--only-measured"]);
    let moved = |folder: &Path| {
        let rows = rows_without_times(folder).into_iter();
        let is_moved = |name: &str| name.contains("tiles") || name.contains("bytes");
        rows.map(|row| row.into_iter().filter(|(name, _)| is_moved(name)).collect::<Vec<_>>())
            .collect::<Vec<_>>()
    };
    assert_eq!(moved(&all), moved(&few));
}

#[test]
fn what_cannot_be_swept_is_refused_in_words() {
    let output = run(["compare", "data", "--out", "x", "--sweep", "colour=1"]);
    assert_eq!(output.status.code(), Some(2), "wrong usage");
    assert!(stderr(&output).contains("no knob colour"), "{}", stderr(&output));
    let output = compare(Path::new("x"), &["--sweep", "dataset=nowhere"]);
    assert_fails_naming(&output, &["nowhere"]);
}

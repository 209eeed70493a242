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

    let summary = std::fs::read_to_string(first.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
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

#[test]
fn what_cannot_be_swept_is_refused_in_words() {
    let output = run(["compare", "data", "--out", "x", "--sweep", "colour=1"]);
    assert_eq!(output.status.code(), Some(2), "wrong usage");
    assert!(stderr(&output).contains("no knob colour"), "{}", stderr(&output));
    let output = compare(Path::new("x"), &["--sweep", "dataset=nowhere"]);
    assert_fails_naming(&output, &["nowhere"]);
}

//! The study of precision: what it writes and what it says.

use crate::harness::{assert_fails_naming, assert_success, run, stdout};

#[test]
fn the_study_writes_a_page_tables_and_plots() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("precision");
    let output = run(["precision", "--quick", "--out", &out.to_string_lossy()]);
    assert_success(&output);
    let shipped =
        stdout(&output).lines().find(|line| line.starts_with("shipped")).map(str::to_owned);
    assert!(shipped.is_some_and(|line| line.contains("contract kept")), "{}", stdout(&output));
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("<svg") && !page.contains("src=\"http"), "the page holds all it shows");
    let summary = std::fs::read(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
    assert_eq!(summary["cpu_verdicts"].as_array().map(Vec::len), Some(6));
    for file in
        ["span-bits.csv", "encoding-places.csv", "depth.csv", "depth.svg", "span-bits-11.svg"]
    {
        assert!(std::fs::metadata(out.join(file)).unwrap().len() > 500, "{file}");
    }
}

#[test]
fn a_folder_that_cannot_be_made_and_an_adapter_that_is_not_there_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a file");
    std::fs::write(&file, "in the way").unwrap();
    let name = file.to_string_lossy();
    assert_fails_naming(&run(["precision", "--quick", "--out", &name]), &["a file"]);
    let output = run(["precision", "--quick", "--out", &name, "--adapter", "no such adapter"]);
    assert_fails_naming(&output, &["no such adapter"]);
}

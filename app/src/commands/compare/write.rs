use std::path::Path;

use terrain_core::measure::FrameRecord;

use super::course::RunResult;
use super::page::Page;
use crate::output;

/// Writes everything a comparison leaves: each file appears whole or not at all.
///
/// # Errors
/// Where a file cannot be written; the error names it.
pub fn write_all(folder: &Path, page: &Page) -> anyhow::Result<()> {
    output::write_whole(&folder.join("frames.csv"), frames_csv(&page.runs).as_bytes())?;
    output::write_whole(&folder.join("summary.json"), page.json()?.as_bytes())?;
    for run in &page.runs {
        for (rank, frame) in run.worst.iter().enumerate() {
            let name = format!("{}-worst-{}.png", file_name(&run.name), rank + 1);
            output::write_whole(&folder.join(name), &frame.png()?)?;
        }
    }
    output::write_whole(&folder.join("report.html"), page.html()?.as_bytes())
}

/// A row a frame of each run; the last column tells the run.
fn frames_csv(runs: &[RunResult]) -> String {
    let mut table = FrameRecord::csv_header() + ",run\n";
    for run in runs {
        for record in &run.records {
            table.push_str(&record.csv_row());
            table.push_str(&format!(",\"{}\"\n", run.name.replace('"', "\"\"")));
        }
    }
    table
}

/// The name with what a file's name may not have everywhere replaced.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || ".=_-".contains(c) { c } else { '-' }).collect()
}

#[cfg(test)]
mod tests {
    use terrain_core::selection::Strategy;

    use super::*;

    #[test]
    fn every_row_has_the_headers_columns() {
        let records = vec![FrameRecord::default(); 2];
        let run = RunResult {
            name: "a \"b\"".into(),
            strategy: Strategy::default(),
            records,
            worst: Vec::new(),
        };
        let table = frames_csv(&[run]);
        let lines = table.lines().collect::<Vec<_>>();
        assert_eq!(lines.len(), 3);
        assert!(lines[0].ends_with(",run") && lines[2].ends_with(",\"a \"\"b\"\"\""));
        assert_eq!(lines[0].split(',').count(), lines[1].split(',').count());
    }

    #[test]
    fn a_run_of_any_name_has_a_file() {
        assert_eq!(file_name("rtt-quadtree cache=6x6/ä:b"), "rtt-quadtree-cache=6x6-ä-b");
    }
}

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
    let has_flights = page.runs.iter().any(|run| run.flight != page.runs[0].flight);
    for run in &page.runs {
        let flight = if has_flights { format!("{}-", run.flight) } else { String::new() };
        for (rank, frame) in run.worst.iter().enumerate() {
            let name = file_name(&format!("{flight}{}-worst-{}.png", run.name, rank + 1));
            output::write_whole(&folder.join(name), &frame.png()?)?;
        }
    }
    output::write_whole(&folder.join("report.html"), page.html()?.as_bytes())
}

/// A row a frame of each run; the last columns tell the flight, whether memory was empty when it began,
/// and the run.
fn frames_csv(runs: &[RunResult]) -> String {
    let mut table = FrameRecord::csv_header() + ",flight,caches,run\n";
    for run in runs {
        for (caches, records) in [("cold", &run.records), ("warm", &run.warm_records)] {
            for record in records {
                let (flight, name) = (quoted(&run.flight), quoted(&run.name));
                table.push_str(&format!("{},{flight},{caches},{name}\n", record.csv_row()));
            }
        }
    }
    table
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// The name with what a file's name may not have everywhere replaced.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || ".=_-".contains(c) { c } else { '-' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_the_headers_columns() {
        let mut run = RunResult::of_records("a \"b\"", vec![FrameRecord::default(); 2]);
        run.warm_records = vec![FrameRecord::default()];
        let table = frames_csv(&[run]);
        let lines = table.lines().collect::<Vec<_>>();
        assert_eq!(lines.len(), 4);
        assert!(lines[0].ends_with(",run") && lines[2].ends_with(",\"a \"\"b\"\"\""));
        assert!(lines[1].contains(",cold,") && lines[3].contains(",warm,"));
        assert_eq!(lines[0].split(',').count(), lines[1].split(',').count());
    }

    #[test]
    fn a_run_of_any_name_has_a_file() {
        assert_eq!(file_name("rtt-quadtree cache=6x6/ä:b"), "rtt-quadtree-cache=6x6-ä-b");
    }
}

//! What the commands give: results on stdout, one line for an error, files that are whole.

use std::io::{ErrorKind, Write};
use std::path::Path;

use anyhow::Context;

/// The error with its causes on one line.
pub fn one_line(error: &anyhow::Error) -> String {
    format!("{error:#}").replace('\n', " ")
}

/// Prints a result. A reader that has gone away (`| head`) is no failure.
pub fn print(text: &str) -> anyhow::Result<()> {
    let mut stdout = std::io::stdout().lock();
    let written = stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush());
    match written {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other?),
    }
}

/// Tells the user how things go, on stderr.
pub fn say(text: &str) {
    // Where stderr is closed nobody reads, and the work goes on.
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Writes a file that appears whole or not at all.
///
/// # Errors
/// Where it cannot be written; the error names it.
pub fn write_whole(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    let written = std::fs::write(&beside, bytes).and_then(|()| std::fs::rename(&beside, path));
    written.with_context(|| format!("{}: cannot write the file", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_and_its_causes_make_one_line() {
        let error = anyhow::anyhow!("not a GeoTIFF\nat all").context("dem.tif");
        assert_eq!(one_line(&error), "dem.tif: not a GeoTIFF at all");
    }
}

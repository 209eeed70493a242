//! Points as lines of text: x, y and height, apart by commas, semicolons or blanks.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use super::super::SourceError;
use super::{PointCloud, name_of};

/// Reads all points. Empty lines and those that begin with `#` or `//` are passed over. Where the first
/// line names its columns they may stand in any order, with others among them; else the first three are
/// x, y and height. Between semicolons a comma is a decimal one.
pub fn read(path: &Path) -> Result<PointCloud, SourceError> {
    let failed = |error: std::io::Error| SourceError::io(path, &error);
    let mut reader = BufReader::new(File::open(path).map_err(failed)?);
    let mut points = Vec::new();
    let mut layout: Option<Layout> = None;
    let mut bytes = Vec::new();
    for number in 1_u64.. {
        bytes.clear();
        if reader.read_until(b'\n', &mut bytes).map_err(failed)? == 0 {
            break;
        }
        let line = String::from_utf8_lossy(&bytes);
        // Some editors begin a file with a mark of byte order.
        let line = line.trim_start_matches('\u{feff}').trim();
        if line.is_empty() || line.starts_with('#') || line.starts_with("//") {
            continue;
        }
        let at_line =
            |reason: String| SourceError::damaged(path, format!("line {number}: {reason}"));
        let layout = match &layout {
            Some(layout) => layout,
            None => {
                let (found, is_header) = Layout::of_first_line(line).map_err(at_line)?;
                let found = layout.insert(found);
                if is_header {
                    continue;
                }
                found
            }
        };
        points.push(layout.point(line).map_err(at_line)?);
    }
    if points.is_empty() {
        return Err(SourceError::no_points(path, "holds no points"));
    }
    let note = format!("{}: all {} points", name_of(path), points.len());
    Ok(PointCloud { path: path.to_owned(), points, epsg: None, note, is_own_choice: false })
}

/// How lines are cut, and which part is what.
struct Layout {
    separator: Separator,
    columns: [usize; 3],
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Separator {
    Semicolon,
    Comma,
    Blank,
}

/// What columns are called, of x, y and height.
const NAMES: [&[&str]; 3] = [
    &["x", "easting", "east", "e", "longitude", "lon", "long"],
    &["y", "northing", "north", "n", "latitude", "lat"],
    &["z", "height", "elevation", "elev", "altitude", "alt", "h"],
];

impl Layout {
    /// The layout, and whether the line names columns.
    fn of_first_line(line: &str) -> Result<(Self, bool), String> {
        let separator = match () {
            () if line.contains(';') => Separator::Semicolon,
            () if line.contains(',') => Separator::Comma,
            () => Separator::Blank,
        };
        let fields = separator.fields(line);
        let first = fields.first().map_or("", |field| field.trim());
        if number_of(first, separator).is_ok() {
            return Ok((Self { separator, columns: [0, 1, 2] }, false));
        }
        let names: Vec<String> = fields
            .iter()
            .map(|field| field.trim().trim_matches('"').to_ascii_lowercase())
            .collect();
        let mut columns = [0; 3];
        for (column, known) in columns.iter_mut().zip(NAMES) {
            *column = names
                .iter()
                .position(|name| known.contains(&name.as_str()))
                .ok_or_else(|| format!("no column is called {}", known.join(" or ")))?;
        }
        Ok((Self { separator, columns }, true))
    }

    fn point(&self, line: &str) -> Result<[f64; 3], String> {
        let fields = self.separator.fields(line);
        let mut point = [0.0; 3];
        for (value, column) in point.iter_mut().zip(self.columns) {
            let field = fields.get(column).map(|field| field.trim());
            let field = field.ok_or_else(|| {
                format!("{} values where x, y and height are needed", fields.len())
            })?;
            *value = number_of(field, self.separator)?;
        }
        Ok(point)
    }
}

impl Separator {
    fn fields(self, line: &str) -> Vec<&str> {
        match self {
            Self::Semicolon => line.split(';').collect(),
            Self::Comma => line.split(',').collect(),
            Self::Blank => line.split_whitespace().collect(),
        }
    }
}

fn number_of(field: &str, separator: Separator) -> Result<f64, String> {
    let number = match separator {
        Separator::Semicolon => field.replace(',', ".").parse::<f64>(),
        _ => field.parse(),
    };
    match number {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(format!("{field} is no coordinate; leave out points without one")),
        Err(_) => Err(format!("{field:?} is not a number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points_of(text: &str) -> Result<Vec<[f64; 3]>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        std::fs::write(&path, text).unwrap();
        read(&path).map(|cloud| cloud.points).map_err(|error| error.to_string())
    }

    #[test]
    fn many_ways_to_write_the_same_points() {
        let expected = Ok(vec![[1.5, 2.0, -3.25], [4.0, 5.0, 6.0]]);
        for text in [
            "1.5 2 -3.25\n4 5 6\n",
            "\u{feff}# made by hand\r\n1.5\t2\t-3.25\r\n\r\n4  5\t6",
            "1.5,2,-3.25,17,255\n4, 5, 6, 0",
            "X,Y,Z\n1.5,2,-3.25\n4,5,6\n",
            "id;Height;Easting;Northing\na;-3,25;1,5;2,0\nb;6;4;5\n",
            "\"lat\" \"lon\" \"elev\"\n// south first\n2 1.5 -3.25\n5 4 6",
        ] {
            assert_eq!(points_of(text), expected, "{text:?}");
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (text, cause) in [
            ("", "holds no points"),
            ("# nothing\n\n", "holds no points"),
            ("x,y,z\n", "holds no points"),
            ("1 2 3\n1 2\n", "line 2: 2 values where"),
            ("1 2 3\n\n1 b 3\n", "line 3: \"b\" is not a number"),
            ("1 2 nan\n", "line 1: nan is no coordinate"),
            ("1,2,inf\n", "line 1: inf is no coordinate"),
            ("id,x,z\n1,2,3\n", "line 1: no column is called y"),
        ] {
            let error = points_of(text).unwrap_err();
            assert!(error.contains(cause) && error.contains("points.csv"), "{error}");
        }
    }
}

use std::path::{Path, PathBuf};

use glam::dvec2;

use super::{RasterGrid, SourceError};

/// The grid in the world file beside a picture; `None` where there is no such file.
///
/// A world file holds six numbers, a line each: cell width, two rotations, minus cell height, and
/// the x and y of the *centre* of the north-western cell.
pub fn grid_beside(picture: &Path) -> Result<Option<RasterGrid>, SourceError> {
    let Some(path) = candidates(picture).into_iter().find(|path| path.is_file()) else {
        return Ok(None);
    };
    let text = std::fs::read_to_string(&path).map_err(|error| SourceError::io(&path, &error))?;
    let bad = |reason: String| SourceError::bad_georeference(&path, reason);
    let numbers: Vec<f64> = text
        .split_whitespace()
        .map(|word| word.parse().map_err(|_| bad(format!("{word:?} is not a number"))))
        .collect::<Result<_, _>>()?;
    let [width, skew_a, skew_b, down, x, y] = numbers[..] else {
        return Err(bad(format!("{} numbers where six are needed", numbers.len())));
    };
    if skew_a != 0.0 || skew_b != 0.0 || down >= 0.0 {
        return Err(bad(
            "the picture is rotated or flipped; `gdalwarp` can make it north-up".into()
        ));
    }
    let cell = dvec2(width, -down);
    Ok(Some(RasterGrid { origin: dvec2(x - 0.5 * cell.x, y + 0.5 * cell.y), cell }))
}

/// `a.jpg` may have `a.jgw`, `a.jpgw` or `a.wld`.
fn candidates(picture: &Path) -> Vec<PathBuf> {
    let extension = picture.extension().unwrap_or_default().to_string_lossy().into_owned();
    let ends: Vec<char> = extension.chars().collect();
    let short: String = [ends.first(), ends.last()].into_iter().flatten().collect();
    [format!("{short}w"), format!("{extension}w"), "wld".to_owned()]
        .iter()
        .map(|extension| picture.with_extension(extension))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_position_is_that_of_the_first_cells_centre() {
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("map.jpg");
        assert_eq!(grid_beside(&picture), Ok(None));
        std::fs::write(folder.path().join("map.jgw"), "10\n0\n0\n-20\n1005\n1990\n").unwrap();
        let expected = RasterGrid { origin: dvec2(1000.0, 2000.0), cell: dvec2(10.0, 20.0) };
        assert_eq!(grid_beside(&picture), Ok(Some(expected)));
        for text in ["10 0 0 -20 5", "10 1 0 -20 5 5", "10 0 0 20 5 5", "a b c d e f"] {
            std::fs::write(folder.path().join("map.jgw"), text).unwrap();
            assert!(grid_beside(&picture).is_err(), "{text}");
        }
    }
}

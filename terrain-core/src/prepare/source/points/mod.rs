//! Scattered points as they come: LAS and LAZ, and lines of text.

mod las_file;
mod las_sizes;
#[cfg(test)]
mod las_tests;
mod point_raster;
mod text_file;
mod wkt;

use std::path::{Path, PathBuf};

pub use point_raster::PointRaster;

use super::SourceError;

/// The points of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct PointCloud {
    /// The file.
    pub path: PathBuf,
    /// x, y in the units of the CRS and height, as the file has it: in metres, like all heights.
    /// Finite, at least one.
    pub points: Vec<[f64; 3]>,
    /// The EPSG code of x and y; `None` where the file does not say.
    pub epsg: Option<u32>,
    /// Which of the file's points these are.
    pub note: String,
    /// Whether the file had classes and none was asked for.
    pub is_own_choice: bool,
}

/// The class of ground in LAS files.
pub const GROUND_CLASS: u8 = 2;

const TEXT_EXTENSIONS: [&str; 3] = ["csv", "xyz", "txt"];
const LAS_EXTENSIONS: [&str; 2] = ["las", "laz"];

/// Whether a file is one of points, told by its name's ending.
pub fn is_point_file(path: &Path) -> bool {
    has_extension(path, &LAS_EXTENSIONS) || has_extension(path, &TEXT_EXTENSIONS)
}

/// Reads a file's points.
///
/// `classes` chooses by LAS classification; where it is empty, ground alone if any point is said to
/// be ground, else all. Points marked as withheld are left out. Lines of text have no classes.
///
/// # Errors
/// Where the file cannot be read, is damaged, or holds no point of these classes.
pub fn read_points(path: &Path, classes: &[u8]) -> Result<PointCloud, SourceError> {
    match has_extension(path, &LAS_EXTENSIONS) {
        true => las_file::read(path, classes),
        false => text_file::read(path),
    }
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let own = path.extension().unwrap_or_default();
    extensions.iter().any(|extension| own.eq_ignore_ascii_case(extension))
}

/// The name of a file, without its folder.
fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

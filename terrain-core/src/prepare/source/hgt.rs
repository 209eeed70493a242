use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use glam::dvec2;

use super::{RasterContent, RasterGrid, RasterInfo, RasterSource, SourceError, Window};
use crate::geodesy::CoordinateSystem;

/// The height that stands for "no data".
const VOID: i16 = -32768;

/// An SRTM tile of one degree: big-endian 16-bit heights, north row first, nothing else in the file.
///
/// Its size follows from its length (1201 or 3601 samples a side), its place from its name
/// (`N46W122.hgt`: the south-west corner). Samples stand for points: the outer ones lie *on* the
/// degree lines and are shared with the neighbouring tiles.
pub struct HgtSource {
    path: PathBuf,
    info: RasterInfo,
}

impl HgtSource {
    /// Opens the file; its name and length must fit.
    pub fn open(path: &Path) -> Result<Self, SourceError> {
        let bytes = std::fs::metadata(path).map_err(|error| SourceError::io(path, &error))?.len();
        let side = match bytes {
            25_934_402 => 3601,
            2_884_802 => 1201,
            _ => {
                let reason = format!("{bytes} bytes, not the 2884802 or 25934402 of an SRTM tile");
                return Err(SourceError::damaged(path, reason));
            }
        };
        let corner = place_of_name(path).ok_or_else(|| {
            SourceError::bad_georeference(path, "the name says no place, such as N46W122.hgt")
        })?;
        let cell_deg = 1.0 / f64::from(side - 1);
        let origin = dvec2(corner.0 - 0.5 * cell_deg, corner.1 + 1.0 + 0.5 * cell_deg);
        let info = RasterInfo {
            grid: Some(RasterGrid { origin, cell: dvec2(cell_deg, cell_deg) }),
            size: [side, side],
            epsg: Some(CoordinateSystem::WGS84),
            content: RasterContent::Measurements,
            height_step_m: 1.0,
            notes: Vec::new(),
        };
        Ok(Self { path: path.to_owned(), info })
    }
}

impl RasterSource for HgtSource {
    fn path(&self) -> &Path {
        &self.path
    }

    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn read_heights(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let failed = |error: std::io::Error| SourceError::io(&self.path, &error);
        let mut file = File::open(&self.path).map_err(failed)?;
        let mut out = Vec::with_capacity(window.len());
        let mut bytes = vec![0; 2 * window.width as usize];
        for row in window.row..window.row + window.height {
            let sample = u64::from(row) * u64::from(self.info.size[0]) + u64::from(window.column);
            file.seek(SeekFrom::Start(2 * sample)).map_err(failed)?;
            file.read_exact(&mut bytes).map_err(failed)?;
            out.extend(bytes.chunks_exact(2).map(|pair| {
                match i16::from_be_bytes([pair[0], pair[1]]) {
                    VOID => f32::NAN,
                    height => f32::from(height),
                }
            }));
        }
        Ok(out)
    }

    fn read_colours(&self, _window: Window) -> Result<Vec<[u8; 4]>, SourceError> {
        Err(SourceError::unsupported(&self.path, "an SRTM tile holds heights, not a picture"))
    }
}

/// Longitude and latitude of the south-west corner named by `N46W122...`.
fn place_of_name(path: &Path) -> Option<(f64, f64)> {
    let name = path.file_stem()?.to_str()?.to_ascii_uppercase();
    let signed = |part: &str, positive: char, negative: char| {
        let mut letters = part.chars();
        let sign = match letters.next()? {
            letter if letter == positive => 1.0,
            letter if letter == negative => -1.0,
            _ => return None,
        };
        letters.as_str().parse::<u32>().ok().map(|degrees| sign * f64::from(degrees))
    };
    let latitude = signed(name.get(0..3)?, 'N', 'S')?;
    let longitude = signed(name.get(3..7)?, 'E', 'W')?;
    (latitude.abs() <= 90.0 && longitude.abs() <= 180.0).then_some((longitude, latitude))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_tile_is_read_at_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("S46E007.hgt");
        let mut heights = vec![0_i16; 1201 * 1201];
        heights[0] = -11;
        heights[3 * 1201 + 5] = 4321;
        heights[4 * 1201 + 5] = VOID;
        let bytes: Vec<u8> = heights.iter().flat_map(|height| height.to_be_bytes()).collect();
        std::fs::write(&path, &bytes).unwrap();
        let source = HgtSource::open(&path).unwrap();
        let grid = source.info().grid.unwrap();
        // The first sample is the point 7 E, 45 S, and cells are centred on samples.
        assert!((grid.position(dvec2(0.5, 0.5)) - dvec2(7.0, -45.0)).length() < 1e-12);
        assert!((grid.position(dvec2(1200.5, 1200.5)) - dvec2(8.0, -46.0)).length() < 1e-12);
        let window = Window { column: 4, row: 3, width: 2, height: 2 };
        let read = source.read_heights(window).unwrap();
        assert_eq!(read[..3], [0.0, 4321.0, 0.0]);
        assert!(read[3].is_nan());
        std::fs::write(&path, &bytes[..100]).unwrap();
        assert!(matches!(HgtSource::open(&path), Err(SourceError::Damaged { .. })));
    }

    #[test]
    fn names_without_a_place_are_refused() {
        assert_eq!(place_of_name(Path::new("N46W122.hgt")), Some((-122.0, 46.0)));
        assert_eq!(place_of_name(Path::new("n05e010.SRTMGL1.hgt")), Some((10.0, 5.0)));
        for name in ["mountain.hgt", "N4.hgt", "N99E000.hgt", "éé12E000.hgt"] {
            assert_eq!(place_of_name(Path::new(name)), None, "{name}");
        }
    }
}

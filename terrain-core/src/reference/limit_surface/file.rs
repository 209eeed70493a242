use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use glam::DVec2;
use serde::Serialize;
use tempfile::NamedTempFile;

use super::{
    DistanceSet, LimitGrid, LimitRelief, LimitSurface, LimitSurfaceError, TriangleColours,
};
use crate::dataset::Crs;

/// What the file says of its surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimitFileHeader {
    /// CRS of the coordinates.
    pub crs: Crs,
    /// Where the triangles lie.
    pub grid: LimitGrid,
    /// The distances, metres; the first is the least, D_min.
    pub distances_m: Vec<f64>,
    /// The cone's apex angle, radians.
    pub admissible_angle_rad: f64,
    /// Factor on all heights.
    pub vertical_exaggeration: f64,
    /// Largest error of a triangle's reduced colours, steps of 1/255 of sRGB.
    pub limit_steps: f32,
}

impl LimitFileHeader {
    /// Five numbers of f64 and one of f32, columns, rows, the distances after their count, and the CRS
    /// as JSON after its length.
    fn to_bytes(&self, path: &Path) -> Result<Vec<u8>, LimitSurfaceError> {
        let crs = serde_json::to_vec(&self.crs)
            .map_err(|error| file_error(path, &std::io::Error::from(error)))?;
        let LimitGrid { origin, cell_m, columns, rows } = self.grid;
        let numbers =
            [origin.x, origin.y, cell_m, self.admissible_angle_rad, self.vertical_exaggeration];
        let mut bytes: Vec<u8> = numbers.into_iter().flat_map(f64::to_le_bytes).collect();
        bytes.extend(self.limit_steps.to_le_bytes());
        for word in [columns, rows, self.distances_m.len() as u32] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(self.distances_m.iter().flat_map(|distance_m| distance_m.to_le_bytes()));
        bytes.extend((crs.len() as u32).to_le_bytes());
        bytes.extend(crs);
        Ok(bytes)
    }
}

const MAGIC: &[u8; 8] = b"TERRLIMT";
const END: &[u8; 8] = b"TERRLEND";
/// The version this program writes and reads.
const VERSION: u32 = 1;
/// No CRS takes more bytes; what says so is damaged.
const MOST_CRS_BYTES: u32 = 1 << 16;

/// Writes a surface band by band, under a temporary name beside its own that is given up unless
/// [`Self::finish`] is reached.
///
/// The file, all numbers little-endian: magic, version, the header, CRC-32 of all this; then the bands from north to south, each its number of rows of cells and of knots,
/// the heights of its nodes (float32; the last band has one row more), the words of its triangles, its
/// knots and a CRC-32; then an end mark.
pub struct LimitFileWriter {
    path: PathBuf,
    file: BufWriter<NamedTempFile>,
    bytes: u64,
}

impl LimitFileWriter {
    /// Starts the file.
    ///
    /// # Errors
    /// [`LimitSurfaceError::File`] where it cannot be written.
    pub fn create(path: &Path, header: &LimitFileHeader) -> Result<Self, LimitSurfaceError> {
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let file = tempfile::Builder::new()
            .prefix(&format!(".{name}.partial-"))
            .tempfile_in(folder)
            .map_err(|error| file_error(path, &error))?;
        let mut writer = Self { path: path.to_owned(), file: BufWriter::new(file), bytes: 0 };
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(header.to_bytes(path)?);
        writer.put_checked(bytes)?;
        Ok(writer)
    }

    /// Adds the next rows of cells: the heights of their northern nodes, in the last band the southern
    /// too, and their triangles' colours.
    ///
    /// # Errors
    /// [`LimitSurfaceError::File`] where it cannot be written.
    pub fn add(
        &mut self,
        rows: u32,
        heights_m: &[f32],
        colours: &TriangleColours,
    ) -> Result<(), LimitSurfaceError> {
        let (words, knots) = colours.as_words();
        let mut bytes = Vec::with_capacity(8 + 4 * (heights_m.len() + words.len() + knots.len()));
        bytes.extend(rows.to_le_bytes());
        bytes.extend((knots.len() as u32).to_le_bytes());
        bytes.extend(heights_m.iter().flat_map(|height_m| height_m.to_le_bytes()));
        bytes.extend(words.iter().chain(knots).flat_map(|word| word.to_le_bytes()));
        self.put_checked(bytes)
    }

    /// Ends the file and gives it its name; answers its length in bytes.
    ///
    /// # Errors
    /// [`LimitSurfaceError::File`] where it cannot be written.
    pub fn finish(mut self) -> Result<u64, LimitSurfaceError> {
        self.put(END)?;
        let path = self.path;
        let file = self.file.into_inner().map_err(|error| file_error(&path, error.error()))?;
        share(file.as_file()).map_err(|error| file_error(&path, &error))?;
        file.persist(&path).map_err(|error| file_error(&path, &error.error))?;
        Ok(self.bytes)
    }

    fn put_checked(&mut self, mut bytes: Vec<u8>) -> Result<(), LimitSurfaceError> {
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        self.put(&bytes)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), LimitSurfaceError> {
        self.bytes += bytes.len() as u64;
        self.file.write_all(bytes).map_err(|error| file_error(&self.path, &error))
    }
}

/// Temporary files are private; a finished one is as readable as any new file.
#[cfg(unix)]
fn share(file: &File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn share(_file: &File) -> std::io::Result<()> {
    Ok(())
}

fn file_error(path: &Path, error: &std::io::Error) -> LimitSurfaceError {
    LimitSurfaceError::File { path: path.to_owned(), reason: error.to_string() }
}

/// Reads a surface from a file, checking everything.
///
/// # Errors
/// [`LimitSurfaceError::File`], [`LimitSurfaceError::Damaged`] or
/// [`LimitSurfaceError::OtherVersion`], naming the file.
pub fn read_limit_file(path: &Path) -> Result<(LimitFileHeader, LimitSurface), LimitSurfaceError> {
    let file = File::open(path).map_err(|error| file_error(path, &error))?;
    let length = file.metadata().map_err(|error| file_error(path, &error))?.len();
    let mut reader = Reader { path, file: BufReader::new(file), left: length, crc: None };
    let header = reader.header()?;
    let damaged = |reason: String| LimitSurfaceError::Damaged { path: path.to_owned(), reason };
    let distances =
        DistanceSet::new(header.distances_m.clone()).map_err(|error| damaged(error.to_string()))?;
    let grid = header.grid;
    let whole = LimitGrid::over(&grid.extent(), grid.cell_m);
    if whole.map_or(true, |whole| (whole.columns, whole.rows) != (grid.columns, grid.rows)) {
        return Err(damaged("its grid cannot be".to_owned()));
    }
    let mut heights_m = Vec::new();
    let mut colours = TriangleColours::new(distances.clone());
    let mut row = 0;
    while row < grid.rows {
        let band = reader.band(&grid, row, &distances)?;
        row += band.rows;
        heights_m.extend(band.heights_m);
        colours.append(&band.colours);
    }
    if reader.array::<8>()? != *END || reader.left > 0 {
        return Err(damaged("it does not end where it should".to_owned()));
    }
    let surface = LimitRelief::new(grid, heights_m)
        .and_then(|relief| LimitSurface::new(relief, colours, header.admissible_angle_rad))
        .map_err(|error| damaged(error.to_string()))?;
    Ok((header, surface))
}

struct Reader<'a> {
    path: &'a Path,
    file: BufReader<File>,
    /// Bytes not yet read.
    left: u64,
    /// Of what was read since it was set.
    crc: Option<crc32fast::Hasher>,
}

struct Band {
    rows: u32,
    heights_m: Vec<f32>,
    colours: TriangleColours,
}

impl Reader<'_> {
    fn damaged(&self, reason: impl Into<String>) -> LimitSurfaceError {
        LimitSurfaceError::Damaged { path: self.path.to_owned(), reason: reason.into() }
    }

    fn bytes(&mut self, count: u64) -> Result<Vec<u8>, LimitSurfaceError> {
        if count > self.left {
            return Err(self.damaged("it ends too early"));
        }
        let mut bytes = vec![0; count as usize];
        self.file.read_exact(&mut bytes).map_err(|error| file_error(self.path, &error))?;
        self.left -= count;
        if let Some(crc) = &mut self.crc {
            crc.update(&bytes);
        }
        Ok(bytes)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], LimitSurfaceError> {
        let mut array = [0; N];
        array.copy_from_slice(&self.bytes(N as u64)?);
        Ok(array)
    }

    fn word(&mut self) -> Result<u32, LimitSurfaceError> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn words(&mut self, count: u64) -> Result<Vec<u32>, LimitSurfaceError> {
        let bytes = self.bytes(4 * count)?;
        let word = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        Ok(bytes.chunks_exact(4).map(word).collect())
    }

    fn begin_check(&mut self) {
        self.crc = Some(crc32fast::Hasher::new());
    }

    fn end_check(&mut self, what: &str) -> Result<(), LimitSurfaceError> {
        let found = self.crc.take().map(crc32fast::Hasher::finalize);
        let stored = self.word()?;
        if found == Some(stored) {
            return Ok(());
        }
        Err(self.damaged(format!("the checksum of {what} does not match")))
    }

    fn header(&mut self) -> Result<LimitFileHeader, LimitSurfaceError> {
        self.begin_check();
        if self.array::<8>()? != *MAGIC {
            return Err(self.damaged("it is no limit-triangulated surface"));
        }
        let found = self.word()?;
        if found != VERSION {
            let (path, expected) = (self.path.to_owned(), VERSION);
            return Err(LimitSurfaceError::OtherVersion { path, found, expected });
        }
        let numbers = self.doubles(5)?;
        let limit_steps = f32::from_bits(self.word()?);
        let (columns, rows, count) = (self.word()?, self.word()?, self.word()?);
        if count as usize > DistanceSet::MOST {
            return Err(self.damaged("it has too many distances"));
        }
        let distances_m = self.doubles(u64::from(count))?;
        let length = self.word()?;
        if length > MOST_CRS_BYTES {
            return Err(self.damaged("its CRS is too long"));
        }
        let crs = self.bytes(u64::from(length))?;
        self.end_check("the header")?;
        Ok(LimitFileHeader {
            crs: serde_json::from_slice(&crs).map_err(|error| self.damaged(error.to_string()))?,
            grid: LimitGrid {
                origin: DVec2::new(numbers[0], numbers[1]),
                cell_m: numbers[2],
                columns,
                rows,
            },
            distances_m,
            admissible_angle_rad: numbers[3],
            vertical_exaggeration: numbers[4],
            limit_steps,
        })
    }

    fn doubles(&mut self, count: u64) -> Result<Vec<f64>, LimitSurfaceError> {
        let words = self.words(2 * count)?;
        let double = |pair: &[u32]| f64::from_bits(u64::from(pair[0]) | u64::from(pair[1]) << 32);
        Ok(words.chunks_exact(2).map(double).collect())
    }

    fn band(
        &mut self,
        grid: &LimitGrid,
        first_row: u32,
        distances: &DistanceSet,
    ) -> Result<Band, LimitSurfaceError> {
        self.begin_check();
        let (rows, knots) = (self.word()?, self.word()?);
        if rows == 0 || rows > grid.rows - first_row {
            return Err(self.damaged(format!("{rows} rows at row {first_row}")));
        }
        let node_rows = u64::from(rows) + u64::from(first_row + rows == grid.rows);
        let heights = self.words(node_rows * (u64::from(grid.columns) + 1))?;
        let words = self.words(2 * u64::from(rows) * u64::from(grid.columns))?;
        let knots = self.words(u64::from(knots))?;
        self.end_check(&format!("the rows from {first_row}"))?;
        let colours = TriangleColours::from_words(distances.clone(), words, knots)
            .map_err(|reason| self.damaged(format!("rows from {first_row}: {reason}")))?;
        Ok(Band { rows, heights_m: heights.into_iter().map(f32::from_bits).collect(), colours })
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::super::Knot;
    use super::*;

    fn header() -> LimitFileHeader {
        LimitFileHeader {
            crs: Crs { epsg: Some(32632), name: "UTM".to_owned() },
            grid: LimitGrid { origin: dvec2(1.0, 2.0), cell_m: 3.0, columns: 4, rows: 3 },
            distances_m: vec![10.0, 20.0],
            admissible_angle_rad: 0.001,
            vertical_exaggeration: 1.0,
            limit_steps: 2.0,
        }
    }

    /// Two bands, of two rows and of one.
    fn write(path: &Path) -> LimitSurface {
        let header = header();
        let distances = DistanceSet::new(header.distances_m.clone()).unwrap();
        let heights_m: Vec<f32> = (0..20).map(|i| i as f32).collect();
        let knot = |distance: u8, code: u8| Knot { distance, srgb: [code; 3] };
        let mut writer = LimitFileWriter::create(path, &header).unwrap();
        let mut all = TriangleColours::new(distances.clone());
        for (rows, nodes) in [(2, 0..10), (1, 10..20)] {
            let mut band = TriangleColours::new(distances.clone());
            for triangle in 0..8 * rows as u8 {
                let knots = [knot(0, triangle), knot(1, 100 + triangle)];
                band.push(&knots[..usize::from(triangle % 3)]);
            }
            writer.add(rows, &heights_m[nodes], &band).unwrap();
            all.append(&band);
        }
        writer.finish().unwrap();
        let relief = LimitRelief::new(header.grid, heights_m).unwrap();
        LimitSurface::new(relief, all, header.admissible_angle_rad).unwrap()
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.limit");
        let surface = write(&path);
        assert_eq!(read_limit_file(&path).unwrap(), (header(), surface));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn every_damaged_byte_and_every_missing_end_is_found_and_the_file_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.limit");
        write(&path);
        let whole = std::fs::read(&path).unwrap();
        let check = |bytes: &[u8], what: String| {
            std::fs::write(&path, bytes).unwrap();
            let error = read_limit_file(&path).expect_err(&what);
            assert!(error.to_string().contains("a.limit"), "{what}: {error}");
        };
        for index in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[index] ^= 0x10;
            check(&damaged, format!("byte {index}"));
            check(&whole[..index], format!("length {index}"));
        }
        check(&[&whole[..], &[0]].concat(), "a byte too many".to_owned());
    }

    #[test]
    fn another_version_says_so_and_an_unfinished_file_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.limit");
        write(&path);
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[8] = 2;
        std::fs::write(&path, bytes).unwrap();
        let error = read_limit_file(&path).unwrap_err();
        assert!(matches!(error, LimitSurfaceError::OtherVersion { found: 2, .. }), "{error}");
        std::fs::remove_file(&path).unwrap();
        drop(LimitFileWriter::create(&path, &header()).unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

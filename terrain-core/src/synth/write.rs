use std::fs::File;
use std::io::{BufWriter, ErrorKind, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use tempfile::NamedTempFile;
use tiff::TiffResult;
use tiff::encoder::colortype::{GrayI16, RGB8};
use tiff::encoder::{ImageEncoder, TiffEncoder, TiffKindStandard};

use super::geotiff_strips::{GeoTiffHeader, STRIP_ROWS};
use super::ground::Ground;
use super::preset::{COLOUR_CELL_M, COLOURS_PER_HEIGHT, EPSG, HEIGHT_CELL_M, Preset};
use super::raster_rows::RasterRows;
use crate::progress::Progress;

/// Name of the heights' file.
pub const HEIGHTS_FILE: &str = "dem.tif";
/// Name of the picture's file.
pub const COLOURS_FILE: &str = "dom.tif";
/// Rows of heights made at a time.
const BAND_ROWS: usize = 4 * STRIP_ROWS;

/// What to synthesise.
#[derive(Clone, Debug)]
pub struct SynthRequest {
    /// Which part of the ground.
    pub preset: Preset,
    /// Another seed is another ground of the same kind.
    pub seed: u32,
    /// Folder to write to; made where it is not there. Files that are there are never replaced.
    pub out: PathBuf,
}

/// What was written.
#[derive(Clone, Debug)]
pub struct SynthSummary {
    /// The heights: 16-bit whole metres.
    pub heights_path: PathBuf,
    /// The picture: RGB of 8 bits.
    pub colours_path: PathBuf,
    /// Lowest and highest height in metres.
    pub height_range_m: [i16; 2],
    /// Time from start to end.
    pub elapsed: Duration,
}

/// Why rasters could not be synthesised. Nothing half-made is left behind.
#[derive(Debug, thiserror::Error)]
pub enum SynthError {
    /// A file of the output's name is there.
    #[error("{}: is there already; choose another --out", path.display())]
    Occupied {
        /// The file.
        path: PathBuf,
    },
    /// The folder or a file cannot be written.
    #[error("{}: {reason}", path.display())]
    Output {
        /// The folder or file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The caller asked to stop.
    #[error("stopped; nothing was written")]
    Cancelled,
}

/// Writes the rasters of a synthetic ground: heights and a picture of it as GeoTIFF.
///
/// The same preset and seed give the same bytes, whatever the number of threads. Memory does not grow
/// with the rasters' rows. Files appear when both are whole; on an error, or once `cancel` is set,
/// nothing is left.
pub fn synthesise(
    request: &SynthRequest,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<SynthSummary, SynthError> {
    let started = Instant::now();
    let folder = OutputFolder::open(&request.out)?;
    let [heights_path, colours_path] =
        [HEIGHTS_FILE, COLOURS_FILE].map(|name| request.out.join(name));
    let heights = folder.start(&heights_path)?;
    let colours = folder.start(&colours_path)?;
    let ground = Ground::new(request.seed, |share| {
        progress.advanced("raising mountains", (1000.0 * share) as u64, 1000);
        !cancel.load(Ordering::Relaxed)
    });
    let ground = ground.ok_or(SynthError::Cancelled)?;
    let height_range_m = write_rasters(&ground, request, [&heights, &colours], progress, cancel)?;
    finish(heights, &heights_path)?;
    if let Err(error) = finish(colours, &colours_path) {
        // One without the other is half-made.
        let _ = std::fs::remove_file(&heights_path);
        return Err(error);
    }
    folder.keep();
    let elapsed = started.elapsed();
    Ok(SynthSummary { heights_path, colours_path, height_range_m, elapsed })
}

/// Writes both rasters into open files; returns the range of heights in metres.
fn write_rasters(
    ground: &Ground,
    request: &SynthRequest,
    [heights_file, colours_file]: [&NamedTempFile; 2],
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<[i16; 2], SynthError> {
    let failed = |error: tiff::TiffError| output_error(&request.out, error);
    let [heights_header, colours_header] = headers(request);
    let mut heights_out = BufWriter::new(heights_file.as_file());
    let mut colours_out = BufWriter::new(colours_file.as_file());
    let mut heights_encoder = TiffEncoder::new(&mut heights_out).map_err(failed)?;
    let mut colours_encoder = TiffEncoder::new(&mut colours_out).map_err(failed)?;
    let mut heights = heights_header.start(&mut heights_encoder).map_err(failed)?;
    let mut colours = colours_header.start(&mut colours_encoder).map_err(failed)?;

    let preset = request.preset;
    let mut rows = RasterRows::new(ground, preset, request.seed);
    let mut range_m = [i16::MAX, i16::MIN];
    for row in (0..preset.heights_side).step_by(BAND_ROWS) {
        if cancel.load(Ordering::Relaxed) {
            return Err(SynthError::Cancelled);
        }
        let count = BAND_ROWS.min(preset.heights_side - row);
        rows.advance(row, count);
        let band_m = write_band(&rows, row..row + count, &mut heights, &mut colours);
        let [low_m, high_m] = band_m.map_err(failed)?;
        range_m = [range_m[0].min(low_m), range_m[1].max(high_m)];
        progress.advanced("drawing", (row + count) as u64, preset.heights_side as u64);
    }
    heights.finish().map_err(failed)?;
    colours.finish().map_err(failed)?;
    for out in [&mut heights_out, &mut colours_out] {
        out.flush().map_err(|error| output_error(&request.out, error))?;
    }
    Ok(range_m)
}

type Sheet<'w, 'f, C> = ImageEncoder<'w, &'w mut BufWriter<&'f File>, C, TiffKindStandard>;

/// Writes the strips of a band of rows of heights; returns their range in metres.
fn write_band(
    rows: &RasterRows<'_>,
    band: Range<usize>,
    heights: &mut Sheet<'_, '_, GrayI16>,
    colours: &mut Sheet<'_, '_, RGB8>,
) -> TiffResult<[i16; 2]> {
    let mut range_m = [i16::MAX, i16::MIN];
    for (first, count) in strips(band.start, band.len()) {
        let strip = rows.heights(first, count);
        range_m = strip.iter().fold(range_m, |[low, high], &h| [low.min(h), high.max(h)]);
        heights.write_strip(&strip)?;
    }
    for (first, count) in strips(COLOURS_PER_HEIGHT * band.start, COLOURS_PER_HEIGHT * band.len()) {
        colours.write_strip(&rows.colours(first, count))?;
    }
    Ok(range_m)
}

/// Headers of the heights and the picture.
fn headers(request: &SynthRequest) -> [GeoTiffHeader; 2] {
    let preset = request.preset;
    let header = |what: &str, cell_m: f64, side: usize| GeoTiffHeader {
        side,
        corner_m: preset.corner_m(),
        cell_m,
        epsg: EPSG,
        description: format!(
            "SYNTHETIC, not a real place: {what}, preset {}, seed {}",
            preset.name, request.seed
        ),
    };
    [
        header("heights in metres", HEIGHT_CELL_M, preset.heights_side),
        header("picture", COLOUR_CELL_M, preset.colours_side()),
    ]
}

/// First row and number of rows of every strip of a band.
fn strips(row: usize, count: usize) -> impl Iterator<Item = (usize, usize)> {
    let end = row + count;
    (row..end).step_by(STRIP_ROWS).map(move |first| (first, STRIP_ROWS.min(end - first)))
}

fn finish(file: NamedTempFile, path: &Path) -> Result<(), SynthError> {
    share(file.path()).map_err(|error| output_error(path, error))?;
    file.persist_noclobber(path).map_err(|error| match error.error.kind() {
        ErrorKind::AlreadyExists => SynthError::Occupied { path: path.to_owned() },
        _ => output_error(path, error.error),
    })?;
    Ok(())
}

fn output_error(path: &Path, error: impl std::fmt::Display) -> SynthError {
    SynthError::Output { path: path.to_owned(), reason: error.to_string() }
}

/// Temporary files are private; finished ones are as readable as any new file.
#[cfg(unix)]
fn share(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn share(_path: &Path) -> std::io::Result<()> {
    Ok(())
}

/// The folder written to. Dropped before it is kept, it goes again if it was made here.
struct OutputFolder {
    path: PathBuf,
    is_new: bool,
}

impl OutputFolder {
    fn open(path: &Path) -> Result<Self, SynthError> {
        let is_new = !path.exists();
        std::fs::create_dir_all(path).map_err(|error| output_error(path, error))?;
        Ok(Self { path: path.to_owned(), is_new })
    }

    /// Starts a file under a temporary name beside its own.
    fn start(&self, target: &Path) -> Result<NamedTempFile, SynthError> {
        if target.exists() {
            return Err(SynthError::Occupied { path: target.to_owned() });
        }
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        let prefix = format!(".{name}.partial-");
        let file = tempfile::Builder::new().prefix(&prefix).tempfile_in(&self.path);
        file.map_err(|error| output_error(&self.path, error))
    }

    fn keep(mut self) {
        self.is_new = false;
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if self.is_new {
            // Not empty: somebody else's by now.
            let _ = std::fs::remove_dir(&self.path);
        }
    }
}

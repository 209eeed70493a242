use std::path::{Path, PathBuf};

use super::archive_reader::ArchiveReader;
use super::codec::{decode_colours, decode_heights};
use super::{ColourTile, HeightTile, LoadError, Loaded, Manifest, Shape, TileSource};
use crate::geodesy::PlateCarree;
use crate::tiling::{MAX_LEVEL, TileId, TileSet};

/// Name of the manifest in a dataset's folder.
pub const MANIFEST_FILE: &str = "manifest.json";
/// Name of the height archive in a dataset's folder.
pub const HEIGHTS_FILE: &str = "heights.pmtiles";
/// Name of the colour archive in a dataset's folder.
pub const COLOURS_FILE: &str = "colours.pmtiles";

/// A prepared dataset on disk.
///
/// The archives are mapped into memory: they must not be changed while the dataset is open.
/// Preparing anew is safe, since it replaces the folder instead of writing into it.
pub struct Dataset {
    manifest: Manifest,
    heights: ArchiveReader,
    colours: Option<ArchiveReader>,
    no_tiles: TileSet,
}

/// Why a dataset cannot be opened. The file is always named.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// There is no manifest: the folder is no dataset, or is not there.
    #[error("{}: not a dataset (no {MANIFEST_FILE}); `terrain prepare` makes one", path.display())]
    NotADataset {
        /// The folder.
        path: PathBuf,
    },
    /// The manifest is damaged or says what cannot be.
    #[error(
        "{}: damaged, or not the manifest of a dataset ({reason}); prepare the dataset anew",
        path.display()
    )]
    BadManifest {
        /// The manifest.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// Another version of this program wrote it.
    #[error("{}: dataset version {found}, this program reads {}; prepare it anew", path.display(), Manifest::VERSION)]
    OtherVersion {
        /// The manifest.
        path: PathBuf,
        /// The version found.
        found: u64,
    },
    /// A tile archive is missing or damaged.
    #[error("{}: {reason}", path.display())]
    BadArchive {
        /// The archive.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

impl Dataset {
    /// Opens the dataset in a folder.
    pub fn open(folder: &Path) -> Result<Self, OpenError> {
        let manifest = read_manifest(folder)?;
        let heights = open_archive(folder, HEIGHTS_FILE)?;
        let colours = match &manifest.colours {
            Some(_) => Some(open_archive(folder, COLOURS_FILE)?),
            None => None,
        };
        Ok(Self { manifest, heights, colours, no_tiles: TileSet::new() })
    }

    /// The stored bytes of a height tile, as they are on disk.
    pub fn height_payload_len(&self, tile: TileId) -> Result<u64, LoadError> {
        self.heights.payload(tile).map(|bytes| bytes.len() as u64)
    }

    /// The stored bytes of a colour tile, as they are on disk.
    pub fn colour_payload_len(&self, tile: TileId) -> Result<u64, LoadError> {
        let archive = self.colours.as_ref().ok_or_else(|| self.no_colours(tile))?;
        archive.payload(tile).map(|bytes| bytes.len() as u64)
    }

    fn no_colours(&self, tile: TileId) -> LoadError {
        LoadError::Absent { path: self.heights.path().with_file_name(COLOURS_FILE), tile }
    }
}

impl TileSource for Dataset {
    fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    fn heights_present(&self) -> &TileSet {
        self.heights.present()
    }

    fn colours_present(&self) -> &TileSet {
        self.colours.as_ref().map_or(&self.no_tiles, ArchiveReader::present)
    }

    fn load_heights(&self, tile: TileId) -> Result<Loaded<HeightTile>, LoadError> {
        let payload = self.heights.payload(tile)?;
        let size_texels = self.manifest.heights.layout.stored_size_texels();
        let decoded = decode_heights(&payload, tile, size_texels)
            .map_err(|error| damaged(&self.heights, tile, error.to_string()))?;
        Ok(Loaded { tile: decoded, disk_bytes: payload.len() as u64 })
    }

    fn load_colours(&self, tile: TileId) -> Result<Loaded<ColourTile>, LoadError> {
        let (archive, layer) = self
            .colours
            .as_ref()
            .zip(self.manifest.colours.as_ref())
            .ok_or_else(|| self.no_colours(tile))?;
        let payload = archive.payload(tile)?;
        let decoded =
            decode_colours(&payload, tile, layer.layout.stored_size_texels(), layer.format)
                .map_err(|error| damaged(archive, tile, error.to_string()))?;
        Ok(Loaded { tile: decoded, disk_bytes: payload.len() as u64 })
    }
}

fn damaged(archive: &ArchiveReader, tile: TileId, reason: String) -> LoadError {
    LoadError::Damaged { path: archive.path().to_owned(), tile, reason }
}

fn open_archive(folder: &Path, name: &str) -> Result<ArchiveReader, OpenError> {
    let path = folder.join(name);
    ArchiveReader::open(&path).map_err(|reason| OpenError::BadArchive { path, reason })
}

fn read_manifest(folder: &Path) -> Result<Manifest, OpenError> {
    let path = folder.join(MANIFEST_FILE);
    let bad = |reason: String| OpenError::BadManifest { path: path.clone(), reason };
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(OpenError::NotADataset { path: folder.to_owned() });
        }
        Err(error) => return Err(bad(error.to_string())),
    };
    let value: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| bad(error.to_string()))?;
    let found = value.get("version").and_then(serde_json::Value::as_u64);
    match found {
        Some(found) if found != u64::from(Manifest::VERSION) => {
            return Err(OpenError::OtherVersion { path, found });
        }
        _ => {}
    }
    let manifest: Manifest =
        serde_json::from_value(value).map_err(|error| bad(error.to_string()))?;
    check(&manifest).map_err(bad)?;
    Ok(manifest)
}

/// Refuses what the rest of the program takes for granted.
fn check(manifest: &Manifest) -> Result<(), String> {
    let scheme = &manifest.scheme;
    if !(scheme.origin.is_finite() && scheme.root_size_m.is_finite() && scheme.root_size_m > 0.0) {
        return Err("the root tile has no valid place or size".to_owned());
    }
    let lies_on_globe =
        *scheme == PlateCarree::scheme() && manifest.data_extent == PlateCarree::extent();
    if manifest.shape == Shape::Globe && !lies_on_globe {
        return Err("a globe whose tiles do not lie round the Earth".to_owned());
    }
    let layouts = std::iter::once(manifest.heights.layout)
        .chain(manifest.colours.as_ref().map(|layer| layer.layout));
    for layout in layouts {
        let sizes_fit = (8..=4096).contains(&layout.tile_size_texels)
            && layout.tile_size_texels % 8 == 0
            && layout.gutter_texels <= 64
            && layout.gutter_texels % 4 == 0;
        if !sizes_fit || layout.level_count == 0 || layout.level_count > MAX_LEVEL + 1 {
            return Err(format!("tile sizes cannot be: {layout:?}"));
        }
    }
    Ok(())
}

//! The scene file: which models stand where, as JSON.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::dvec2;
use serde::Deserialize;

use super::error::SceneFileError;
use super::model::Model;
use super::placement::{ModelInstance, Standing};
use crate::dataset::{Manifest, Shape};
use crate::geodesy::PlateCarree;

/// Models and where they stand.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelScene {
    /// The CRS of all places, an EPSG code; `None` where the file names none, and whatever the dataset's is counts.
    pub epsg: Option<u32>,
    /// The models, each once.
    pub models: Vec<Model>,
    /// Where they stand.
    pub instances: Vec<ModelInstance>,
    /// What a reader should know of the models, with the files' names.
    pub notes: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    crs: Option<String>,
    models: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    file: PathBuf,
    x: f64,
    y: f64,
    height: Option<f64>,
    #[serde(default)]
    snap: bool,
    #[serde(default)]
    heading: f64,
    #[serde(default = "one")]
    scale: f64,
}

fn one() -> f64 {
    1.0
}

/// Largest scale a model may have.
const MOST_SCALE: f64 = 1.0e6;

impl ModelScene {
    /// Reads a scene file and the models it names, whose paths are relative to it.
    ///
    /// # Errors
    /// [`SceneFileError`] where the file cannot be read or says what cannot be, or a model cannot be read.
    pub fn load(path: &Path) -> Result<Self, SceneFileError> {
        let failed = |reason: String| SceneFileError::File { path: path.to_owned(), reason };
        let text = std::fs::read_to_string(path).map_err(|error| failed(error.to_string()))?;
        let file: File = serde_json::from_str(&text).map_err(|error| failed(error.to_string()))?;
        let epsg = file.crs.as_deref().map(|crs| {
            let code = crs.strip_prefix("EPSG:").and_then(|code| code.parse().ok());
            code.ok_or_else(|| failed(format!("{crs} is no CRS such as EPSG:32632")))
        });
        let mut scene = Self { epsg: epsg.transpose()?, ..Default::default() };
        let mut known = HashMap::new();
        for (entry, number) in file.models.into_iter().zip(1..) {
            scene.add(entry, path, &mut known).map_err(|reason| SceneFileError::Entry {
                path: path.to_owned(),
                entry: number,
                reason,
            })?;
        }
        Ok(scene)
    }

    fn add(
        &mut self,
        entry: Entry,
        scene: &Path,
        known: &mut HashMap<PathBuf, usize>,
    ) -> Result<(), String> {
        let standing = entry.standing()?;
        entry.check()?;
        let path = scene.parent().unwrap_or_else(|| Path::new("")).join(&entry.file);
        let model = match known.get(&path) {
            Some(&model) => model,
            None => {
                let model = Model::load(&path).map_err(|error| error.to_string())?;
                let named = |note: &String| format!("{}: {note}", path.display());
                self.notes.extend(model.notes.iter().map(named));
                self.models.push(model);
                known.insert(path, self.models.len() - 1);
                self.models.len() - 1
            }
        };
        self.instances.push(ModelInstance {
            model,
            place: dvec2(entry.x, entry.y),
            standing,
            heading_deg: entry.heading,
            scale: entry.scale,
        });
        Ok(())
    }

    /// Brings the places, as they stand in the file, into the coordinates of a dataset: longitudes and latitudes in
    /// degrees where it is a globe, else its own CRS.
    ///
    /// # Errors
    /// In words, where the file names another CRS than that.
    pub fn placed_on(mut self, manifest: &Manifest) -> Result<Self, String> {
        const DEGREES: u32 = 4326;
        let is_globe = manifest.shape == Shape::Globe;
        let ours = if is_globe { Some(DEGREES) } else { manifest.crs.epsg };
        if let (Some(theirs), Some(ours)) = (self.epsg, ours)
            && theirs != ours
        {
            return Err(format!(
                "the models are placed in EPSG:{theirs}, where places of the dataset are in EPSG:{ours}"
            ));
        }
        if is_globe {
            for instance in &mut self.instances {
                instance.place = PlateCarree::metres_from_degrees(instance.place);
            }
        }
        Ok(self)
    }

    /// Triangles of all instances together.
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().map(|instance| self.models[instance.model].triangle_count()).sum()
    }
}

impl Entry {
    fn standing(&self) -> Result<Standing, String> {
        match (self.height, self.snap) {
            (Some(height_m), false) if height_m.is_finite() => Ok(Standing::Height(height_m)),
            (None, true) => Ok(Standing::OnGround),
            (Some(_), true) => Err("give either \"height\" or \"snap\", not both".to_owned()),
            _ => Err("give its \"height\" in metres, or \"snap\": true".to_owned()),
        }
    }

    fn check(&self) -> Result<(), String> {
        if !(self.x.is_finite() && self.y.is_finite() && self.heading.is_finite()) {
            return Err("\"x\", \"y\" and \"heading\" must be numbers".to_owned());
        }
        if !(self.scale > 0.0 && self.scale <= MOST_SCALE) {
            return Err(format!(
                "\"scale\" is {}: it must lie above 0, up to {MOST_SCALE}",
                self.scale
            ));
        }
        Ok(())
    }
}

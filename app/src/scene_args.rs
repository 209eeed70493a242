//! The options on what is drawn beside the dataset.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context;
use clap::Args;
use terrain_core::dataset::TileSource;
use terrain_core::surface::models::ModelScene;

use crate::output;

/// What stands on the ground.
#[derive(Clone, Debug, Default, Args)]
pub struct SceneArgs {
    /// Draw models on the ground: a scene file that says which glTF files stand where; see docs/models.md
    #[arg(long, value_name = "SCENE.json")]
    models: Option<PathBuf>,
}

impl SceneArgs {
    /// Reads the models, if any are asked for, and tells what of them cannot be drawn.
    ///
    /// # Errors
    /// Where a file cannot be read, or the models are placed in another CRS than the dataset's.
    pub fn models(&self, source: &dyn TileSource) -> anyhow::Result<Option<Arc<ModelScene>>> {
        let Some(path) = &self.models else { return Ok(None) };
        let scene = ModelScene::load(path)?;
        let checked = scene.check_crs(&source.manifest().crs).map_err(anyhow::Error::msg);
        checked.with_context(|| path.display().to_string())?;
        for note in &scene.notes {
            output::say(&format!("terrain: {note}"));
        }
        Ok(Some(Arc::new(scene)))
    }
}

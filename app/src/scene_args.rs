//! The options on what is drawn beside the dataset.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context;
use clap::Args;
use terrain_core::dataset::TileSource;
use terrain_core::surface::models::ModelScene;
use terrain_core::surface::tin::TinGround;
use terrain_core::{RenderError, TerrainRenderer};

use crate::output;

/// What stands on the ground, and other ground to stand on.
#[derive(Clone, Debug, Default, Args)]
pub struct SceneArgs {
    /// Draw models on the ground: a scene file that says which glTF files stand where; see docs/models.md
    #[arg(long, value_name = "SCENE.json")]
    models: Option<PathBuf>,

    /// Draw the ground of a TIN made by terrain tin instead of the dataset's heights, with the dataset's
    /// imagery through a page table
    #[arg(long, value_name = "TIN.glb")]
    tin: Option<PathBuf>,
}

/// What is drawn beside a dataset, or in place of its heights.
#[derive(Clone, Default)]
pub struct SceneObjects {
    /// What stands on the ground.
    pub models: Option<Arc<ModelScene>>,
    /// The ground, where it is not the dataset's.
    pub tin: Option<Arc<TinGround>>,
}

impl SceneObjects {
    /// Has the renderer draw them.
    ///
    /// # Errors
    /// Where they cannot be drawn.
    pub fn put_into(&self, renderer: &mut TerrainRenderer) -> Result<(), RenderError> {
        if self.tin.is_some() {
            renderer.set_tin(self.tin.clone())?;
        }
        renderer.set_models(self.models.clone())
    }

    /// Those that a renderer draws.
    pub fn of(renderer: &TerrainRenderer) -> Self {
        Self { models: renderer.models().cloned(), tin: renderer.tin().cloned() }
    }
}

impl SceneArgs {
    /// Reads what is asked for and tells what of it cannot be drawn.
    ///
    /// # Errors
    /// Where a file cannot be read, or its places are in another CRS than the dataset's.
    pub fn open(&self, source: &dyn TileSource) -> anyhow::Result<SceneObjects> {
        Ok(SceneObjects { models: self.models(source)?, tin: self.tin(source)? })
    }

    fn tin(&self, source: &dyn TileSource) -> anyhow::Result<Option<Arc<TinGround>>> {
        let Some(path) = &self.tin else { return Ok(None) };
        let tin = TinGround::load(path)?;
        let checked = tin
            .check_place(&source.manifest().crs, source.manifest().shape)
            .map_err(anyhow::Error::msg);
        checked.with_context(|| path.display().to_string())?;
        Ok(Some(Arc::new(tin)))
    }

    fn models(&self, source: &dyn TileSource) -> anyhow::Result<Option<Arc<ModelScene>>> {
        let Some(path) = &self.models else { return Ok(None) };
        let placed = ModelScene::load(path)?.placed_on(source.manifest());
        let scene = placed.map_err(anyhow::Error::msg);
        let scene = scene.with_context(|| path.display().to_string())?;
        for note in &scene.notes {
            output::say(&format!("terrain: {note}"));
        }
        Ok(Some(Arc::new(scene)))
    }
}

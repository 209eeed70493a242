use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use anyhow::ensure;
use terrain_core::RendererSettings;
use terrain_core::dataset::{Dataset, TileSource};
use terrain_core::measure::sweep::{Knob, Sweep};

use super::name_of;
use super::variant::Variant;

/// One way of drawing every flight.
#[derive(Clone)]
pub struct RunPlan {
    /// What the run is called; unique.
    pub name: String,
    /// The strategy, as it was asked for.
    pub strategy: String,
    /// How it is drawn.
    pub settings: RendererSettings,
    /// What is drawn.
    pub source: Arc<dyn TileSource>,
    /// Whether this run stands for its strategy where one has to: that with the settings as they were
    /// given, or one amid the sweep.
    pub is_typical: bool,
}

/// A run for each strategy and each value of the knob.
///
/// # Errors
/// Where a value is out of range, a dataset cannot be opened or lies elsewhere, or two runs would have
/// one name.
pub fn plans(
    variants: &[Variant],
    sweep: Option<&Sweep>,
    source: &Arc<dyn TileSource>,
    settings: RendererSettings,
) -> anyhow::Result<Vec<RunPlan>> {
    let mut plans = Vec::new();
    for variant in variants {
        let (name, settings) = (variant.name.clone(), variant.of(settings));
        let plain = RunPlan {
            strategy: name.clone(),
            name,
            settings,
            source: Arc::clone(source),
            is_typical: true,
        };
        match sweep {
            None => plans.push(plain),
            Some(sweep) => plans.extend(swept(&plain, sweep, variants.len() > 1)?),
        }
    }
    check_names("runs", plans.iter().map(|plan| plan.name.as_str()))?;
    Ok(plans)
}

/// The run once for each value of the knob.
fn swept(plain: &RunPlan, sweep: &Sweep, is_one_of_many: bool) -> anyhow::Result<Vec<RunPlan>> {
    let mut plans = Vec::new();
    for value in &sweep.values {
        let mut plan = RunPlan { is_typical: false, ..plain.clone() };
        plan.settings = sweep.knob.turned(plain.settings, value)?;
        let setting = format!("{}={}", sweep.knob.name(), short_value(sweep, value));
        plan.name = if is_one_of_many { format!("{} {setting}", plan.name) } else { setting };
        if sweep.knob == Knob::Dataset {
            plan.source = same_ground(&plain.source, Path::new(value))?;
        }
        plans.push(plan);
    }
    let as_given = plans.iter().position(|plan| plan.settings == plain.settings);
    let typical = as_given.unwrap_or(plans.len() / 2);
    plans[typical].is_typical = true;
    Ok(plans)
}

/// Tables, files and plots tell runs and flights apart by their names alone.
///
/// # Errors
/// Where a name is given twice.
pub fn check_names<'a>(what: &str, names: impl IntoIterator<Item = &'a str>) -> anyhow::Result<()> {
    let mut seen = HashSet::new();
    for name in names {
        ensure!(seen.insert(name), "two {what} would be called {name}: give each once");
    }
    Ok(())
}

/// Folders are known by their last name, unless another of the sweep has the same.
fn short_value(sweep: &Sweep, value: &str) -> String {
    let last = |value: &str| name_of(Path::new(value));
    let namesakes = sweep.values.iter().filter(|other| last(other) == last(value)).count();
    if sweep.knob == Knob::Dataset && namesakes == 1 { last(value) } else { value.to_owned() }
}

/// Opens a dataset whose pictures can be compared with those of `source`.
fn same_ground(source: &Arc<dyn TileSource>, folder: &Path) -> anyhow::Result<Arc<dyn TileSource>> {
    let other = Dataset::open(folder)?;
    let (ours, theirs) = (source.manifest(), other.manifest());
    ensure!(
        ours.crs == theirs.crs && ours.data_extent == theirs.data_extent,
        "{}: lies elsewhere than the dataset it is to be compared with",
        folder.display(),
    );
    Ok(Arc::new(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_one_name_are_refused() {
        assert!(check_names("runs", ["a", "b"]).is_ok());
        let error = check_names("runs", ["a", "b", "a"]).unwrap_err().to_string();
        assert!(error.contains("called a:"), "{error}");
    }

    #[test]
    fn folders_with_the_same_last_name_keep_their_paths() {
        let sweep = "dataset=x/alps,y/alps,y/jura".parse::<Sweep>().unwrap();
        let names = sweep.values.iter().map(|value| short_value(&sweep, value));
        assert_eq!(names.collect::<Vec<_>>(), ["x/alps", "y/alps", "jura"]);
    }
}

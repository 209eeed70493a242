use std::str::FromStr;

use terrain_core::RendererSettings;
use terrain_core::selection::{Shortening, Strategy, Visibility};

/// What stands for every strategy.
const ALL: &str = "all";

/// A strategy to compare, and what of its settings differs from those given to all.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// As the user named it: `rtt-quadtree+exact`.
    pub name: String,
    strategy: Strategy,
    visibility: Option<Visibility>,
    shortening: Option<Shortening>,
}

impl Variant {
    /// The strategy.
    pub fn strategy(&self) -> Strategy {
        self.strategy
    }

    /// The settings as the variant has them.
    pub fn of(&self, settings: RendererSettings) -> RendererSettings {
        RendererSettings {
            strategy: self.strategy,
            visibility: self.visibility.unwrap_or(settings.visibility),
            shortening: self.shortening.unwrap_or(settings.shortening),
            ..settings
        }
    }
}

impl From<Strategy> for Variant {
    fn from(strategy: Strategy) -> Self {
        let name = strategy.name().to_owned();
        Self { name, strategy, visibility: None, shortening: None }
    }
}

impl FromStr for Variant {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut parts = text.split('+');
        let name = parts.next().unwrap_or_default();
        let strategy = name.parse::<Strategy>().map_err(|error| error.to_string())?;
        let mut variant = Self { name: text.to_owned(), ..strategy.into() };
        for part in parts {
            match (part.parse(), part.parse()) {
                (Ok(visibility), _) => variant.visibility = Some(visibility),
                (_, Ok(shortening)) => variant.shortening = Some(shortening),
                _ => {
                    return Err(format!(
                        "{text}: no {part:?}; a strategy may be followed by +box, +exact, +farthest or \
                         +least-error"
                    ));
                }
            }
        }
        Ok(variant)
    }
}

/// Variants as they are given: with commas between them, or all strategies.
#[derive(Clone, Debug)]
pub struct VariantList(pub Vec<Variant>);

impl FromStr for VariantList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let variants = match text {
            ALL => Strategy::ALL.map(Variant::from).to_vec(),
            names => names.split(',').map(str::parse).collect::<Result<_, _>>()?,
        };
        Ok(Self(variants))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(text: &str) -> Result<Vec<Variant>, String> {
        text.parse().map(|VariantList(variants)| variants)
    }

    #[test]
    fn strategies_are_a_list_or_all_of_them() {
        let names =
            |text| list(text).map(|variants| variants.into_iter().map(|v| v.name).collect());
        assert_eq!(names("all"), Ok(Strategy::ALL.map(|s| s.name().to_owned()).to_vec()));
        assert_eq!(
            names("clipmap,cpu-mesh"),
            Ok(vec!["clipmap".to_owned(), "cpu-mesh".to_owned()])
        );
        assert!(list("clipmap,").is_err() && list("").is_err());
    }

    #[test]
    fn a_strategy_may_differ_from_the_settings_of_all() {
        let variants = list("rtt-quadtree,rtt-quadtree-gpu+exact+least-error").unwrap();
        let settings = RendererSettings { texel_px: 3.0, ..Default::default() };
        assert_eq!(variants[0].of(settings), settings);
        let expected = RendererSettings {
            strategy: Strategy::RttQuadtreeGpu,
            visibility: Visibility::Exact,
            shortening: Shortening::LeastError,
            ..settings
        };
        assert_eq!(variants[1].of(settings), expected);
        assert_eq!(variants[1].name, "rtt-quadtree-gpu+exact+least-error");
        assert!(list("rtt-quadtree+sharp").unwrap_err().contains("+exact"));
    }
}

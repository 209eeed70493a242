//! What is compared with what, and how it is shown.

use terrain_core::RendererSettings;
use terrain_core::selection::Strategy;

/// How two scenes are shown in one window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// There is only one.
    #[default]
    Off,
    /// The first left of a divider, the second right of it.
    Split,
    /// In turn.
    Flicker,
}

impl Mode {
    /// Every mode and its name.
    pub const ALL: [(Self, &str); 3] =
        [(Self::Off, "off"), (Self::Split, "split"), (Self::Flicker, "flicker")];

    /// The mode after this one, in a ring.
    pub fn next(self) -> Self {
        match self {
            Self::Off => Self::Split,
            Self::Split => Self::Flicker,
            Self::Flicker => Self::Off,
        }
    }
}

/// What the user chooses about a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choices {
    /// How the scenes are shown.
    pub mode: Mode,
    /// The second scene's settings; of them only what [`Self::second_settings`] names counts.
    pub second: RendererSettings,
    /// Where the divider is: a fraction of the window's width.
    pub divider: f64,
}

impl Choices {
    /// No comparison yet; the first one will be with `strategy`, or with one that the first scene does
    /// not use.
    pub fn new(first: &RendererSettings, strategy: Option<Strategy>) -> Self {
        let other = Strategy::ALL.into_iter().find(|strategy| *strategy != first.strategy);
        let strategy = strategy.or(other).unwrap_or_default();
        let second = RendererSettings { strategy, ..*first };
        Self { mode: Mode::Off, second, divider: 0.5 }
    }

    /// These choices with another mode. A comparison that begins is of strategies: the second scene
    /// starts with all other settings as the first one has them.
    pub fn with_mode(mut self, mode: Mode, first: &RendererSettings) -> Self {
        if self.mode == Mode::Off {
            self.second = RendererSettings { strategy: self.second.strategy, ..*first };
        }
        Self { mode, ..self }
    }

    /// The settings of the second scene: strategy, visible ground, cache and texel size of its own, all else as the
    /// first scene has it, so that nothing else is compared.
    pub fn second_settings(&self, first: &RendererSettings) -> RendererSettings {
        let own = &self.second;
        let settings = RendererSettings {
            strategy: own.strategy,
            visibility: own.visibility,
            cache_columns: own.cache_columns,
            cache_rows: own.cache_rows,
            max_tiles: own.max_tiles,
            texel_px: own.texel_px,
            ..*first
        };
        settings.checked()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first() -> RendererSettings {
        RendererSettings { vertical_exaggeration: 3.0, texel_px: 2.0, ..Default::default() }
    }

    #[test]
    fn the_modes_go_round() {
        let names = |mode: Mode| Mode::ALL.into_iter().find(|(other, _)| *other == mode).unwrap().1;
        let mut mode = Mode::Off;
        let seen: Vec<_> = std::iter::repeat_with(|| {
            mode = mode.next();
            names(mode)
        })
        .take(3)
        .collect();
        assert_eq!(seen, ["split", "flicker", "off"]);
    }

    #[test]
    fn unless_told_otherwise_a_comparison_is_with_another_strategy() {
        for strategy in Strategy::ALL {
            let first = RendererSettings { strategy, ..first() };
            assert_ne!(Choices::new(&first, None).second.strategy, strategy);
            assert_eq!(Choices::new(&first, Some(strategy)).second.strategy, strategy);
        }
    }

    #[test]
    fn the_second_scene_has_few_settings_of_its_own() {
        let mut choices = Choices::new(&first(), None).with_mode(Mode::Split, &first());
        choices.second.texel_px = 4.0;
        choices.second.cache_columns = 8;
        choices.second.vertical_exaggeration = 9.0;
        let changed = RendererSettings { wireframe: true, ..first() };
        let second = choices.second_settings(&changed);
        assert_eq!(
            second,
            RendererSettings {
                strategy: choices.second.strategy,
                texel_px: 4.0,
                cache_columns: 8,
                ..changed
            }
        );
    }

    #[test]
    fn a_comparison_begins_with_the_first_scenes_settings() {
        let choices = Choices::new(&RendererSettings::default(), None);
        let begun = choices.with_mode(Mode::Flicker, &first());
        assert_eq!((begun.mode, begun.second.texel_px), (Mode::Flicker, 2.0));
        let changed = RendererSettings { texel_px: 5.0, ..first() };
        assert_eq!(begun.with_mode(Mode::Split, &changed).second.texel_px, 2.0);
    }
}

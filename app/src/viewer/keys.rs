//! Which key does what.

use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey};

use super::camera_controls::HeldDirections;

/// Something a key or a button of the panel does once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Show or hide the panel.
    TogglePanel,
    /// Freeze the selection of tiles, or let it go on.
    ToggleFreeze,
    /// Show the tiles' borders.
    ToggleBorders,
    /// Show the tiles' levels.
    ToggleLevels,
    /// Show the mesh.
    ToggleWireframe,
    /// Go to where the whole area can be seen.
    GoHome,
    /// Turn north up.
    GoNorthUp,
    /// Write a picture.
    TakeScreenshot,
    /// Begin or end to record a flight.
    ToggleRecording,
    /// Begin or end to play the flight.
    TogglePlaying,
    /// Compare two scenes in another way, or no longer.
    NextComparison,
    /// Show the second scene alone, or no longer.
    ShowSecondAlone(bool),
    /// Fill the screen, or not.
    ToggleFullscreen,
    /// Leave.
    Quit,
}

/// What the help of the panel says: keys and what they do.
pub const HELP: [(&str, &str); 19] = [
    ("left drag", "move the ground"),
    ("wheel", "towards the cursor and back"),
    ("right drag, Ctrl + drag", "turn and tilt about the cursor"),
    ("middle drag", "look round"),
    ("W A S D, arrows", "fly level (Shift: faster)"),
    ("Q E, Page Up/Down", "down and up"),
    ("Home", "the whole area"),
    ("N", "north up"),
    ("H, F1", "this panel"),
    ("F", "freeze the selection"),
    ("B, L, X", "borders, levels, wireframe"),
    ("C", "compare two: split, flicker, off"),
    ("V, held", "B of the two alone"),
    ("F12", "screenshot"),
    ("R", "record a flight"),
    ("P", "play it"),
    ("F11", "full screen"),
    ("Esc", "quit"),
    ("Ctrl with + - 0", "size of the panel"),
];

/// The action of a key that went down; keys that hold a direction have none.
pub fn action(key: &Key, code: &PhysicalKey) -> Option<Action> {
    let mut probe = HeldDirections::default();
    if hold(&mut probe, code, true) {
        return None;
    }
    match key {
        Key::Named(named) => named_action(*named),
        Key::Character(text) => letter_action(&text.to_lowercase()),
        _ => None,
    }
}

/// The action of a key that went up.
pub fn release(key: &Key) -> Option<Action> {
    let Key::Character(text) = key else { return None };
    (text.to_lowercase() == "v").then_some(Action::ShowSecondAlone(false))
}

fn named_action(key: NamedKey) -> Option<Action> {
    Some(match key {
        NamedKey::F1 => Action::TogglePanel,
        NamedKey::F11 => Action::ToggleFullscreen,
        NamedKey::F12 => Action::TakeScreenshot,
        NamedKey::Home => Action::GoHome,
        NamedKey::Escape => Action::Quit,
        _ => return None,
    })
}

fn letter_action(letter: &str) -> Option<Action> {
    Some(match letter {
        "h" => Action::TogglePanel,
        "f" => Action::ToggleFreeze,
        "b" => Action::ToggleBorders,
        "l" => Action::ToggleLevels,
        "x" => Action::ToggleWireframe,
        "n" => Action::GoNorthUp,
        "r" => Action::ToggleRecording,
        "p" => Action::TogglePlaying,
        "c" => Action::NextComparison,
        "v" => Action::ShowSecondAlone(true),
        _ => return None,
    })
}

/// Notes that a key which holds a direction went down or up. Such keys go by their place on the
/// keyboard, whatever the layout. Returns whether it is such a key.
pub fn hold(held: &mut HeldDirections, code: &PhysicalKey, down: bool) -> bool {
    let PhysicalKey::Code(code) = code else { return false };
    let direction = match code {
        KeyCode::KeyW | KeyCode::ArrowUp => &mut held.forward,
        KeyCode::KeyS | KeyCode::ArrowDown => &mut held.backward,
        KeyCode::KeyA | KeyCode::ArrowLeft => &mut held.left,
        KeyCode::KeyD | KeyCode::ArrowRight => &mut held.right,
        KeyCode::KeyE | KeyCode::PageUp => &mut held.up,
        KeyCode::KeyQ | KeyCode::PageDown => &mut held.down,
        KeyCode::ShiftLeft | KeyCode::ShiftRight => &mut held.fast,
        _ => return false,
    };
    *direction = down;
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_act_in_either_case_and_directions_do_not() {
        let letter = |text: &str| Key::Character(text.into());
        assert_eq!(
            action(&letter("F"), &PhysicalKey::Code(KeyCode::KeyF)),
            Some(Action::ToggleFreeze)
        );
        assert_eq!(
            action(&letter("f"), &PhysicalKey::Code(KeyCode::KeyF)),
            Some(Action::ToggleFreeze)
        );
        assert_eq!(action(&letter("r"), &PhysicalKey::Code(KeyCode::KeyS)), None);
    }

    #[test]
    fn only_the_second_scene_alone_ends_with_its_key() {
        let letter = |text: &str| Key::Character(text.into());
        let down = action(&letter("v"), &PhysicalKey::Code(KeyCode::KeyV));
        assert_eq!(down, Some(Action::ShowSecondAlone(true)));
        assert_eq!(release(&letter("V")), Some(Action::ShowSecondAlone(false)));
        assert_eq!(release(&letter("c")), None);
    }

    #[test]
    fn a_direction_is_held_until_its_key_goes_up() {
        let mut held = HeldDirections::default();
        assert!(hold(&mut held, &PhysicalKey::Code(KeyCode::ArrowUp), true));
        assert!(held.forward && held.is_any());
        hold(&mut held, &PhysicalKey::Code(KeyCode::ArrowUp), false);
        assert_eq!(held, HeldDirections::default());
        assert!(!hold(&mut held, &PhysicalKey::Code(KeyCode::KeyB), true));
    }
}

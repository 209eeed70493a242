//! Whether there is a display for a window.

/// The display a window would open on, in words; `None` where there is none.
pub fn display() -> Option<String> {
    if cfg!(any(target_os = "windows", target_os = "macos")) {
        return Some("the desktop".to_owned());
    }
    let variable = |name| std::env::var(name).ok();
    display_from(variable("WAYLAND_DISPLAY"), variable("DISPLAY"))
}

fn display_from(wayland: Option<String>, x11: Option<String>) -> Option<String> {
    let named = |name: Option<String>| name.filter(|name| !name.is_empty());
    named(wayland)
        .map(|name| format!("{name} (Wayland)"))
        .or_else(|| named(x11).map(|name| format!("{name} (X11)")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wayland_goes_before_x11_and_empty_names_are_none() {
        let name = |text: &str| Some(text.to_owned());
        assert_eq!(display_from(name("wayland-0"), name(":0")), name("wayland-0 (Wayland)"));
        assert_eq!(display_from(name(""), name(":0")), name(":0 (X11)"));
        assert_eq!(display_from(None, name("")), None);
    }
}

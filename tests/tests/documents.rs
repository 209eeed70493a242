//! What the documents say is there, is there.

use std::path::{Path, PathBuf};

/// The repository's root folder.
fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every document and its text.
fn documents() -> anyhow::Result<Vec<(PathBuf, String)>> {
    let mut found = Vec::new();
    for folder in [root(), root().join("data"), root().join("docs")] {
        let Ok(entries) = std::fs::read_dir(folder) else { continue };
        for entry in entries {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == "md") {
                found.push((path.clone(), std::fs::read_to_string(&path)?));
            }
        }
    }
    Ok(found)
}

#[test]
fn links_lead_to_files() -> anyhow::Result<()> {
    let mut broken = Vec::new();
    for (path, text) in documents()? {
        let folder = path.parent().unwrap_or(Path::new("."));
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = target.split('#').next().unwrap_or_default();
            let is_local = !file.is_empty() && !file.contains("://");
            if is_local && !folder.join(file).exists() {
                broken.push(format!("{}: {target}", path.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
    Ok(())
}

#[test]
fn make_targets_that_are_named_exist() -> anyhow::Result<()> {
    let makefile = std::fs::read_to_string(root().join("Makefile"))?;
    let has = |target: &str| makefile.lines().any(|line| line.starts_with(&format!("{target}:")));
    let mut named = 0;
    for (path, text) in documents()? {
        let commands = text.split('`').skip(1).step_by(2).chain(text.lines());
        for command in commands.filter_map(|line| line.trim().strip_prefix("make ")) {
            let target = command.split_whitespace().next().unwrap_or_default();
            assert!(has(target), "{}: no target {target} in the Makefile", path.display());
            named += 1;
        }
    }
    assert!(named >= 2, "the README names its two commands");
    Ok(())
}

#[test]
fn benchmarks_and_tests_that_are_named_exist() -> anyhow::Result<()> {
    let mut named = 0;
    for (path, text) in documents()? {
        for command in text.split('`').filter(|code| code.starts_with("cargo ")) {
            let words: Vec<&str> = command.split_whitespace().collect();
            let after = |flag: &str| words.iter().skip_while(|word| **word != flag).nth(1).copied();
            let folder = match after("-p") {
                Some("terrain-tests") => "tests",
                Some(package) => package,
                None => continue,
            };
            for (flag, kind) in [("--bench", "benches"), ("--test", "tests")] {
                let Some(name) = after(flag) else { continue };
                let place = root().join(folder).join(kind);
                let exists = place.join(format!("{name}.rs")).exists() || place.join(name).is_dir();
                assert!(exists, "{}: {command}", path.display());
                named += 1;
            }
        }
    }
    assert!(named >= 5, "the README says how to repeat what was measured");
    Ok(())
}

#[test]
fn commands_that_are_named_exist() -> anyhow::Result<()> {
    let known = [
        "prepare",
        "info",
        "fly",
        "render",
        "compare",
        "precision",
        "limit",
        "doctor",
        "synth",
        "tin",
    ];
    for (path, text) in documents()? {
        let commands = text.split('`').skip(1).step_by(2).chain(text.lines());
        for command in commands.filter_map(|line| line.trim().strip_prefix("terrain ")) {
            let name = command.split_whitespace().next().unwrap_or_default();
            let is_command = name.chars().all(|letter| letter.is_ascii_lowercase());
            let is_known = known.contains(&name);
            assert!(!is_command || is_known, "{}: terrain {command}", path.display());
        }
    }
    Ok(())
}

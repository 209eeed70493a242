//! Rules that the compiler does not know: where wgpu may be named, what may stand in the sources,
//! and that the program is built from Rust alone.

mod workspace;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::Context;
use serde_json::Value;
use workspace::{elements, text};

/// The only places of the library and the command that may name wgpu.
const WGPU_PLACES: [&str; 4] = [
    "terrain-core/src/gpu/",
    "terrain-core/src/method/",
    "terrain-core/src/terrain_renderer",
    "app/src/viewer/",
];

#[test]
fn wgpu_is_named_only_where_gpu_work_is_done() -> anyhow::Result<()> {
    let strangers: Vec<String> = lines_of_sources(&["terrain-core/src", "app/src"], "rs")?
        .into_iter()
        .filter(|line| !WGPU_PLACES.iter().any(|place| line.file.starts_with(place)))
        .filter(|line| !is_comment(&line.text) && line.text.contains("wgpu::"))
        .map(|line| line.to_string())
        .collect();
    assert!(strangers.is_empty(), "wgpu outside {WGPU_PLACES:?}: {strangers:#?}");
    Ok(())
}

#[test]
fn sources_hold_nothing_unfinished() -> anyhow::Result<()> {
    // Spelt apart, so that this file does not find itself.
    let words =
        [concat!("TO", "DO"), concat!("FIX", "ME"), concat!("todo", "!("), "unimplemented!("];
    let mut lines = lines_of_sources(&["terrain-core", "app", "tests/src"], "rs")?;
    lines.extend(lines_of_sources(&["shaders"], "wgsl")?);
    let found: Vec<String> = lines
        .iter()
        .filter(|line| words.iter().any(|word| line.text.contains(word)))
        .map(ToString::to_string)
        .collect();
    assert!(found.is_empty(), "unfinished: {found:#?}");
    Ok(())
}

/// Crates that can build C, and the feature without which they do not.
const C_ONLY_WITH_FEATURE: [(&str, &str); 1] = [("wayland-backend", "log")];

#[test]
fn the_program_builds_no_c() -> anyhow::Result<()> {
    let metadata = workspace::metadata()?;
    let nodes: BTreeMap<&str, &Value> = elements(&metadata["resolve"], "nodes")
        .iter()
        .map(|node| (text(node, "id"), node))
        .collect();
    let names: BTreeMap<&str, &str> = elements(&metadata, "packages")
        .iter()
        .map(|package| (text(package, "id"), text(package, "name")))
        .collect();
    let app = names.iter().find(|(_, name)| **name == "app").context("no package app")?.0;
    let mut offenders = Vec::new();
    for id in reachable(app, &nodes) {
        let node = nodes[id];
        let name = names[id];
        let features: Vec<&str> =
            elements(node, "features").iter().filter_map(Value::as_str).collect();
        let harmless = C_ONLY_WITH_FEATURE
            .iter()
            .any(|(krate, feature)| *krate == name && !features.contains(feature));
        let tools = runtime_dependencies(node).map(|id| names[id]);
        if tools.into_iter().any(|tool| matches!(tool, "cc" | "cmake" | "nasm-rs")) && !harmless {
            offenders.push(name);
        }
    }
    assert!(offenders.is_empty(), "these build C: {offenders:?}");
    Ok(())
}

/// Every package that the program needs on Linux to build or to run, tests left out.
fn reachable<'a>(from: &'a str, nodes: &BTreeMap<&'a str, &'a Value>) -> BTreeSet<&'a str> {
    let mut found = BTreeSet::from([from]);
    let mut open = vec![from];
    while let Some(id) = open.pop() {
        for next in nodes.get(id).into_iter().flat_map(|node| runtime_dependencies(node)) {
            if found.insert(next) {
                open.push(next);
            }
        }
    }
    found
}

/// A package's dependencies for building and running on Linux.
fn runtime_dependencies(node: &Value) -> impl Iterator<Item = &str> {
    let elsewhere =
        ["windows", "macos", "apple", "wasm", "android", "web", "emscripten", "ios", "haiku"];
    elements(node, "deps").iter().filter_map(move |dependency| {
        let needed = elements(dependency, "dep_kinds").iter().any(|kind| {
            let target = kind["target"].as_str().unwrap_or("linux");
            let foreign = elsewhere.iter().any(|word| target.contains(word));
            kind["kind"] != "dev" && (!foreign || target.contains("linux"))
        });
        needed.then(|| text(dependency, "pkg"))
    })
}

/// A line of a source file, with its place.
struct SourceLine {
    /// Relative to the repository's root, with forward slashes.
    file: String,
    number: usize,
    text: String,
}

impl std::fmt::Display for SourceLine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}: {}", self.file, self.number, self.text.trim())
    }
}

fn is_comment(line: &str) -> bool {
    line.trim_start().starts_with("//")
}

/// Every line of the files with this extension below the folders that exist.
fn lines_of_sources(folders: &[&str], extension: &str) -> anyhow::Result<Vec<SourceLine>> {
    let root = workspace::root();
    let mut lines = Vec::new();
    for folder in folders.iter().map(|folder| root.join(folder)).filter(|folder| folder.is_dir()) {
        for path in files_below(&folder)? {
            if path.extension().is_none_or(|found| found != extension) {
                continue;
            }
            let file = path.strip_prefix(&root)?.to_string_lossy().replace('\\', "/");
            let content = std::fs::read_to_string(&path)?;
            lines.extend(content.lines().enumerate().map(|(index, text)| SourceLine {
                file: file.clone(),
                number: index + 1,
                text: text.to_owned(),
            }));
        }
    }
    Ok(lines)
}

fn files_below(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            files.extend(files_below(&entry.path())?);
        } else {
            files.push(entry.path());
        }
    }
    Ok(files)
}

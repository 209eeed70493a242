//! `terrain doctor`: what this machine can do, and what would be left out and why.

use std::fmt::Write;

use anyhow::bail;
use clap::Args;
use serde::Serialize;
use terrain_core::gpu::{AdapterChoice, AdapterReport, survey_adapters};

use crate::{display, output};

/// What to tell.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  terrain doctor --json --adapter vulkan")]
pub struct DoctorArgs {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Everything the doctor finds.
#[derive(Debug, Serialize)]
struct Findings {
    /// The choice that was made on the command line.
    adapter_choice: String,
    /// All adapters, the best first.
    adapters: Vec<AdapterReport>,
    /// Where a window would open; null without a display.
    display: Option<String>,
    /// What would be left out, and why.
    left_out: Vec<String>,
}

/// Prints the findings. Fails, after printing, where no adapter meets the choice.
pub fn run(args: &DoctorArgs, choice: &AdapterChoice) -> anyhow::Result<()> {
    let adapters = survey_adapters(choice);
    let display = display::display();
    let left_out = left_out(&adapters, display.as_deref());
    let findings = Findings { adapter_choice: choice.to_string(), adapters, display, left_out };
    if args.json {
        output::print(&(serde_json::to_string_pretty(&findings)? + "\n"))?;
    } else {
        output::print(&page(&findings)?)?;
    }
    if !findings.adapters.iter().any(|adapter| adapter.chosen) {
        bail!(
            "no graphics adapter for `{choice}` (see above for those there are; on Debian and \
             Ubuntu the package mesa-vulkan-drivers has a software one)"
        );
    }
    Ok(())
}

/// What would be left out on this machine, and why.
fn left_out(adapters: &[AdapterReport], display: Option<&str>) -> Vec<String> {
    let mut left_out = Vec::new();
    match adapters.iter().find(|adapter| adapter.chosen) {
        None => left_out.push("everything that draws, GPU tests too: no adapter".to_owned()),
        Some(adapter) => left_out.extend(
            adapter
                .capabilities
                .iter()
                .filter(|capability| !capability.available)
                .map(|capability| format!("no {}: {}", capability.name, capability.without)),
        ),
    }
    if display.is_none() {
        left_out.push(
            "the window: neither WAYLAND_DISPLAY nor DISPLAY is set; flights go to PNG files"
                .to_owned(),
        );
    }
    left_out
}

/// The findings as a page for people.
fn page(findings: &Findings) -> Result<String, std::fmt::Error> {
    let mut page = String::new();
    writeln!(page, "display   {}", findings.display.as_deref().unwrap_or("none"))?;
    for adapter in &findings.adapters {
        let mark = if adapter.chosen { "chosen by" } else { "not chosen by" };
        writeln!(page, "\nadapter   {}", adapter.name)?;
        writeln!(page, "          {}, {}, {}", adapter.backend, adapter.kind, adapter.driver)?;
        writeln!(page, "          {mark} --adapter {}", findings.adapter_choice)?;
        for capability in &adapter.capabilities {
            let has = if capability.available { "yes" } else { "no" };
            writeln!(page, "          {has:<5}{}", capability.name)?;
        }
        for limit in &adapter.limits {
            writeln!(page, "          {:<24}{:>12}", limit.name, limit.value)?;
        }
    }
    writeln!(page, "\nleft out")?;
    for item in &findings.left_out {
        writeln!(page, "          {item}")?;
    }
    if findings.left_out.is_empty() {
        writeln!(page, "          nothing")?;
    }
    Ok(page)
}

#[cfg(test)]
mod tests {
    use terrain_core::gpu::CapabilityReport;

    use super::*;

    fn adapter(chosen: bool, available: bool) -> AdapterReport {
        AdapterReport {
            name: "Sample".to_owned(),
            backend: "vulkan".to_owned(),
            kind: "software".to_owned(),
            driver: "sample 1".to_owned(),
            chosen,
            capabilities: vec![CapabilityReport { name: "clocks", available, without: "no times" }],
            limits: Vec::new(),
        }
    }

    #[test]
    fn only_what_the_chosen_adapter_lacks_is_left_out() {
        let adapters = [adapter(true, true), adapter(false, false)];
        assert_eq!(left_out(&adapters, Some(":0")), Vec::<String>::new());
        let lacking = left_out(&[adapter(true, false)], Some(":0"));
        assert_eq!(lacking, ["no clocks: no times"]);
    }

    #[test]
    fn without_adapter_or_display_both_are_said() {
        let left_out = left_out(&[adapter(false, true)], None);
        assert_eq!(left_out.len(), 2);
        assert!(left_out[0].contains("no adapter") && left_out[1].contains("DISPLAY"));
    }
}

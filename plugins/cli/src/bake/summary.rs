//! What a bake made, as a table.

use std::fmt::Write;

use farlight_baker::{Outcome, Report};

/// Most primitives without a lightmap that are named.
const NAMED: usize = 10;

/// The text for the user.
pub(super) fn of(report: &Report) -> String {
    let manifest = &report.manifest;
    let path = report.manifest_path.display();
    let seconds = report.time.as_secs_f64();
    let mut text = String::new();
    // A String takes everything.
    let mut line = |content: String| _ = writeln!(text, "{content}");
    if report.outcome == Outcome::Unchanged {
        line(format!("{path}: nothing changed ({seconds:.2} s)"));
        return text;
    }
    line(format!(
        "{path}: {} primitives on {} of {size} x {size}, {:.3} texels a metre, {:.0} % covered; {seconds:.1} s",
        manifest.receivers.len(),
        count(manifest.pages as usize, "page"),
        manifest.settings.texels_per_metre,
        report.coverage * 100.0,
        size = manifest.page_size,
    ));
    for volume in &manifest.volumes {
        let [x, y, z] = volume.resolution;
        line(format!("  probes: {x} x {y} x {z}"));
    }
    let width = manifest.scenarios.iter().map(|s| s.name.chars().count()).max().unwrap_or(0).max(8);
    line(format!("  {:width$}  {:>6}  {:>6}  {:>8}", "scenario", "lights", "rays", "noise"));
    for scenario in &manifest.scenarios {
        let kept = if report.unchanged.contains(&scenario.name) { "  (as it was)" } else { "" };
        line(format!(
            "  {:width$}  {:>6}  {:>6}  {:>6.2} %{kept}",
            scenario.name,
            scenario.lights.len(),
            scenario.samples,
            scenario.relative_error * 100.0,
        ));
    }
    if manifest.settings.denoise {
        line("  noise: about half of the texels are off by less, before filtering".to_owned());
    }
    let stages: Vec<String> = report
        .stages
        .iter()
        .filter(|(_, time)| time.as_millis() >= 50)
        .map(|(stage, time)| format!("{stage} {:.1}", time.as_secs_f64()))
        .collect();
    if !stages.is_empty() {
        line(format!("  seconds: {}", stages.join(", ")));
    }
    if !manifest.left_out.is_empty() {
        line(format!("  {} without a lightmap:", count(manifest.left_out.len(), "primitive")));
        for left in manifest.left_out.iter().take(NAMED) {
            line(format!(
                "    node {} {:?}, primitive {}: {}",
                left.node, left.name, left.primitive, left.reason
            ));
        }
        if let Some(more) = manifest.left_out.len().checked_sub(NAMED).filter(|more| *more > 0) {
            line(format!("    and {more} more (see the manifest)"));
        }
    }
    text
}

fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

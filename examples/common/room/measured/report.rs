//! What was measured: a JSON file and a table.

use std::{collections::BTreeMap, fmt::Write, path::Path};

use serde::Serialize;

use super::{
    network::Network,
    stages::{STAGES, Stage},
    stats::{Spread, StepTimes, quantile},
};

/// How the numbers are meant; written into the report.
const DEFINITIONS: &[(&str, &str)] = &[
    (
        "step",
        "the lamp's intensity doubled between two frames, after the lighting had settled; time counts from the frame that doubled it",
    ),
    (
        "receivers",
        "texels whose converged value changes by at least 10 % of the largest change (sum of the channels)",
    ),
    (
        "step_first_texel_ms",
        "until the frame that shows the first texels that know of the change was submitted",
    ),
    (
        "step_90_ms",
        "from here on the median receiver's shown value has changed, since the step, by 90 % of what its converged value changes by",
    ),
    (
        "step_90_of_receivers_ms",
        "from here on 90 % of the receivers have done 90 % of their own change",
    ),
    ("step_90_of_sum_ms", "from here on 90 % of the change summed over all receivers is done"),
    (
        "error",
        "relative error of a texel that the frame shows: absolute differences of the channels, summed, over the sum of the reference's channels; the reference is path traced for the light of that very frame; texels below 1 % of the brightest are left out; median and p95 are over texels and instants together",
    ),
    (
        "texels",
        "those whose centres lie on a surface in the open: not buried under or inside of something",
    ),
    (
        "system_cpu_ms",
        "CPU time of the threads that run this project's systems, a frame, both worlds together; the solver's thread is not part of it",
    ),
    ("system_wall_ms", "the same in wall time"),
    (
        "first_light_ms",
        "from the frame that submitted the first part of the loaded scene until the frame that shows the first lit texels was submitted",
    ),
    (
        "stages_ms",
        "while the lamp moves: extract and upload are wall times of this project's systems a frame; the others an update: send until the network had taken the changes over, solve the solver's work, encode for the network (or, without one, for the textures), transfer on the network there and back, decode for the textures; whole is from the frame that submitted a change until the frame that shows its first texels was submitted, with everything that waits for a frame or for a piece of solving in between",
    ),
    (
        "network",
        "bytes are those of messages, without what QUIC, UDP and IP add; still is watched after the lighting of a scene at rest has converged",
    ),
];

/// The report. Keys carry their units.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// Name and driver of the graphics adapter.
    pub adapter: String,
    /// Logical processors.
    pub processors: usize,
    /// Columns and rows of the pictures.
    pub picture_px: [u32; 2],
    /// Edge of a lightmap page.
    pub lightmap_edge_texels: u32,
    /// Lightmap pages.
    pub lightmap_pages: usize,
    /// Texels whose centres lie on a surface.
    pub lightmap_lit_texels: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Paths a texel of the references.
    pub reference_paths: u32,
    /// Median standard error of the references, relative: so much of the errors below is theirs.
    pub reference_noise: f32,
    /// Speed of the lamp.
    pub light_speed_m_per_s: f32,
    /// Frames that were measured.
    pub frames: usize,
    /// Frames a second that were aimed for.
    pub paced_frames_per_s: f32,
    /// Time from frame to frame.
    pub frame_ms: Percentiles,
    /// From the first snapshot of the loaded scene until the first texel was written.
    pub first_light_ms: f32,
    /// Lighting updates while the lamp moved.
    pub updates: usize,
    /// Lighting updates a second while the lamp moved.
    pub updates_per_s: f32,
    /// Steps that were made.
    pub steps: usize,
    /// Steps of which not even the median receiver arrived while they were watched.
    pub steps_not_arrived: usize,
    /// For how long a step was watched.
    pub watched_s: f32,
    /// Receivers of a step.
    pub step_receivers: Option<Spread>,
    /// See `definitions`.
    pub step_first_texel_ms: Option<Spread>,
    /// See `definitions`.
    pub step_90_ms: Option<Spread>,
    /// See `definitions`.
    pub step_90_of_receivers_ms: Option<Spread>,
    /// See `definitions`.
    pub step_90_of_sum_ms: Option<Spread>,
    /// Each step.
    pub step_runs: Vec<StepTimes>,
    /// While the lamp moves.
    pub error_moving: ErrorSummary,
    /// After it stopped; a full run waits for 2 s.
    pub error_after_stop: ErrorSummary,
    /// How long after.
    pub after_stop_s: f32,
    /// Before the steps, at rest.
    pub error_before_step: ErrorSummary,
    /// The lighting of `indirect.png`.
    pub error_picture: ErrorSummary,
    /// See `definitions`.
    pub stages_ms: BTreeMap<&'static str, Stage>,
    /// See `definitions`; `None` where the light is solved in this process.
    pub network: Option<Network>,
    /// See `definitions`.
    pub system_cpu_ms: Percentiles,
    /// See `definitions`.
    pub system_wall_ms: Percentiles,
    /// What the keys mean.
    pub definitions: BTreeMap<&'static str, &'static str>,
}

/// Relative errors (0.05 is 5 %) over texels and instants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorSummary {
    /// Half of the texels are better.
    pub median: f32,
    /// 95 % of the texels are better.
    pub p95: f32,
    /// Median of the worst instant.
    pub worst_instant_median: f32,
    /// How many instants were compared.
    pub instants: usize,
}

/// Percentiles of something measured every frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Percentiles {
    /// Half of the frames are below.
    pub p50: f32,
    /// 95 % are below.
    pub p95: f32,
    /// 99 % are below.
    pub p99: f32,
}

impl ErrorSummary {
    /// Of the errors at several instants.
    pub fn of(instants: &[Vec<f32>]) -> Self {
        let all: Vec<f32> = instants.iter().flatten().copied().collect();
        let medians: Vec<f32> = instants.iter().filter_map(|i| quantile(i, 0.5)).collect();
        Self {
            median: quantile(&all, 0.5).unwrap_or(f32::NAN),
            p95: quantile(&all, 0.95).unwrap_or(f32::NAN),
            worst_instant_median: quantile(&medians, 1.0).unwrap_or(f32::NAN),
            instants: instants.len(),
        }
    }
}

impl Percentiles {
    /// Of one value a frame.
    pub fn of(values: &[f32]) -> Self {
        let at = |q| quantile(values, q).unwrap_or(f32::NAN);
        Self { p50: at(0.5), p95: at(0.95), p99: at(0.99) }
    }
}

impl Report {
    /// Writes `report.json`.
    pub fn save(&self, path: &Path) -> Result<(), String> {
        let report = Self { definitions: DEFINITIONS.iter().copied().collect(), ..self.clone() };
        let text = serde_json::to_string_pretty(&report).map_err(|e| e.to_string())?;
        std::fs::write(path, text + "\n").map_err(|e| format!("{}: {e}", path.display()))
    }

    /// The numbers for a person.
    pub fn table(&self) -> String {
        let mut out = String::new();
        let mut row = |name: &str, value: String| {
            let _ = writeln!(out, "  {name:<44} {value}");
        };
        let spread = |s: Option<Spread>, digits: usize| {
            s.map_or("did not arrive".into(), |s| {
                format!("{:.digits$} / {:.digits$} / {:.digits$} ms", s.min, s.median, s.max)
            })
        };
        let error = |e: ErrorSummary| {
            let [median, p95] = [e.median, e.p95].map(|v| v * 100.0);
            format!("{median:.1} % / {p95:.1} %   ({} instants)", e.instants)
        };
        let percentiles = |p: Percentiles| format!("{:.3} / {:.3} / {:.3}", p.p50, p.p95, p.p99);
        row("adapter", self.adapter.clone());
        row("picture", format!("{} x {} pixels", self.picture_px[0], self.picture_px[1]));
        row(
            "lightmap",
            format!(
                "{} page of {} x {} texels, {} lit",
                self.lightmap_pages,
                self.lightmap_edge_texels,
                self.lightmap_edge_texels,
                self.lightmap_lit_texels
            ),
        );
        row("frames measured", self.frames.to_string());
        row("time a frame, p50 / p95 / p99", format!("{} ms", percentiles(self.frame_ms)));
        row("first lit frame after the scene was sent", format!("{:.0} ms", self.first_light_ms));
        row(
            "lighting updates while the lamp moves",
            format!("{:.1} a second at {} m/s", self.updates_per_s, self.light_speed_m_per_s),
        );
        row(
            "steps (intensity doubled)",
            format!("{}, {} not arrived", self.steps, self.steps_not_arrived),
        );
        row("  first texel, min / median / max", spread(self.step_first_texel_ms, 0));
        row("  90 % at the median receiver", spread(self.step_90_ms, 0));
        row("  90 % at 90 % of the receivers", spread(self.step_90_of_receivers_ms, 0));
        row("  90 % of the whole change", spread(self.step_90_of_sum_ms, 0));
        row("error while moving, median / p95", error(self.error_moving));
        row(
            &format!("error {:.1} s after stopping", self.after_stop_s),
            error(self.error_after_stop),
        );
        row("error at rest, before steps", error(self.error_before_step));
        row("error of indirect.png", error(self.error_picture));
        row(
            "noise of the references, median",
            format!("{:.1} % at {} paths", self.reference_noise * 100.0, self.reference_paths),
        );
        row(
            "our systems, CPU time, p50 / p95 / p99",
            format!("{} ms", percentiles(self.system_cpu_ms)),
        );
        row("our systems, wall time", format!("{} ms", percentiles(self.system_wall_ms)));
        for name in STAGES {
            let Some(stage) = self.stages_ms.get(name).filter(|stage| stage.samples > 0) else {
                continue;
            };
            let row_name = format!("latency while moving: {name}, p50 / p90");
            row(&row_name, format!("{:.2} / {:.2} ms", stage.p50, stage.p90));
        }
        if let Some(network) = &self.network {
            network.rows(&mut row);
        }
        out
    }
}

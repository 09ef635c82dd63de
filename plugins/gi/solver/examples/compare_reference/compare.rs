//! How far results are from a reference, as relative errors and in standard errors.

use std::fmt;

use serde::Deserialize;

/// Samples closer than this (in metres) to another surface are left out: a reference with other
/// ray offsets sees something else there.
pub(crate) const MIN_CLEARANCE: f32 = 0.02;

/// Channels below this fraction of the largest of their kind are left out of relative errors.
pub(crate) const MIN_FRACTION: f64 = 0.01;

/// A reference: converged values with standard errors.
#[derive(Deserialize)]
pub(crate) struct Reference {
    /// Points on surfaces.
    pub(crate) surface_samples: Vec<Sample>,
    /// Points in the air.
    pub(crate) probes: Vec<ReferenceProbe>,
    /// Which lights are seen from where.
    pub(crate) visibility: Vec<Visibility>,
}

/// Irradiance at a point.
#[derive(Deserialize)]
#[expect(non_snake_case, reason = "the names of the reference files")]
pub(crate) struct Sample {
    pub(crate) position: [f32; 3],
    pub(crate) normal: [f32; 3],
    pub(crate) E_direct: [f64; 3],
    pub(crate) E_indirect: [f64; 3],
    pub(crate) E_indirect_se: [f64; 3],
    pub(crate) E_indirect_one_bounce: [f64; 3],
    pub(crate) E_indirect_one_bounce_se: [f64; 3],
    /// Distance to the nearest other surface in sight, in metres.
    pub(crate) clearance_m: f32,
}

/// Incident indirect radiance at a probe.
#[derive(Deserialize)]
pub(crate) struct ReferenceProbe {
    pub(crate) position: [f32; 3],
    pub(crate) sh: [[f64; 3]; 9],
    pub(crate) sh_se: [[f64; 3]; 9],
}

/// Whether a point sees a light.
#[derive(Deserialize)]
pub(crate) struct Visibility {
    pub(crate) point: [f32; 3],
    pub(crate) light: usize,
    pub(crate) visible: u8,
    /// 0 within 1 cm of a shadow edge.
    pub(crate) robust_m: f32,
}

/// What `farlight bake` writes.
#[derive(Deserialize)]
pub(crate) struct Outcome {
    pub(crate) surface: Vec<Surface>,
    pub(crate) probes: Vec<Probe>,
    pub(crate) visibility: Vec<u8>,
}

/// Irradiance at a point.
#[derive(Deserialize)]
pub(crate) struct Surface {
    pub(crate) direct: [f64; 3],
    pub(crate) indirect: [f64; 3],
    pub(crate) indirect_se: [f64; 3],
    pub(crate) indirect_one_bounce: [f64; 3],
    pub(crate) indirect_one_bounce_se: [f64; 3],
}

/// Incident indirect radiance at a probe.
#[derive(Deserialize)]
pub(crate) struct Probe {
    pub(crate) sh: [[f64; 3]; 9],
    pub(crate) sh_se: [[f64; 3]; 9],
}

/// Errors of an estimated quantity.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Errors {
    /// Channels that count.
    pub(crate) channels: usize,
    /// Mean of |x - reference| / reference.
    pub(crate) mean: f64,
    /// Mean of (x - reference) / reference.
    pub(crate) signed: f64,
    /// Largest of |x - reference| / reference.
    pub(crate) worst: f64,
    /// Root mean square of (x - reference) / combined standard error.
    pub(crate) rms_z: f64,
    /// Largest of |x - reference| / combined standard error.
    pub(crate) worst_z: f64,
}

/// One channel: result and reference, both with standard errors.
struct Pair {
    x: f64,
    x_se: f64,
    r: f64,
    r_se: f64,
    /// What the error is relative to.
    scale: f64,
}

impl Errors {
    fn of(pairs: impl Iterator<Item = Pair>) -> Self {
        let mut e = Self::default();
        for p in pairs {
            let relative = (p.x - p.r) / p.scale;
            let z = (p.x - p.r) / p.x_se.hypot(p.r_se);
            e.channels += 1;
            e.mean += relative.abs();
            e.signed += relative;
            e.worst = e.worst.max(relative.abs());
            e.rms_z += z * z;
            e.worst_z = e.worst_z.max(z.abs());
        }
        let n = (e.channels as f64).max(1.0);
        e.mean /= n;
        e.signed /= n;
        e.rms_z = (e.rms_z / n).sqrt();
        e
    }
}

/// Errors of direct light, which is exact on both sides.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DirectErrors {
    /// Channels that are not 0 in the reference.
    pub(crate) lit: usize,
    /// Largest of |x - reference| / reference over them.
    pub(crate) worst: f64,
    /// Channels that are 0 in the reference.
    pub(crate) dark: usize,
    /// Those of them that are not exactly 0 in the result.
    pub(crate) not_dark: usize,
}

/// Agreement of visibility.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct VisibilityErrors {
    /// Entries that count.
    pub(crate) entries: usize,
    /// Those that differ.
    pub(crate) wrong: usize,
    /// Entries that are left out: within 1 cm of a shadow edge.
    pub(crate) at_edges: usize,
}

/// All that is compared.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Report {
    pub(crate) indirect: Errors,
    pub(crate) one_bounce: Errors,
    pub(crate) direct: DirectErrors,
    /// Relative to the l = 0 coefficient of the same probe and channel.
    pub(crate) probes: Errors,
    pub(crate) visibility: VisibilityErrors,
}

impl Report {
    /// Compares results with a reference in the same order.
    ///
    /// # Errors
    /// Where the numbers of entries differ.
    pub(crate) fn new(reference: &Reference, outcome: &Outcome) -> Result<Self, String> {
        for (what, expected, found) in [
            ("surface", reference.surface_samples.len(), outcome.surface.len()),
            ("probes", reference.probes.len(), outcome.probes.len()),
            ("visibility", reference.visibility.len(), outcome.visibility.len()),
        ] {
            if expected != found {
                return Err(format!("{what}: {found} results, but {expected} in the reference"));
            }
        }
        let indirect = irradiance(reference, outcome, |s, o| {
            (s.E_indirect, s.E_indirect_se, o.indirect, o.indirect_se)
        });
        let one_bounce = irradiance(reference, outcome, |s, o| {
            let reference = (s.E_indirect_one_bounce, s.E_indirect_one_bounce_se);
            (reference.0, reference.1, o.indirect_one_bounce, o.indirect_one_bounce_se)
        });
        let probes = reference.probes.iter().zip(&outcome.probes).flat_map(|(r, o)| {
            (0..27).map(move |k| {
                let (i, c) = (k / 3, k % 3);
                Pair {
                    x: o.sh[i][c],
                    x_se: o.sh_se[i][c],
                    r: r.sh[i][c],
                    r_se: r.sh_se[i][c],
                    scale: r.sh[0][c],
                }
            })
        });
        Ok(Self {
            indirect,
            one_bounce,
            direct: direct(reference, outcome),
            probes: Errors::of(probes),
            visibility: visibility(reference, outcome),
        })
    }
}

type Channels = ([f64; 3], [f64; 3], [f64; 3], [f64; 3]);

fn irradiance(
    reference: &Reference,
    outcome: &Outcome,
    pick: impl Fn(&Sample, &Surface) -> Channels,
) -> Errors {
    let rows = || reference.surface_samples.iter().zip(&outcome.surface);
    let largest = rows().flat_map(|(s, o)| pick(s, o).0).fold(0.0, f64::max);
    let pairs = rows().filter(|(s, _)| s.clearance_m >= MIN_CLEARANCE).flat_map(|(s, o)| {
        let (r, r_se, x, x_se) = pick(s, o);
        (0..3).map(move |c| Pair { x: x[c], x_se: x_se[c], r: r[c], r_se: r_se[c], scale: r[c] })
    });
    Errors::of(pairs.filter(|p| p.r >= MIN_FRACTION * largest))
}

fn direct(reference: &Reference, outcome: &Outcome) -> DirectErrors {
    let largest = reference.surface_samples.iter().flat_map(|s| s.E_direct).fold(0.0_f64, f64::max);
    let mut e = DirectErrors::default();
    for (s, o) in reference.surface_samples.iter().zip(&outcome.surface) {
        if s.clearance_m < MIN_CLEARANCE {
            continue;
        }
        for (r, x) in s.E_direct.into_iter().zip(o.direct) {
            if r == 0.0 {
                e.dark += 1;
                e.not_dark += usize::from(x != 0.0);
            } else if r >= MIN_FRACTION * largest {
                e.lit += 1;
                e.worst = e.worst.max((x - r).abs() / r);
            }
        }
    }
    e
}

fn visibility(reference: &Reference, outcome: &Outcome) -> VisibilityErrors {
    let mut e = VisibilityErrors::default();
    for (r, x) in reference.visibility.iter().zip(&outcome.visibility) {
        if r.robust_m == 0.0 {
            e.at_edges += 1;
        } else {
            e.entries += 1;
            e.wrong += usize::from(r.visible != *x);
        }
    }
    e
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "| quantity | channels | mean error | signed | worst | RMS z | worst z |")?;
        writeln!(f, "|---|---|---|---|---|---|---|")?;
        for (name, e) in [
            ("E indirect", &self.indirect),
            ("E one bounce", &self.one_bounce),
            ("probe SH / c0", &self.probes),
        ] {
            writeln!(
                f,
                "| {name} | {} | {:.3} % | {:+.3} % | {:.2} % | {:.3} | {:.2} |",
                e.channels,
                e.mean * 100.0,
                e.signed * 100.0,
                e.worst * 100.0,
                e.rms_z,
                e.worst_z
            )?;
        }
        let (d, v) = (&self.direct, &self.visibility);
        writeln!(
            f,
            "direct: worst error {:.4} % of {} lit channels; {} of {} dark channels are not 0",
            d.worst * 100.0,
            d.lit,
            d.not_dark,
            d.dark
        )?;
        write!(
            f,
            "visibility: {} of {} wrong ({} at shadow edges left out)",
            v.wrong, v.entries, v.at_edges
        )
    }
}

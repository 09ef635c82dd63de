//! What to bake, and how well.

use std::{path::PathBuf, time::Duration};

use farlight_gi_solver::import::ImportLimits;
use glam::Vec3;

use crate::BakeError;

/// The camera exposure, as EV100, for which emissive colours are taken to be chosen: that of the
/// default of `GiSettings::exposure_ref`.
pub const EMISSIVE_EV100: f32 = 9.7;

/// What to bake, and how well.
#[derive(Clone, Debug)]
pub struct BakeOptions {
    /// The scene: a `.glb` or `.gltf` file.
    pub scene: PathBuf,
    /// The folder of the results; made if it is missing.
    pub out: PathBuf,
    /// A file of added lights and scenarios ([`BakeLights`](crate::lights::BakeLights)).
    pub lights: Option<PathBuf>,
    /// How fine lightmaps are.
    pub texels: Texels,
    /// How many rays a texel, or how much time.
    pub effort: Effort,
    /// Most reflections of light; 0 is no limit.
    pub bounces: u32,
    /// Radiance of the sky in cd/m² where a scenario says nothing.
    pub sky: Vec3,
    /// Metres a unit of the scene's file.
    pub scale: f32,
    /// What the numbers of emissive materials mean.
    pub emission: Emission,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Whether pages are written as OpenEXR as well.
    pub exr: bool,
    /// Whether noise is filtered.
    pub denoise: bool,
    /// Where probes go.
    pub probes: Probes,
    /// Which scenarios to bake; empty for all. The others stay if they are up to date.
    pub scenarios: Vec<String>,
    /// Whether nothing that earlier bakes left is used.
    pub force: bool,
    /// After how much work accumulators are saved, so that a killed bake goes on from there.
    pub save_every: Duration,
    /// What the scene's file may ask for.
    pub limits: ImportLimits,
}

/// How fine lightmaps are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Texels {
    /// 16 texels a metre, fewer if they need more than four pages of 1024 x 1024.
    #[default]
    Standard,
    /// So many texels a metre, 0.01 to 1000, on as many pages as they need.
    PerMetre(f32),
    /// As fine as fits on one page with so many texels along an edge: a power of two, 64 to 4096.
    Page(u32),
}

/// How much work a bake may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Gather rays a texel, 2 to 2^20.
    Rays(u32),
    /// As many rays as fit into this time, reading and writing included.
    Time(Duration),
}

/// Efforts with a name. On hotel-room.glb (640,000 texels; a lamp, and a sun through the window) the median
/// estimated error before filtering is 8.4 % with 64 rays, and halves with every step; a million
/// texels take about 1.2 s a ray on two cores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// To look at while a scene is made: 64 rays a texel.
    Draft,
    /// For most scenes: 256 rays a texel.
    Medium,
    /// For the last bake: 1024 rays a texel.
    High,
}

/// What the numbers of emissive materials mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Emission {
    /// Bevy shows the emission of a glTF material as bright as its colour, whatever the camera's
    /// exposure (`StandardMaterial::emissive_exposure_weight` is 0). So that what is lit fits what
    /// is seen at the exposure of this EV100, it emits `colour * 1.2 * 2^EV100` cd/m².
    Exposure(f32),
    /// They are cd/m², as `KHR_materials_emissive_strength` has them.
    Nits,
}

/// Where probes go.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Probes {
    /// Nowhere.
    None,
    /// Into one box around the receivers, at most 2,000 and at least half a metre apart.
    #[default]
    Standard,
    /// The same box, so many metres apart, at most 64 along an axis.
    Spacing(f32),
}

impl BakeOptions {
    /// The standard bake of a scene into a folder.
    #[must_use]
    pub fn new(scene: impl Into<PathBuf>, out: impl Into<PathBuf>) -> Self {
        Self {
            scene: scene.into(),
            out: out.into(),
            lights: None,
            texels: Texels::Standard,
            effort: Effort::Rays(Quality::Medium.rays()),
            bounces: 0,
            sky: Vec3::ZERO,
            scale: 1.0,
            emission: Emission::Exposure(EMISSIVE_EV100),
            seed: 1,
            exr: true,
            denoise: true,
            probes: Probes::Standard,
            scenarios: Vec::new(),
            force: false,
            save_every: Duration::from_secs(20),
            limits: ImportLimits::default(),
        }
    }

    /// Whether a scenario is to be baked.
    pub(crate) fn wants(&self, scenario: &str) -> bool {
        self.scenarios.is_empty() || self.scenarios.iter().any(|name| name == scenario)
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`BakeError::Option`] for the first that does not fit.
    pub fn validate(&self) -> Result<(), BakeError> {
        let check = |good: bool, option, problem: String| match good {
            true => Ok(()),
            false => Err(BakeError::Option { option, problem }),
        };
        let (good, problem) = match self.texels {
            Texels::Standard => (true, String::new()),
            Texels::PerMetre(n) => {
                ((0.01..=1000.0).contains(&n), format!("{n} texels a metre, must be 0.01 to 1000"))
            }
            Texels::Page(n) => (
                n.is_power_of_two() && (64..=4096).contains(&n),
                format!("{n} texels, must be a power of two from 64 to 4096"),
            ),
        };
        check(good, "texels", problem)?;
        let (good, problem) = match self.effort {
            Effort::Rays(n) => {
                ((2..=1 << 20).contains(&n), format!("{n} rays a texel, must be 2 to {}", 1 << 20))
            }
            Effort::Time(t) => (!t.is_zero(), "there must be some time".to_owned()),
        };
        check(good, "effort", problem)?;
        let sky = self.sky.is_finite() && self.sky.min_element() >= 0.0;
        check(sky, "sky", format!("{} must be finite and not negative", self.sky))?;
        let scale = self.scale.is_finite() && self.scale > 0.0;
        check(scale, "scale", format!("{} must be finite and above 0", self.scale))?;
        if let Emission::Exposure(ev100) = self.emission {
            let good = (-10.0..=30.0).contains(&ev100);
            check(good, "emission", format!("EV100 {ev100}, must be -10 to 30"))?;
        }
        if let Probes::Spacing(metres) = self.probes {
            let good = metres.is_finite() && metres >= 0.01;
            check(good, "probes", format!("{metres} m apart, must be 0.01 m or more"))?;
        }
        Ok(())
    }
}

impl Quality {
    /// Gather rays a texel.
    #[must_use]
    pub fn rays(self) -> u32 {
        match self {
            Self::Draft => 64,
            Self::Medium => 256,
            Self::High => 1024,
        }
    }
}

impl Emission {
    /// What an emissive colour is multiplied with to be cd/m².
    #[must_use]
    pub fn factor(self) -> f32 {
        match self {
            Self::Exposure(ev100) => 1.2 * ev100.exp2(),
            Self::Nits => 1.0,
        }
    }
}

impl Effort {
    /// Most rays a texel.
    pub(crate) fn most_rays(self) -> u32 {
        match self {
            Self::Rays(rays) => rays.next_multiple_of(2),
            Self::Time(_) => 1 << 20,
        }
    }

    /// Paths a probe. A probe is one of few, and each lights much: they are never noisy.
    pub(crate) fn probe_paths(self) -> u32 {
        match self {
            Self::Rays(rays) => rays.saturating_mul(4).clamp(512, 4096),
            Self::Time(_) => 512,
        }
    }
}

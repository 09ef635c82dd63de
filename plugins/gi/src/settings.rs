//! Settings of the solver and the uploads.

use bevy::{asset::Asset, prelude::*};
use farlight_core::{
    FieldProblem, RonSettings,
    field::{Costly, Hidden, Label, Unit},
};
use farlight_gi_solver::{session::SessionSettings, settings::GiSettings as Plain};
use serde::{Deserialize, Serialize};

/// How lighting is solved and brought to the GPU: a resource, and an asset that
/// `GiSettings(...)` in a RON file holds (extension `gi.ron`).
///
/// A change of anything but `upload_bytes_per_frame` starts the solver anew; the old lighting is
/// gone then.
#[derive(Resource, Asset, Reflect, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
#[reflect(@Costly)]
#[serde(from = "Plain", into = "Plain")]
pub struct GiSettings {
    /// Edge of a square lightmap page in texels: a power of two from 16 to 4096.
    #[reflect(@Hidden)]
    pub page_size: u32,
    /// Most pages, 1 to 64. When they are full the texel density is lowered so that everything fits.
    #[reflect(@1..=64_u32)]
    pub max_pages: u32,
    /// Lightmap texels a metre, 0.1 to 1000. Higher is sharper and slower.
    #[reflect(@0.1..=1000.0_f32)]
    pub texels_per_metre: f32,
    /// Gather rays a texel that are kept for answers while light moves, 64 to 8192. Higher is
    /// less noisy and needs more memory.
    #[reflect(@64..=8192_u32)]
    pub rays_per_texel: u32,
    /// Gather rays a probe, 64 to 8192.
    #[reflect(@64..=8192_u32)]
    pub rays_per_probe: u32,
    /// Most memory for kept rays in MiB, at least 1; `rays_per_texel` is lowered to stay below.
    #[reflect(@1..=16_384_u32, @Unit("MiB"), @Label("Memory of rays"))]
    pub ray_memory_mib: u32,
    /// Reflections of light that are followed, 1 to 64; 1 is one bounce.
    #[reflect(@1..=64_u32)]
    pub bounces: u32,
    /// Paths a texel after which a still scene counts as converged and work stops.
    pub converged_paths: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Camera exposure at which emissive materials with `emissive_exposure_weight` 0 look as they
    /// are: such a material emits `emissive / exposure_ref` in cd/m². Bevy's default camera
    /// (EV100 = 9.7) has 0.001 002.
    #[reflect(@Hidden)]
    pub exposure_ref: f32,
    /// Most bytes of texels that are written to the GPU a frame.
    #[reflect(@65_536..=67_108_864_u32, @Unit("B"), @Label("Upload a frame"))]
    pub upload_bytes_per_frame: u32,
}

impl Default for GiSettings {
    fn default() -> Self {
        Plain::default().into()
    }
}

impl GiSettings {
    /// The part that a solver session takes.
    #[must_use]
    pub fn session(&self) -> SessionSettings {
        SessionSettings::from(&Plain::from(self.clone()))
    }
}

/// Converts between the two types; a field that one of them lacks is a compile error.
macro_rules! convert {
    ($from:ident => $to:ident: $($field:ident)*) => {
        impl From<$from> for $to {
            fn from($from { $($field),* }: $from) -> Self {
                Self { $($field),* }
            }
        }
    };
}

convert!(GiSettings => Plain: page_size max_pages texels_per_metre rays_per_texel rays_per_probe
    ray_memory_mib bounces converged_paths seed exposure_ref upload_bytes_per_frame);
convert!(Plain => GiSettings: page_size max_pages texels_per_metre rays_per_texel rays_per_probe
    ray_memory_mib bounces converged_paths seed exposure_ref upload_bytes_per_frame);

impl RonSettings for GiSettings {
    const EXTENSIONS: &'static [&'static str] = &["gi.ron"];

    fn check(&self) -> Result<(), FieldProblem> {
        Plain::from(self.clone()).validate().map_err(|problem| {
            let message = format!("is {}, must be {}", problem.value, problem.expected);
            FieldProblem::new(problem.field, message)
        })
    }
}

#[cfg(test)]
mod tests {
    use farlight_core::parse_ron;

    use super::*;

    #[test]
    fn files_hold_settings_and_errors_name_the_place() {
        let settings: GiSettings =
            parse_ron("a.gi.ron", "GiSettings(page_size: 128, bounces: 2)").unwrap();
        assert_eq!(settings, GiSettings { page_size: 128, bounces: 2, ..Default::default() });
        let error = |text| parse_ron::<GiSettings>("a.gi.ron", text).unwrap_err().to_string();
        let range = error("GiSettings(\n    page_size: 100,\n)");
        assert!(range.starts_with("a.gi.ron:2: page_size: is 100"), "{range}");
        let unknown = error("GiSettings(\n    pages: 3,\n)");
        assert!(unknown.starts_with("a.gi.ron:2:") && unknown.contains("pages"), "{unknown}");
    }
}

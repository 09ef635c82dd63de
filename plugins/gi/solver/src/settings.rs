//! Settings of global illumination as a user writes them down.
//!
//! The type is plain data for serde: an engine loads it as an asset, the command line checks it. In
//! RON:
//!
//! ```ron
//! GiSettings(
//!     texels_per_metre: 16.0,
//!     bounces: 4,
//! )
//! ```

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::session::SessionSettings;

/// How lighting is solved and sent to the GPU. Every field may be left out; an unknown one is an
/// error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GiSettings {
    /// Edge of a square lightmap page in texels; a power of two, 16 to 4096. Larger pages hold more
    /// objects a texture; a page takes 8 bytes a texel on the GPU. Default 512.
    pub page_size: u32,
    /// Most lightmap pages, 1 to 64. When they are full the texel density is lowered so that
    /// everything fits. Default 4.
    pub max_pages: u32,
    /// Lightmap texels a metre that are aimed for, 0.01 to 1000. Higher is sharper and slower: the
    /// work grows with its square. Default 8.
    pub texels_per_metre: f32,
    /// Gather rays a texel that are kept for answers while light moves, 64 to 8192. More is less
    /// noise, more memory (16 bytes each) and slower updates. Default 1024.
    pub rays_per_texel: u32,
    /// Gather rays a probe, 64 to 65536. Default 1024.
    pub rays_per_probe: u32,
    /// Most memory for kept rays in MiB, 1 to 1048576; `rays_per_texel` is lowered to stay below.
    /// Default 256.
    pub ray_memory_mib: u32,
    /// Reflections of light that are followed while light moves, 1 to 64 (from 6 on, all are).
    /// Default 8.
    pub bounces: u32,
    /// Paths a texel after which a still scene counts as converged and work stops, 64 to 16777216.
    /// The noise falls with its square root. Default 4096.
    pub converged_paths: u32,
    /// Seed of all random numbers: equal seeds give equal results. Default 1.
    pub seed: u64,
    /// What emissive materials are scaled with: the camera exposure (1 / (1.2 · 2^EV100), per cd/m²)
    /// for which their authors chose their emissive colour. An emissive material with exposure
    /// weight w emits `emissive · mix(1 / exposure_ref, 1, w)`, whatever the camera's exposure is at
    /// run time. Above 0. Default: that of EV100 = 9.7, an interior.
    pub exposure_ref: f32,
    /// Most bytes a frame that are copied to the GPU, 4096 to 1073741824. Less is smoother, more is
    /// sooner. Default 1048576.
    pub upload_bytes_per_frame: u32,
}

impl Default for GiSettings {
    fn default() -> Self {
        Self {
            page_size: 512,
            max_pages: 4,
            texels_per_metre: 8.0,
            rays_per_texel: 1024,
            rays_per_probe: 1024,
            ray_memory_mib: 256,
            bounces: 8,
            converged_paths: 4096,
            seed: 1,
            // 1 / (1.2 · 2^9.7)
            exposure_ref: 1.001_944e-3,
            upload_bytes_per_frame: 1 << 20,
        }
    }
}

/// A setting out of its range.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{field} is {value}, must be {expected}")]
pub struct SettingsError {
    /// The field's name as in the file.
    pub field: &'static str,
    /// What it holds.
    pub value: String,
    /// What it may hold.
    pub expected: &'static str,
}

impl SettingsError {
    /// The error of `field`, which holds `value` and must be `expected`, unless it is `good`.
    ///
    /// # Errors
    /// It is not good.
    pub fn check(
        good: bool,
        field: &'static str,
        value: &dyn ToString,
        expected: &'static str,
    ) -> Result<(), Self> {
        if good { Ok(()) } else { Err(Self { field, value: value.to_string(), expected }) }
    }
}

impl GiSettings {
    /// Checks every range.
    ///
    /// # Errors
    /// The first field that is out of its range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let check = SettingsError::check;
        check(
            self.page_size.is_power_of_two() && (16..=4096).contains(&self.page_size),
            "page_size",
            &self.page_size,
            "a power of two from 16 to 4096 (texels)",
        )?;
        check((1..=64).contains(&self.max_pages), "max_pages", &self.max_pages, "1 to 64")?;
        check(
            (0.01..=1000.0).contains(&self.texels_per_metre),
            "texels_per_metre",
            &self.texels_per_metre,
            "0.01 to 1000 (texels a metre)",
        )?;
        check(
            (64..=8192).contains(&self.rays_per_texel),
            "rays_per_texel",
            &self.rays_per_texel,
            "64 to 8192",
        )?;
        check(
            (64..=65_536).contains(&self.rays_per_probe),
            "rays_per_probe",
            &self.rays_per_probe,
            "64 to 65536",
        )?;
        check(
            (1..=1 << 20).contains(&self.ray_memory_mib),
            "ray_memory_mib",
            &self.ray_memory_mib,
            "1 to 1048576 (MiB)",
        )?;
        check((1..=64).contains(&self.bounces), "bounces", &self.bounces, "1 to 64")?;
        check(
            (64..=1 << 24).contains(&self.converged_paths),
            "converged_paths",
            &self.converged_paths,
            "64 to 16777216",
        )?;
        check(
            self.exposure_ref.is_finite() && self.exposure_ref > 0.0,
            "exposure_ref",
            &self.exposure_ref,
            "a finite number above 0 (per cd/m²)",
        )?;
        check(
            (4096..=1 << 30).contains(&self.upload_bytes_per_frame),
            "upload_bytes_per_frame",
            &self.upload_bytes_per_frame,
            "4096 to 1073741824 (bytes)",
        )
    }

    /// Writes what concerns the solver into its settings; the rest stays as it is there.
    pub fn apply_to(&self, session: &mut SessionSettings) {
        session.page_size = self.page_size;
        session.max_pages = self.max_pages;
        session.texels_per_metre = self.texels_per_metre;
        session.rays_per_texel = self.rays_per_texel;
        session.rays_per_probe = self.rays_per_probe;
        session.ray_memory = (self.ray_memory_mib as usize).saturating_mul(1 << 20);
        session.bounces = self.bounces;
        session.converged_paths = self.converged_paths;
        session.seed = self.seed;
    }
}

impl From<&GiSettings> for SessionSettings {
    fn from(settings: &GiSettings) -> Self {
        let mut session = Self::default();
        settings.apply_to(&mut session);
        session
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid_and_are_those_of_the_session() {
        let settings = GiSettings::default();
        assert_eq!(settings.validate(), Ok(()));
        assert_eq!(SessionSettings::from(&settings), SessionSettings::default());
        let exposure = 1.0 / (1.2 * 9.7_f32.exp2());
        assert!((settings.exposure_ref / exposure - 1.0).abs() < 1e-4, "{exposure}");
    }

    #[test]
    fn files_may_leave_fields_out_but_not_invent_any() {
        let settings: GiSettings =
            ron::from_str("GiSettings(bounces: 4, texels_per_metre: 2.5)").unwrap();
        assert_eq!(
            settings,
            GiSettings { bounces: 4, texels_per_metre: 2.5, ..GiSettings::default() }
        );
        let error = ron::from_str::<GiSettings>("GiSettings(\n  bouncs: 4\n)").unwrap_err();
        assert!(error.to_string().contains("bouncs"), "{error}");
        assert_eq!(error.span.start.line, 2);
    }

    #[test]
    fn ranges_are_checked_and_errors_name_the_field() {
        let bad = |change: fn(&mut GiSettings)| {
            let mut settings = GiSettings::default();
            change(&mut settings);
            settings.validate().unwrap_err().field
        };
        assert_eq!(bad(|s| s.page_size = 500), "page_size");
        assert_eq!(bad(|s| s.page_size = 8192), "page_size");
        assert_eq!(bad(|s| s.max_pages = 0), "max_pages");
        assert_eq!(bad(|s| s.texels_per_metre = f32::NAN), "texels_per_metre");
        assert_eq!(bad(|s| s.rays_per_texel = 10), "rays_per_texel");
        assert_eq!(bad(|s| s.rays_per_probe = 0), "rays_per_probe");
        assert_eq!(bad(|s| s.ray_memory_mib = 0), "ray_memory_mib");
        assert_eq!(bad(|s| s.bounces = 0), "bounces");
        assert_eq!(bad(|s| s.converged_paths = 1), "converged_paths");
        assert_eq!(bad(|s| s.exposure_ref = 0.0), "exposure_ref");
        assert_eq!(bad(|s| s.upload_bytes_per_frame = 0), "upload_bytes_per_frame");
        let error = GiSettings { bounces: 0, ..GiSettings::default() }.validate().unwrap_err();
        assert_eq!(error.to_string(), "bounces is 0, must be 1 to 64");
    }
}

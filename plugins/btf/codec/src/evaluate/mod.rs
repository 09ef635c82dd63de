//! Values of a material: the specification of every other evaluator, in SIMD or in a shader.

mod batch;
#[cfg(target_arch = "x86_64")]
mod kernel;
#[cfg(target_arch = "x86_64")]
mod lanes;
mod scalar;
#[cfg(target_arch = "x86_64")]
mod trigonometry;
#[cfg(target_arch = "x86_64")]
mod wide;

pub use batch::{Backend, Query};
pub use scalar::ViewSlices;

/// What to do where the format's existing evaluators deviate from what is sound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rules {
    /// The luminance curve over beta ends each interval with half of the slope between its ends
    /// (existing evaluators) instead of the slope of a Catmull-Rom spline.
    pub half_end_slope: bool,
    /// A light that is closer than 0.06 degrees to the axis across the view counts as alpha 0
    /// (existing evaluators on GPUs).
    pub guard_beta_pole: bool,
    /// HDR values stay linear instead of sRGB-encoded, as shading wants them.
    pub linear: bool,
}

impl Rules {
    /// As existing evaluators of the BTFbase format do.
    pub const COMPATIBLE: Self =
        Self { half_end_slope: true, guard_beta_pole: true, linear: false };
    /// For shading.
    pub const SHADING: Self = Self { half_end_slope: false, guard_beta_pole: false, linear: true };
}

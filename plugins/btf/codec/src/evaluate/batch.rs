//! Many values at once, on the widest vectors that the processor has.

use glam::Vec3;

use crate::{Angles, Btf, Rules, SliceAngles, ViewSlices};

/// One value that is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Query {
    /// Column of the texel; wraps round.
    pub x: i32,
    /// Row of the texel; wraps round.
    pub y: i32,
    /// Directions of light and view.
    pub angles: Angles,
}

/// What evaluates many values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Backend {
    /// One at a time, on any processor; the specification of the others.
    Scalar,
    /// Eight at a time: x86-64 with AVX2 and FMA.
    Avx2,
    /// Sixteen at a time: x86-64 with AVX-512 (F and DQ).
    Avx512,
}

impl Backend {
    /// Those that this processor has, the fastest last.
    pub fn available() -> Vec<Self> {
        #[cfg(target_arch = "x86_64")]
        {
            use super::lanes::{Avx2, Avx512};
            let wide = [Avx2::new().map(|_| Self::Avx2), Avx512::new().map(|_| Self::Avx512)];
            [Self::Scalar].into_iter().chain(wide.into_iter().flatten()).collect()
        }
        #[cfg(not(target_arch = "x86_64"))]
        vec![Self::Scalar]
    }

    /// The fastest that this processor has.
    pub fn best() -> Self {
        Self::available().pop().unwrap_or(Self::Scalar)
    }
}

impl Btf {
    /// As [`Btf::evaluate`] of each query, in their order, on the processor's vectors.
    ///
    /// Values differ from those of [`Btf::evaluate`] by rounding: by less than 0.01 of 255 except where
    /// the angles themselves are ill-conditioned in 32 bits, within 0.1 degrees of the horizon. Azimuths
    /// should be below some thousand radians.
    ///
    /// # Panics
    ///
    /// If there are not as many values as queries.
    pub fn evaluate_batch(&self, queries: &[Query], rules: Rules, values: &mut [Vec3]) {
        self.evaluate_batch_on(Backend::best(), queries, rules, values);
    }

    /// As [`Btf::evaluate_batch`], with a backend of choice; one that the processor lacks is replaced
    /// by [`Backend::Scalar`].
    ///
    /// # Panics
    ///
    /// If there are not as many values as queries.
    pub fn evaluate_batch_on(
        &self,
        backend: Backend,
        queries: &[Query],
        rules: Rules,
        values: &mut [Vec3],
    ) {
        assert_eq!(queries.len(), values.len(), "a value for each query");
        #[cfg(target_arch = "x86_64")]
        if super::wide::evaluate(self, backend, queries, rules, values) {
            return;
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = backend;
        for (query, value) in queries.iter().zip(values) {
            *value = self.evaluate(query.x, query.y, query.angles, rules);
        }
    }

    /// As [`Btf::evaluate_slices`] for each light, in their order, on the processor's vectors: what a
    /// texel shows one view under many lights.
    ///
    /// # Panics
    ///
    /// If there are not as many values as lights.
    pub fn evaluate_lights(
        &self,
        slices: &ViewSlices,
        lights: &[SliceAngles],
        rules: Rules,
        values: &mut [Vec3],
    ) {
        self.evaluate_lights_on(Backend::best(), slices, lights, rules, values);
    }

    /// As [`Btf::evaluate_lights`], with a backend of choice; one that the processor lacks is replaced
    /// by [`Backend::Scalar`].
    ///
    /// # Panics
    ///
    /// If there are not as many values as lights.
    pub fn evaluate_lights_on(
        &self,
        backend: Backend,
        slices: &ViewSlices,
        lights: &[SliceAngles],
        rules: Rules,
        values: &mut [Vec3],
    ) {
        assert_eq!(lights.len(), values.len(), "a value for each light");
        #[cfg(target_arch = "x86_64")]
        if super::wide::evaluate_lights(self, backend, slices, lights, rules, values) {
            return;
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = backend;
        for (light, value) in lights.iter().zip(values) {
            *value = self.evaluate_slices(slices, *light, rules);
        }
    }
}

//! Texels that are so bright that the others want to be told about them.
//!
//! A patch of sunlight on a floor is a light source like any other: found by chance it is noise. Texels
//! that leave much more light than most are drawn like points of an emitter, and what a ray meets by
//! chance is weighed against that (multiple importance sampling, Veach and Guibas 1995). The idea is
//! that of virtual area lights, here as dense as the lightmap itself.
//!
//! In hotel-room, with a lamp and a sun, drawing them takes the median error of 128 rays a texel from 8.0
//! to 6.0 %, its 95th percentile from 43 to 35 %, and about twice the time: there that is a draw. The
//! smaller and brighter the patch, the more it gains.

use glam::{Vec2, Vec3};

use super::Layout;
use crate::{World, path::Table, sampling::PathSampler, scene::AlphaMode};

/// Texels that leave more than this many times the mean radiance that rays meet are drawn.
const BRIGHT: f32 = 4.0;
/// Nothing is drawn unless this part of the light that rays meet comes from such texels: drawing costs a
/// ray.
const SHARE: f64 = 0.15;

/// Bright texels and how they are drawn.
#[derive(Default)]
pub(super) struct Sources {
    table: Table,
    texels: Vec<u32>,
}

impl Sources {
    /// From the radiance that leaves each texel, and how many kept rays met each: what nobody sees, like
    /// the sunny outside of a room, isn't worth a ray. Writes the probability with which each texel is
    /// drawn into `probability`.
    pub(super) fn new(
        world: &World,
        layout: &Layout,
        leaving: &[Vec3],
        met: &[f32],
        probability: &mut [f32],
    ) -> Self {
        probability.fill(0.0);
        let weight = |t: usize| leaving[t].max_element() * met[t];
        let light: f64 = (0..layout.len()).map(|t| f64::from(weight(t))).sum();
        let rays: f64 = met.iter().map(|met| f64::from(*met)).sum();
        let mean = (light / rays) as f32;
        let mut texels = Vec::new();
        for receiver in &layout.patches.receivers {
            let material = &world.instances()[receiver.instance as usize].material;
            if matches!(material.alpha_mode, AlphaMode::Mask(_)) {
                continue;
            }
            let first = receiver.first as usize;
            let bright = |t: &usize| leaving[*t].max_element() > mean * BRIGHT && weight(*t) > 0.0;
            texels.extend((first..first + receiver.texels.len()).filter(bright).map(|t| t as u32));
        }
        let table = Table::new(texels.iter().map(|t| weight(*t as usize)));
        if light.is_nan() || table.total() <= light * SHARE {
            return Self::default();
        }
        for &texel in &texels {
            probability[texel as usize] =
                (f64::from(weight(texel as usize)) / table.total()) as f32;
        }
        Self { table, texels }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.texels.is_empty()
    }

    /// Draws a texel, and a place in it.
    pub(super) fn draw(&self, sampler: &mut PathSampler) -> (u32, Vec2) {
        let (entry, place) = self.table.sample(sampler);
        (self.texels[entry], place)
    }
}

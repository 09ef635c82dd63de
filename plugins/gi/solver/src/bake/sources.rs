//! Texels that are so bright that the others want to be told about them.
//!
//! A patch of sunlight on a floor is a light source like any other: found by chance it is noise. Texels
//! that leave much more light than most are drawn like points of an emitter, and what a ray meets by
//! chance is weighed against that (multiple importance sampling, Veach and Guibas 1995). The idea is
//! that of virtual area lights, here as dense as the lightmap itself.

use glam::{Vec2, Vec3};

use super::{Layout, map::TexelMap};
use crate::{World, path::Table, sampling::PathSampler, scene::AlphaMode};

/// Texels that leave more than this many times the mean radiance are drawn.
const BRIGHT: f32 = 4.0;
/// Nothing is drawn unless this part of all light leaves such texels: drawing costs a ray.
const SHARE: f32 = 0.15;

/// Bright texels and how they are drawn.
#[derive(Default)]
pub(super) struct Sources {
    table: Table,
    texels: Vec<u32>,
}

impl Sources {
    /// From the radiance that leaves each texel. Writes the probability with which each texel is drawn
    /// into `probability`.
    pub(super) fn new(
        world: &World,
        layout: &Layout,
        map: &TexelMap,
        leaving: &[Vec3],
        probability: &mut [f32],
    ) -> Self {
        probability.fill(0.0);
        let mut texels = Vec::with_capacity(layout.len());
        for receiver in &layout.patches.receivers {
            let instance = &world.instances()[receiver.instance as usize];
            let whole = !matches!(instance.material.alpha_mode, AlphaMode::Mask(_));
            for (i, point) in receiver.texels.points.iter().enumerate() {
                let texel = receiver.first + i as u32;
                let edge = map.texel_edge(point.triangle + instance.first_triangle);
                let radiance = leaving[texel as usize].max_element();
                if layout.answers(texel as usize) && edge < 1e3 {
                    texels.push((texel, radiance, edge * edge, whole));
                }
            }
        }
        let sum = |of: &dyn Fn(&(u32, f32, f32, bool)) -> f64| texels.iter().map(of).sum::<f64>();
        let power = sum(&|t| f64::from(t.1 * t.2));
        let mean = (power / sum(&|t| f64::from(t.2))) as f32;
        let bright = |t: &&(u32, f32, f32, bool)| t.3 && t.1 > mean * BRIGHT;
        let theirs: f64 = texels.iter().filter(bright).map(|t| f64::from(t.1 * t.2)).sum();
        if theirs.is_nan() || theirs <= power * f64::from(SHARE) {
            return Self::default();
        }
        let chosen: Vec<_> = texels.iter().filter(bright).collect();
        let table = Table::new(chosen.iter().map(|t| t.1 * t.2));
        for (texel, radiance, area, _) in &chosen {
            probability[*texel as usize] = (f64::from(radiance * area) / table.total()) as f32;
        }
        Self { table, texels: chosen.iter().map(|t| t.0).collect() }
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

//! Looking into a session: texels, their reference values, progress.

use std::f32::consts::PI;

use glam::Vec3;

use super::Session;
use crate::{
    Scene, World,
    atlas::PageId,
    estimate::{Estimate, GatherSettings, Progress},
    receiver::{Receiver, gather_receivers},
    scene::{DirectSky, InstanceId},
};

/// A texel of a receiver, and the point that it is solved at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexelPoint {
    /// The receiver.
    pub instance: InstanceId,
    /// The page.
    pub page: PageId,
    /// Column in the page.
    pub x: u32,
    /// Row in the page.
    pub y: u32,
    /// World position.
    pub position: Vec3,
    /// Unit geometric normal.
    pub normal: Vec3,
    /// What the session holds there now: E / π, as in the tiles.
    pub value: Vec3,
    /// Its standard error in luminance, as the session estimates it.
    pub error: f32,
}

/// The path tracer's answer at texels, to compare a session's with: E / π of everything that tiles
/// hold, so without what arrives straight from punctual lights, and from the sky if the scene leaves
/// that out. `None` if `progress` stopped the work.
/// Runs on all threads of the current rayon pool.
#[must_use]
pub fn reference(
    scene: &Scene,
    texels: &[TexelPoint],
    settings: &GatherSettings,
    progress: Progress<'_>,
) -> Option<Vec<Estimate>> {
    let world = World::new(scene);
    let receivers: Vec<Receiver> =
        texels.iter().map(|t| Receiver { position: t.position, normal: t.normal }).collect();
    let light = gather_receivers(&world, &receivers, settings, progress)?;
    let estimates = light.iter().zip(&receivers).map(|(light, receiver)| {
        let Estimate { mut mean, mut se } = light.indirect;
        if scene.direct_sky == DirectSky::Included {
            mean += light.direct.mean - receiver.direct(&world);
            se = (se * se + light.direct.se * light.direct.se).map(f32::sqrt);
        }
        Estimate { mean: mean / PI, se: se / PI }
    });
    Some(estimates.collect())
}

impl Session {
    /// The scene as the session knows it.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Edge of a page in texels.
    #[must_use]
    pub fn page_size(&self) -> u32 {
        self.places.atlas.page_size()
    }

    /// Kept rays that were traced since the geometry last changed. Light that changes adds none.
    #[must_use]
    pub fn rays_traced(&self) -> u64 {
        self.lighting.as_ref().map_or(0, |l| l.traced)
    }

    /// The part of the work that is done if nothing changes any more, 0..=1, in rays.
    #[must_use]
    pub fn progress(&self) -> f32 {
        if self.is_idle() {
            return 1.0;
        }
        let most = self.settings.converged_paths.max(self.settings.rays_per_texel).max(1);
        self.lighting.as_ref().map_or(0.0, |l| (l.rays() as f32 / most as f32).min(0.999))
    }

    /// All texels that are solved (not those that dilation fills), with the points they are solved
    /// at.
    #[must_use]
    pub fn texels(&self) -> Vec<TexelPoint> {
        let Some(lighting) = &self.lighting else { return Vec::new() };
        let mut out = Vec::with_capacity(lighting.patches.fronts);
        for receiver in &lighting.patches.receivers {
            let instance = lighting.world.instances()[receiver.instance as usize].id;
            let Some(place) = self.places.places.get(&instance) else { continue };
            let rect = place.rect();
            for (i, [x, y]) in receiver.texels.coords.iter().enumerate() {
                let patch = receiver.first as usize + i;
                if lighting.is_valid(patch) {
                    out.push(TexelPoint {
                        instance,
                        page: place.page,
                        x: rect.x + u32::from(*x),
                        y: rect.y + u32::from(*y),
                        position: lighting.patches.position[patch],
                        normal: lighting.patches.normal[patch],
                        value: lighting.irradiance[patch] / PI,
                        error: lighting.error[patch] / PI,
                    });
                }
            }
        }
        out
    }
}

//! What arrives straight from punctual lights, the mean over each texel's area.
//!
//! Four samples a texel say whether a light is seen from all of it or from none. Where they disagree
//! with each other or with the texels around, 64 or, for soft shadows, up to 256 samples spread over the
//! texel and the light together are taken: shadows have edges without steps, and no noise to speak of
//! (tests compare with 4096).
//!
//! On smooth low-poly surfaces the cosine is that of the interpolated normal, and shadow rays start on the
//! curved surface that the normals stand for (Hanika 2021, "Hacking the Shadow Terminator"), so that
//! triangles don't show in their own shadow.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::{Layout, map::TexelMap, normals::Smooth};
use crate::{
    Ray, World,
    estimate::Progress,
    lightmap::{SAMPLES, SurfacePoint},
    sampling::{Frame, concentric_disk, hash_pair, sobol_owen_4d},
    scene::{Light, LightKind},
    visibility::offset_origin,
};

/// Samples of a texel that a hard shadow's edge crosses.
const EDGE_SAMPLES: u32 = 64;
/// Samples of a texel in a soft shadow.
const SOFT_SAMPLES: u32 = 256;
/// Ends shadow rays just before the light.
const SHADOW_END: f32 = 1.0 - 1e-5;
/// How high above the surface the way between two points of a texel runs, in texels.
const LIFT: f32 = 0.1;
/// Names the random numbers.
const STREAM: u64 = 0x6469_7265_6374;

/// A light with an extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectLight {
    /// The light.
    pub light: Light,
    /// Radius in metres of a point or spot light, or half the angle in radians of a directional one, that
    /// softens its shadows; 0 for sharp ones. How bright it is where nothing is in its way is that of a
    /// light without extent.
    pub radius: f32,
}

/// How much of a light a texel sees.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sees {
    /// Nothing arrives even without shadows.
    Nothing,
    Shadow,
    All,
    Parts,
}

/// Irradiance at every texel straight from the given lights. `None` if `progress` stopped the work.
#[must_use]
pub fn direct(
    world: &World,
    layout: &Layout,
    lights: &[DirectLight],
    progress: Progress<'_>,
) -> Option<Vec<Vec3>> {
    direct_by(&TexelMap::new(world, layout), world, layout, lights, progress)
}

/// [`direct`] with a map that is there already.
pub(super) fn direct_by(
    map: &TexelMap,
    world: &World,
    layout: &Layout,
    lights: &[DirectLight],
    progress: Progress<'_>,
) -> Option<Vec<Vec3>> {
    let mut sum = vec![Vec3::ZERO; layout.len()];
    let smooth: Vec<Smooth> = layout
        .patches
        .receivers
        .iter()
        .map(|r| Smooth::new(&world.instances()[r.instance as usize]))
        .collect();
    let scene = Shadows { map, world, layout, smooth };
    for light in lights {
        let coarse: Vec<(Vec3, Sees)> = (0..layout.len())
            .into_par_iter()
            .with_min_len(64)
            .map(|i| progress(1).is_continue().then(|| scene.coarse(i, light)))
            .collect::<Option<_>>()?;
        for (index, receiver) in layout.patches.receivers.iter().enumerate() {
            let first = receiver.first as usize;
            sum[first..first + receiver.texels.len()]
                .par_iter_mut()
                .with_min_len(16)
                .enumerate()
                .map(|(i, sum)| {
                    *sum += if scene.at_edge(index, i, &coarse) {
                        let least = coarse[first + i].0;
                        scene.fine(index, i, light).unwrap_or(least)
                    } else {
                        coarse[first + i].0
                    };
                    progress(0).is_continue().then_some(())
                })
                .collect::<Option<()>>()?;
        }
    }
    Some(sum)
}

struct Shadows<'a> {
    map: &'a TexelMap,
    world: &'a World,
    layout: &'a Layout,
    /// One a receiver.
    smooth: Vec<Smooth<'a>>,
}

impl Shadows<'_> {
    /// The mean over the few sample points of a texel.
    fn coarse(&self, texel: usize, light: &DirectLight) -> (Vec3, Sees) {
        let patches = &self.layout.patches;
        let receiver = self.layout.receiver_index(texel as u32);
        let (mut sum, mut lit, mut reached) = (Vec3::ZERO, 0, 0);
        for k in 0..SAMPLES {
            let normal = patches.sample_normals[texel][k];
            let point = patches.points[texel][k];
            let u = sobol_owen_4d(k as u32, hash_pair(STREAM, texel as u64));
            let arrives = self.arrives(receiver, point, normal, light, Vec2::new(u[0], u[1]));
            if let Some((irradiance, seen)) = arrives {
                reached += 1;
                if seen {
                    lit += 1;
                    sum += irradiance;
                }
            }
        }
        let sees = match (reached, lit) {
            (0, _) => Sees::Nothing,
            (_, 0) => Sees::Shadow,
            (a, b) if a == b => Sees::All,
            _ => Sees::Parts,
        };
        (sum / SAMPLES as f32, sees)
    }

    /// Whether an edge of a shadow may cross a texel.
    fn at_edge(&self, receiver: usize, texel: usize, coarse: &[(Vec3, Sees)]) -> bool {
        let receiver = &self.layout.patches.receivers[receiver];
        let (first, texels) = (receiver.first as usize, &receiver.texels);
        let own = coarse[first + texel].1;
        if own == Sees::Parts {
            return true;
        }
        let [x, y] = texels.coords[texel].map(i64::from);
        own != Sees::Nothing
            && (0..9).any(|k| {
                let other = texels.at(x + k % 3 - 1, y + k / 3 - 1, texels.chart[texel]);
                other.is_some_and(|other| {
                    let other = coarse[first + other as usize].1;
                    other != Sees::Nothing && other != own
                })
            })
    }

    /// The mean over many points of a texel and of the light; `None` where there is no such point.
    fn fine(&self, index: usize, texel: usize, light: &DirectLight) -> Option<Vec3> {
        let receiver = &self.layout.patches.receivers[index];
        let patches = &self.layout.patches;
        let global = receiver.first as usize + texel;
        let lift = LIFT / self.layout.texels_per_metre;
        let middle = patches.position[global] + patches.normal[global] * lift;
        let (mut sum, mut points, mut parts) = (Vec3::ZERO, 0_u32, [0_u32; 2]);
        for sample in 0..SOFT_SAMPLES {
            // Sharp edges, and what proves not to be in a soft shadow, are done.
            if sample == EDGE_SAMPLES && (light.radius <= 0.0 || parts.contains(&0)) {
                break;
            }
            let u = sobol_owen_4d(sample, hash_pair(STREAM + 1, global as u64));
            let place = Vec2::new(u[0], u[1]);
            let point = self.map.point_in(self.world, self.layout, global as u32, place);
            let Some(point) = point else { continue };
            let normal = self.world.normal(point.triangle);
            // Not what lies behind a wall that stands on the texel.
            let way = self.position(point) + normal * lift - middle;
            if self.world.occluded(&Ray { t_max: 1.0, ..Ray::new(middle, way) }) {
                continue;
            }
            points += 1;
            let arrives = self.arrives(index, point, normal, light, Vec2::new(u[2], u[3]));
            if let Some((irradiance, seen)) = arrives {
                parts[usize::from(seen)] += 1;
                if seen {
                    sum += irradiance;
                }
            }
        }
        (points > 0).then(|| sum / points as f32)
    }

    /// What a light sends to a point of a receiver without shadows, if anything, and whether the point
    /// sees the place `u` of the light.
    fn arrives(
        &self,
        receiver: usize,
        point: SurfacePoint,
        geometric: Vec3,
        DirectLight { light, radius }: &DirectLight,
        u: Vec2,
    ) -> Option<(Vec3, bool)> {
        let smooth = &self.smooth[receiver];
        let position = self.position(point);
        let sample = light.sample(position)?;
        let (normal, lifted) = smooth.at(point, geometric);
        let cos = sample.to_light.dot(normal);
        if cos <= 0.0 {
            return None;
        }
        let origin = offset_origin(position + lifted, geometric);
        let across = if *radius > 0.0 {
            let disk = concentric_disk(u) * *radius;
            let frame = Frame::new(sample.to_light);
            frame.tangent * disk.x + frame.bitangent * disk.y
        } else {
            Vec3::ZERO
        };
        let ray = match light.kind {
            LightKind::Directional => Ray::new(origin, sample.to_light + across),
            LightKind::Point | LightKind::Spot { .. } => {
                let way = light.position + across - origin;
                Ray { t_max: SHADOW_END, ..Ray::new(origin, way) }
            }
        };
        Some((sample.irradiance * cos, !self.world.occluded(&ray)))
    }

    fn position(&self, point: SurfacePoint) -> Vec3 {
        let [a, b, c] = self.world.corners(point.triangle);
        a + (b - a) * point.bary.x + (c - a) * point.bary.y
    }
}

//! Sizes of instances, in metres and in texels.

use std::collections::BTreeMap;

use farlight_gi_solver::{
    import::ImportedScene,
    scene::{InstanceId, Mesh},
};
use glam::{Affine3A, Mat3A, UVec2, Vec3A};

/// Triangles that are looked at to compare the sizes of a mesh's instances.
const SAMPLES: usize = 2000;
/// Instances get at least this part of the largest one's edges, so that gutters hold.
const SMALLEST: f32 = 0.5;
/// Share of the texels that charts cover, about.
const COVERAGE: f64 = 0.6;

/// The largest instance of a mesh, and how large the others are beside it.
pub(super) struct Sizes {
    /// From the mesh to the largest instance, without place and mirror: lengths are metres.
    pub(super) linear: Mat3A,
    /// Edges beside those of the largest instance, [`SMALLEST`]..1.
    ratios: BTreeMap<InstanceId, f32>,
}

impl Sizes {
    /// `None` without instances.
    pub(super) fn of(mesh: &Mesh, instances: &BTreeMap<InstanceId, Affine3A>) -> Option<Self> {
        let step = mesh.triangles.len().div_ceil(SAMPLES).max(1);
        let edges: Vec<[Vec3A; 2]> = mesh
            .triangles
            .iter()
            .step_by(step)
            .map(|t| {
                let [a, b, c] = t.map(|i| Vec3A::from(mesh.positions[i as usize]));
                [b - a, c - a]
            })
            .collect();
        let area = |m: &Mat3A| -> f64 {
            edges.iter().map(|[u, v]| f64::from((*m * *u).cross(*m * *v).length())).sum()
        };
        // Copies usually differ in place only.
        let mut known: BTreeMap<[u32; 9], f64> = BTreeMap::new();
        let mut area_of = |m: &Mat3A| {
            *known.entry(m.to_cols_array().map(f32::to_bits)).or_insert_with(|| area(m))
        };
        let areas: BTreeMap<InstanceId, f64> =
            instances.iter().map(|(id, t)| (*id, area_of(&t.matrix3))).collect();
        // The first of the largest.
        let (largest, most) =
            areas.iter().fold(None, |best: Option<(&InstanceId, f64)>, (id, &a)| match best {
                Some((_, most)) if a <= most => best,
                _ => Some((id, a)),
            })?;
        let mut linear = instances.get(largest)?.matrix3;
        if linear.determinant() < 0.0 {
            linear = Mat3A::from_diagonal(glam::Vec3::new(-1.0, 1.0, 1.0)) * linear;
        }
        let ratio = |a: f64| ((a / most).sqrt() as f32).clamp(SMALLEST, 1.0);
        let ratio = |a: f64| if most > 0.0 { ratio(a) } else { 1.0 };
        let ratios = areas.iter().map(|(id, &a)| (*id, ratio(a))).collect();
        Some(Self { linear, ratios })
    }

    /// The smallest ratio.
    pub(super) fn smallest(&self) -> f32 {
        self.ratios.values().copied().fold(1.0, f32::min)
    }

    /// Texels of each instance where the largest gets `size`.
    pub(super) fn texels(&self, size: UVec2) -> BTreeMap<InstanceId, UVec2> {
        let scaled = |ratio: f32| (size.as_vec2() * ratio).round().as_uvec2().max(UVec2::ONE);
        self.ratios.iter().map(|(id, &ratio)| (*id, scaled(ratio))).collect()
    }
}

/// Texels a metre at which the whole scene takes about `texels`.
#[must_use]
pub fn density_for(imported: &ImportedScene, texels: f64) -> f32 {
    let scene = &imported.scene;
    let area = |instance: &farlight_gi_solver::scene::Instance| -> f64 {
        let Some(mesh) = scene.meshes.get(&instance.mesh) else { return 0.0 };
        let m = instance.transform.matrix3;
        let corner = |i: u32| m * Vec3A::from(mesh.positions[i as usize]);
        mesh.triangles
            .iter()
            .map(|t| t.map(corner))
            .map(|[a, b, c]| f64::from((b - a).cross(c - a).length()) / 2.0)
            .filter(|area| area.is_finite())
            .sum()
    };
    let area: f64 = scene.instances.values().map(area).sum();
    (texels * COVERAGE / area.max(1e-12)).sqrt() as f32
}

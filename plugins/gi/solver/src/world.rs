//! A scene flattened for tracing.

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3, Vec4};

use crate::{
    Hit, Scene, Tracer,
    scene::{AlphaMode, InstanceId, Light, Material, Mesh, Sky, Texture},
};

/// A scene in world space: one BVH over all instances, and what the surface is like at a hit.
///
/// Blended materials are left out. The world is a snapshot: lights and sky can be replaced, geometry
/// asks for a new one.
pub struct World {
    /// Ray queries; triangle indices are those of [`World::surface`].
    pub tracer: Tracer,
    /// The lights, in the order of their ids.
    pub lights: Vec<Light>,
    /// What rays see that hit nothing.
    pub sky: Sky,
    instances: Vec<WorldInstance>,
    triangles: Vec<WorldTriangle>,
    has_masks: bool,
}

/// An instance with everything it refers to.
pub struct WorldInstance {
    /// Its id in the scene.
    pub id: InstanceId,
    /// Its mesh, in its own space.
    pub mesh: Arc<Mesh>,
    /// Its material.
    pub material: Material,
    /// From the mesh's space to the world.
    pub transform: Affine3A,
    /// Index of its first triangle in the world; the others follow in the mesh's order.
    pub first_triangle: u32,
    base_color_texture: Option<Arc<Texture>>,
    emissive_texture: Option<Arc<Texture>>,
}

struct WorldTriangle {
    corners: [Vec3; 3],
    /// Unit normal of the front side (counter-clockwise corners after the transform's mirroring);
    /// zero for a triangle without area.
    normal: Vec3,
    instance: u32,
}

/// The surface at a point.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// World position.
    pub position: Vec3,
    /// Unit geometric normal on the side that was asked for.
    pub normal: Vec3,
    /// Whether that is the back side.
    pub back: bool,
    /// Diffuse albedo, linear, 0..1.
    pub albedo: Vec3,
    /// Emitted radiance (both sides emit).
    pub emission: Vec3,
    /// Alpha after the texture.
    pub alpha: f32,
    /// Index into [`World::instances`].
    pub instance: u32,
    /// Second UV set, or zero where there is none.
    pub uv1: Vec2,
}

impl World {
    /// Flattens a scene and builds its BVH. Instances whose mesh is missing or does not
    /// [validate](Mesh::validate) are left out.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let mut instances = Vec::new();
        let mut triangles = Vec::new();
        for (&id, instance) in &scene.instances {
            let Some(mesh) = scene.meshes.get(&instance.mesh) else { continue };
            let material = scene.materials.get(&instance.material).cloned().unwrap_or_default();
            if mesh.validate().is_err()
                || material.alpha_mode == AlphaMode::Blend
                || !instance.transform.is_finite()
            {
                continue;
            }
            let texture = |id| scene.textures.get(&id).cloned();
            let flip = instance.transform.matrix3.determinant() < 0.0;
            let index = instances.len() as u32;
            let first_triangle = triangles.len() as u32;
            for corners in &mesh.triangles {
                let corners = corners
                    .map(|i| instance.transform.transform_point3(mesh.positions[i as usize]));
                let normal =
                    (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
                triangles.push(WorldTriangle {
                    corners,
                    normal: if flip { -normal } else { normal },
                    instance: index,
                });
            }
            instances.push(WorldInstance {
                id,
                mesh: mesh.clone(),
                base_color_texture: material.base_color_texture.and_then(texture),
                emissive_texture: material.emissive_texture.and_then(texture),
                material,
                transform: instance.transform,
                first_triangle,
            });
        }
        let corners: Vec<_> = triangles.iter().map(|t: &WorldTriangle| t.corners).collect();
        let has_masks = instances
            .iter()
            .any(|i: &WorldInstance| matches!(i.material.alpha_mode, AlphaMode::Mask(_)));
        Self {
            has_masks,
            tracer: Tracer::new(&corners),
            lights: scene.lights.values().copied().collect(),
            sky: scene.sky.clone(),
            instances,
            triangles,
        }
    }

    /// Takes materials and textures of the scene over, for the instances as they are. Returns `false`,
    /// having changed nothing, where that is not enough because an instance would come or go.
    pub fn refresh_materials(&mut self, scene: &Scene) -> bool {
        let mut materials = Vec::with_capacity(self.instances.len());
        for old in &self.instances {
            let Some(instance) = scene.instances.get(&old.id) else { return false };
            let material = scene.materials.get(&instance.material).cloned().unwrap_or_default();
            if material.alpha_mode != old.material.alpha_mode {
                return false;
            }
            materials.push(material);
        }
        let texture = |id| scene.textures.get(&id).cloned();
        for (instance, material) in self.instances.iter_mut().zip(materials) {
            instance.base_color_texture = material.base_color_texture.and_then(texture);
            instance.emissive_texture = material.emissive_texture.and_then(texture);
            instance.material = material;
        }
        true
    }

    /// All instances that are in the world.
    #[must_use]
    pub fn instances(&self) -> &[WorldInstance] {
        &self.instances
    }

    /// How many triangles there are.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Whether some materials are cut out, so that a hit may not be there
    /// ([`World::closest`] knows).
    #[must_use]
    pub fn has_masks(&self) -> bool {
        self.has_masks
    }

    /// Whether a hit lies on a transparent texel of a cut-out material.
    #[must_use]
    pub fn is_cut_out(&self, hit: &Hit) -> bool {
        let instance = &self.instances[self.triangles[hit.triangle as usize].instance as usize];
        match instance.material.alpha_mode {
            AlphaMode::Mask(cutoff) => {
                self.surface_at(hit.triangle, Vec2::new(hit.u, hit.v), false).alpha < cutoff
            }
            _ => false,
        }
    }

    /// World-space corners of a triangle.
    #[must_use]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].corners
    }

    /// Index into [`World::instances`] of a triangle's instance.
    #[must_use]
    pub fn instance_of(&self, triangle: u32) -> u32 {
        self.triangles[triangle as usize].instance
    }

    /// Unit normal of a triangle's front side; zero for a triangle without area.
    #[must_use]
    pub fn normal(&self, triangle: u32) -> Vec3 {
        self.triangles[triangle as usize].normal
    }

    /// Whether a ray with this direction meets a triangle's back.
    #[must_use]
    pub fn is_back(&self, triangle: u32, direction: Vec3) -> bool {
        self.normal(triangle).dot(direction) > 0.0
    }

    /// The second UV at barycentric coordinates of a triangle; zero where there is none.
    #[must_use]
    pub fn uv1(&self, triangle: u32, bary: Vec2) -> Vec2 {
        let instance = &self.instances[self.instance_of(triangle) as usize];
        if instance.mesh.uv1.is_empty() {
            return Vec2::ZERO;
        }
        let [a, b, c] = instance.mesh.triangles[(triangle - instance.first_triangle) as usize]
            .map(|i| instance.mesh.uv1[i as usize]);
        a * (1.0 - bary.x - bary.y) + b * bary.x + c * bary.y
    }

    /// The surface that a ray with direction `direction` met, on the side from which it came.
    #[must_use]
    pub fn surface(&self, hit: &Hit, direction: Vec3) -> Surface {
        let back = self.triangles[hit.triangle as usize].normal.dot(direction) > 0.0;
        self.surface_at(hit.triangle, Vec2::new(hit.u, hit.v), back)
    }

    /// The surface at barycentric coordinates (weights of the second and third corner) of a triangle.
    #[must_use]
    pub fn surface_at(&self, triangle: u32, bary: Vec2, back: bool) -> Surface {
        let world = &self.triangles[triangle as usize];
        let instance = &self.instances[world.instance as usize];
        let weights = Vec3::new(1.0 - bary.x - bary.y, bary.x, bary.y);
        let corners = instance.mesh.triangles[(triangle - instance.first_triangle) as usize];
        let uv = |set: &[Vec2]| {
            if set.is_empty() {
                return Vec2::ZERO;
            }
            set[corners[0] as usize] * weights.x
                + set[corners[1] as usize] * weights.y
                + set[corners[2] as usize] * weights.z
        };
        let material = &instance.material;
        let textured = instance.base_color_texture.is_some() || instance.emissive_texture.is_some();
        let uv0 = if textured {
            material.uv_transform.transform_point2(uv(&instance.mesh.uv0))
        } else {
            Vec2::ZERO
        };
        let base = material.base_color
            * instance.base_color_texture.as_ref().map_or(Vec4::ONE, |t| t.sample(uv0));
        let emission = material.emissive
            * instance.emissive_texture.as_ref().map_or(Vec3::ONE, |t| t.sample(uv0).truncate());
        let [a, b, c] = world.corners;
        Surface {
            position: a * weights.x + b * weights.y + c * weights.z,
            normal: if back { -world.normal } else { world.normal },
            back,
            albedo: material.albedo(base.truncate()),
            emission,
            alpha: base.w,
            instance: world.instance,
            uv1: uv(&instance.mesh.uv1),
        }
    }
}

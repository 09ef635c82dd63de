//! One shadow map a light, as tight as the scene lets it be.

use bevy::{
    camera::primitives::Aabb,
    light::{Cascades, DirectionalLightShadowMap, NotShadowCaster, cascade::Cascade},
    math::Vec3A,
    prelude::*,
};

use crate::{ProgressiveCamera, ProgressiveLighting, lights::GroupLight};

/// Replaces the cascades that Bevy fits to what the camera might see by one that is fitted to what
/// there is: the part of the meshes' box that the camera can see up to the shadows' distance, as deep
/// as all that may cast a shadow into it.
pub(crate) fn fit(
    settings: Res<ProgressiveLighting>,
    shadow_map: Res<DirectionalLightShadowMap>,
    meshes: Query<
        (&GlobalTransform, &Aabb, &InheritedVisibility, Has<NotShadowCaster>),
        With<Mesh3d>,
    >,
    cameras: Query<(Entity, &GlobalTransform, &Projection, &Camera), With<ProgressiveCamera>>,
    mut lights: Query<(&GlobalTransform, &mut Cascades, &DirectionalLight), With<GroupLight>>,
) {
    if lights.is_empty() || !settings.shadows {
        return;
    }
    let corners: Vec<([Vec3A; 8], bool)> = meshes
        .iter()
        .filter(|(.., visibility, _)| visibility.get())
        .map(|(transform, aabb, _, casts_none)| (corners(transform, aabb), !casts_none))
        .collect();
    let cameras: Vec<_> = cameras.iter().filter(|(.., camera)| camera.is_active).collect();
    for (transform, mut cascades, light) in &mut lights {
        if !light.shadow_maps_enabled {
            continue;
        }
        let rotation = transform.rotation();
        let world_to_light = Mat3::from_quat(rotation.inverse());
        let mut scene = Bounds::EMPTY;
        let mut casters = Bounds::EMPTY;
        for (corners, casts) in &corners {
            let bounds = Bounds::of(corners.iter().map(|c| world_to_light * *c));
            scene = scene.union(&bounds);
            if *casts {
                casters = casters.union(&bounds);
            }
        }
        for (camera, camera_transform, projection, _) in &cameras {
            let far = settings.shadow_distance.max(0.1);
            let frustum = projection.get_frustum_corners(0.0, -far);
            let to_light = Mat4::from_quat(rotation.inverse()) * camera_transform.to_matrix();
            let seen = Bounds::of(frustum.iter().map(|c| to_light.transform_point3a(*c)));
            let cascade = cascade(rotation, &scene, &casters, &seen, shadow_map.size as f32);
            cascades.cascades.insert(*camera, vec![cascade]);
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Bounds {
    min: Vec3A,
    max: Vec3A,
}

impl Bounds {
    const EMPTY: Self = Self { min: Vec3A::MAX, max: Vec3A::MIN };

    fn of(points: impl Iterator<Item = Vec3A>) -> Self {
        points.fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }
}

fn corners(transform: &GlobalTransform, aabb: &Aabb) -> [Vec3A; 8] {
    std::array::from_fn(|i| {
        let side = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let corner = aabb.center + aabb.half_extents * Vec3A::new(side(0), side(1), side(2));
        transform.affine().transform_point3a(corner)
    })
}

/// A cascade of a light: `scene`, `casters` and `seen` are bounds in the light's frame, which looks
/// down -z.
fn cascade(rotation: Quat, scene: &Bounds, casters: &Bounds, seen: &Bounds, size: f32) -> Cascade {
    let min = scene.min.max(seen.min);
    let max = scene.max.min(seen.max);
    let (min, max) = if min.cmplt(max).all() { (min, max) } else { (Vec3A::ZERO, Vec3A::ONE) };
    // A texel more on every side, for the filter.
    let extent = ((max - min) * (1.0 + 8.0 / size)).max(Vec3A::splat(1e-3));
    let middle = 0.5 * (min + max);
    let near = casters.max.z.max(max.z) + 1e-3;
    let near = if near.is_finite() { near.min(max.z + 1e5) } else { max.z + 1.0 };
    let depth = (near - min.z) * 1.001 + 1e-3;
    let origin = Vec3::new(middle.x, middle.y, near);
    let world_from_cascade = Mat4::from_rotation_translation(rotation, rotation * origin);
    let cascade_from_world = Mat4::from_translation(-origin) * Mat4::from_quat(rotation.inverse());
    // Orthographic, reversed: 1 at the near plane.
    let clip_from_cascade = Mat4::from_cols(
        Vec4::new(2.0 / extent.x, 0.0, 0.0, 0.0),
        Vec4::new(0.0, 2.0 / extent.y, 0.0, 0.0),
        Vec4::new(0.0, 0.0, 1.0 / depth, 0.0),
        Vec4::new(0.0, 0.0, 1.0, 1.0),
    );
    Cascade {
        world_from_cascade,
        clip_from_cascade,
        clip_from_world: clip_from_cascade * cascade_from_world,
        texel_size: extent.x.max(extent.y) / size,
    }
}

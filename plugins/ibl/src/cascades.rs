//! One shadow map a light, as tight as the scene lets it be.

use bevy::{
    camera::{
        CameraProjection,
        primitives::Aabb,
        visibility::{NoFrustumCulling, RenderLayers},
    },
    light::{Cascades, DirectionalLightShadowMap, cascade::Cascade},
    math::Vec3A,
    prelude::*,
};

use crate::{
    ProgressiveCamera, ProgressiveLighting,
    lights::{Group, GroupLight},
};

/// Texels beyond what is shadowed, on every side: the filter reads 2.5 of them, the normal's bias
/// displaces by as many, the shift and the grid take one each.
const MARGIN: f32 = 7.0;
/// Normals' bias in texels, as Bevy has it by default: what a filter of five texels needs.
const NORMAL_BIAS: f32 = DirectionalLight::DEFAULT_SHADOW_NORMAL_BIAS;
/// Bias towards the light in texels. Bevy's is in metres, 2 cm: objects on a desk would float.
const DEPTH_BIAS: f32 = 0.5;
/// By how much shadows end nearer for some lights than for others, so that their end is no line.
const FADE: f32 = 0.25;

/// A mesh that is seen or casts shadows: its middle, and its half axes in the world.
struct Body<'a> {
    middle: Vec3A,
    axes: [Vec3A; 3],
    layers: &'a RenderLayers,
}

/// Replaces the cascades that Bevy fits to what the camera might see by one that is fitted to what
/// there is: the part of each mesh's box that the camera can see up to the shadows' distance. What
/// casts shadows into it from nearer to the light is drawn flat onto the near plane, as Bevy does.
pub(crate) fn fit(
    settings: Res<ProgressiveLighting>,
    shadow_map: Res<DirectionalLightShadowMap>,
    group: Res<Group>,
    meshes: Query<
        (
            &GlobalTransform,
            &Aabb,
            &InheritedVisibility,
            Option<&RenderLayers>,
            Has<NoFrustumCulling>,
        ),
        With<Mesh3d>,
    >,
    cameras: Query<
        (Entity, &GlobalTransform, &Projection, &Camera, Option<&RenderLayers>),
        With<ProgressiveCamera>,
    >,
    mut lights: Query<(&GlobalTransform, &mut Cascades, &mut DirectionalLight, &GroupLight)>,
) {
    if lights.is_empty() || !settings.shadows || group.cycle == 0 {
        return;
    }
    let bodies: Vec<Body> = meshes
        .iter()
        .filter(|(_, _, visibility, ..)| visibility.get())
        .map(|(transform, aabb, _, layers, moves)| body(transform, aabb, layers, moves))
        .filter(|body| body.middle.is_finite() && body.axes.iter().all(|axis| axis.is_finite()))
        .collect();
    let cameras: Vec<_> = cameras.iter().filter(|(.., camera, _)| camera.is_active).collect();
    for (transform, mut cascades, mut light, place) in &mut lights {
        if !light.shadow_maps_enabled {
            continue;
        }
        let sequence = Sequence::at(place.light as u32 + group.round());
        let frame = Frame::new(transform.rotation());
        let mut texel = 0.0_f32;
        cascades.cascades.clear();
        for (camera, camera_transform, projection, _, layers) in &cameras {
            let far = settings.shadow_distance.max(0.01) * (1.0 - FADE * sequence.fade);
            let corners = seen(projection, far);
            let seen = frame
                .bounds(corners.iter().map(|c| camera_transform.affine().transform_point3a(*c)));
            let layers = layers.unwrap_or_default();
            let shadowed = bodies
                .iter()
                .filter(|body| body.layers.intersects(layers))
                .map(|body| frame.body(body).intersection(&seen))
                .filter(Bounds::is_something)
                .fold(Bounds::NOTHING, |all, body| all.union(&body));
            let cascade = frame.cascade(&shadowed, shadow_map.size as f32, sequence.shift);
            texel = texel.max(cascade.texel_size);
            cascades.cascades.insert(*camera, vec![cascade]);
        }
        light.shadow_normal_bias = NORMAL_BIAS;
        light.shadow_depth_bias = DEPTH_BIAS * texel;
    }
}

/// What a camera sees, up to `far` metres; with a parallel projection its whole depth.
fn seen(projection: &Projection, far: f32) -> [Vec3A; 8] {
    match projection {
        Projection::Orthographic(parallel) => {
            parallel.get_frustum_corners(-parallel.near, -parallel.far)
        }
        other => other.get_frustum_corners(0.0, -far.min(other.far())),
    }
}

fn body<'a>(
    transform: &GlobalTransform,
    aabb: &Aabb,
    layers: Option<&'a RenderLayers>,
    moves: bool,
) -> Body<'a> {
    let affine = transform.affine();
    // Bones may carry a mesh out of its box.
    let half = if moves { 2.0 * aabb.half_extents } else { aabb.half_extents };
    let axis = |axis: Vec3A| affine.transform_vector3a(axis * half);
    Body {
        middle: affine.transform_point3a(aabb.center),
        axes: [axis(Vec3A::X), axis(Vec3A::Y), axis(Vec3A::Z)],
        layers: layers.unwrap_or_default(),
    }
}

/// Numbers that differ from light to light and from round to round, evenly spread: Roberts, "The
/// unreasonable effectiveness of quasirandom sequences" (2018), in three dimensions.
struct Sequence {
    /// Parts of texels, -0.5 to 0.5.
    shift: Vec2,
    /// 0 to 1.
    fade: f32,
}

impl Sequence {
    fn at(index: u32) -> Self {
        const STEPS: [f64; 3] =
            [0.819_172_513_396_164_5, 0.671_043_606_703_789_3, 0.549_700_477_901_971_3];
        let [x, y, fade] = STEPS.map(|step| (0.5 + step * f64::from(index)).fract() as f32);
        Self { shift: Vec2::new(x, y) - 0.5, fade }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Bounds {
    min: Vec3A,
    max: Vec3A,
}

impl Bounds {
    const NOTHING: Self = Self { min: Vec3A::MAX, max: Vec3A::MIN };

    fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    fn intersection(&self, other: &Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// A flat box is something, too.
    fn is_something(&self) -> bool {
        self.min.cmple(self.max).all()
    }
}

/// The frame of a light, which looks down -z.
struct Frame {
    rotation: Quat,
    to_light: Mat3,
}

impl Frame {
    fn new(rotation: Quat) -> Self {
        Self { rotation, to_light: Mat3::from_quat(rotation.inverse()) }
    }

    fn bounds(&self, points: impl Iterator<Item = Vec3A>) -> Bounds {
        points.map(|point| self.to_light * point).fold(Bounds::NOTHING, |bounds, point| Bounds {
            min: bounds.min.min(point),
            max: bounds.max.max(point),
        })
    }

    fn body(&self, body: &Body) -> Bounds {
        let middle = self.to_light * body.middle;
        let half = body.axes.iter().map(|axis| (self.to_light * *axis).abs()).sum::<Vec3A>();
        Bounds { min: middle - half, max: middle + half }
    }

    /// The map of what is shadowed, moved by `shift` texels.
    fn cascade(&self, shadowed: &Bounds, size: f32, shift: Vec2) -> Cascade {
        let finite = (shadowed.max - shadowed.min).is_finite() && shadowed.min.is_finite();
        let shadowed = if finite && shadowed.is_something() {
            *shadowed
        } else {
            Bounds { min: Vec3A::splat(-0.5), max: Vec3A::splat(0.5) }
        };
        let span = (shadowed.max - shadowed.min).max(Vec3A::splat(1e-3));
        // In steps, so that something small that moves does not make the whole map swim.
        let inner = (size - 2.0 * MARGIN).max(1.0);
        let texels = Vec2::new(step_up(span.x), step_up(span.y)) / inner;
        let extent = texels * size;
        let texel = texels.max_element();
        // On the grid of texels, and then between.
        let middle = 0.5 * (shadowed.min + shadowed.max).truncate();
        let middle = ((middle / texels).floor() + shift + 0.5) * texels;
        // What is displaced by the biases still lies below the near plane.
        let bias = (std::f32::consts::SQRT_2 * NORMAL_BIAS + DEPTH_BIAS + 1.0) * texel;
        let near = shadowed.max.z + bias + 1e-3 * span.z;
        let depth = near - shadowed.min.z + texel + 1e-3 * span.z;
        let origin = Vec3::new(middle.x, middle.y, near);
        let cascade_from_world =
            Mat4::from_translation(-origin) * Mat4::from_quat(self.rotation.inverse());
        // Orthographic, reversed: 1 at the near plane.
        let clip_from_cascade = Mat4::from_cols(
            Vec4::new(2.0 / extent.x, 0.0, 0.0, 0.0),
            Vec4::new(0.0, 2.0 / extent.y, 0.0, 0.0),
            Vec4::new(0.0, 0.0, 1.0 / depth, 0.0),
            Vec4::new(0.0, 0.0, 1.0, 1.0),
        );
        Cascade {
            world_from_cascade: Mat4::from_rotation_translation(
                self.rotation,
                self.rotation * origin,
            ),
            clip_from_cascade,
            clip_from_world: clip_from_cascade * cascade_from_world,
            texel_size: texel,
        }
    }
}

/// The next of sixteen steps between powers of two.
fn step_up(length: f32) -> f32 {
    let step = length.log2().floor().exp2() / 16.0;
    (length / step).ceil() * step
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: f32 = 512.0;

    fn frame(direction: Vec3) -> Frame {
        Frame::new(Transform::default().looking_to(direction, Vec3::X).rotation)
    }

    fn boxed(min: Vec3, max: Vec3) -> Body<'static> {
        let aabb = Aabb::from_min_max(min, max);
        body(&GlobalTransform::IDENTITY, &aabb, None, false)
    }

    #[test]
    fn what_is_shadowed_lies_in_the_map_with_its_margin() {
        let body = boxed(Vec3::new(-1.0, 0.0, -2.0), Vec3::new(3.0, 1.0, 2.5));
        for direction in [Vec3::NEG_Y, Vec3::new(0.3, -0.2, 0.9).normalize(), Vec3::NEG_Z] {
            let frame = frame(direction);
            let bounds = frame.body(&body);
            let shift = Vec2::splat(0.5);
            let cascade = frame.cascade(&bounds, SIZE, shift);
            let edge = 1.0 - 2.0 * (MARGIN - 2.0) / SIZE;
            for i in 0..8 {
                let pick = |bit: usize, axis: usize| {
                    if i >> bit & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] }
                };
                let world = frame.rotation * Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2));
                let clip = cascade.clip_from_world.project_point3(world);
                assert!(clip.truncate().abs().max_element() < edge, "{direction}: {clip}");
                assert!((0.0..1.0).contains(&clip.z), "{direction}: {clip}");
                // Bevy composes both matrices elsewhere.
                let view = cascade.world_from_cascade.inverse().transform_point3(world);
                let same = cascade.clip_from_cascade.project_point3(view);
                assert!(clip.abs_diff_eq(same, 1e-4), "{clip} {same}");
            }
            let wide = (bounds.max - bounds.min).truncate().max_element();
            assert!(cascade.texel_size * SIZE < wide * 1.12, "{direction} is not tight");
        }
    }

    #[test]
    fn a_floor_of_two_kilometres_is_shadowed_where_it_is_seen() {
        let floor = boxed(Vec3::new(-1000.0, 0.0, -1000.0), Vec3::new(1000.0, 0.0, 1000.0));
        let frame = frame(Vec3::new(0.5, -1.0, 0.2).normalize());
        let camera = Transform::from_xyz(0.0, 2.0, 0.0).to_matrix();
        let projection = Projection::default();
        let corners = seen(&projection, 20.0);
        let seen = frame.bounds(corners.iter().map(|c| camera.transform_point3a(*c)));
        let cascade = frame.cascade(&frame.body(&floor).intersection(&seen), SIZE, Vec2::ZERO);
        assert!(cascade.texel_size < 2.0 * 20.0 / SIZE, "{}", cascade.texel_size);
    }

    #[test]
    fn whatever_the_bounds_the_map_is_finite() {
        let frame = frame(Vec3::NEG_Y);
        let nan = Vec3A::NAN;
        let far = Vec3A::splat(3e38);
        let point = Vec3A::splat(5.0);
        for bounds in [
            Bounds::NOTHING,
            Bounds { min: nan, max: nan },
            Bounds { min: -far, max: Vec3A::INFINITY },
            Bounds { min: -far, max: far },
            Bounds { min: point, max: point },
        ] {
            let cascade = frame.cascade(&bounds, SIZE, Vec2::ZERO);
            assert!(cascade.clip_from_world.is_finite() && cascade.texel_size > 0.0, "{bounds:?}");
        }
    }

    #[test]
    fn something_small_that_moves_leaves_the_map_as_it_is() {
        let frame = frame(Vec3::new(0.3, -1.0, 0.1).normalize());
        let map = |height: f32| {
            let floor = frame.body(&boxed(Vec3::new(-4.0, 0.0, -4.0), Vec3::new(4.0, 0.0, 4.0)));
            let ball = frame
                .body(&boxed(Vec3::new(-0.5, height, -0.5), Vec3::new(0.5, height + 1.0, 0.5)));
            frame.cascade(&floor.union(&ball), SIZE, Vec2::ZERO).clip_from_world.to_cols_array_2d()
        };
        for (before, after) in map(0.0).iter().zip(map(0.3)) {
            assert_eq!(before[..2], after[..2], "across the map nothing changes");
        }
    }

    #[test]
    fn a_light_meets_every_part_of_a_texel() {
        let mut met = [0; 4];
        for round in 0..32 {
            let Sequence { shift, fade } = Sequence::at(17 + round);
            assert!(shift.abs().max_element() <= 0.5 && (0.0..1.0).contains(&fade));
            met[usize::from(shift.x > 0.0) + 2 * usize::from(shift.y > 0.0)] += 1;
        }
        assert!(met.iter().all(|n| (6..=10).contains(n)), "{met:?}");
    }
}

//! Simple controllers with rays, so that hands are seen and it is seen where they point.

use std::f32::consts::FRAC_PI_2;

use bevy::{
    light::{NotShadowCaster, NotShadowReceiver},
    prelude::*,
};
use farlight_bindings::{Hand, Profile};
use farlight_controls::XrControllers;

use crate::XrHandPose;

/// How long a ray is that meets nothing, in metres.
const LENGTH: f32 = 1.5;

/// The drawn controller of a hand; below the entity that follows the grip. Hide or replace it at will.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Transform, Visibility)]
pub struct XrControllerModel {
    /// Which.
    pub hand: Hand,
    /// What kind it was made for.
    pub profile: Profile,
}

/// The drawn ray of a hand; below the entity that follows where it points.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[require(Transform, Visibility)]
pub struct XrRay {
    /// Which.
    pub hand: Hand,
    /// How long it is drawn, in metres: up to what it meets.
    pub length: f32,
}

pub(crate) fn build(app: &mut App, wanted: bool) {
    let has_scene =
        resource_exists::<Assets<StandardMaterial>>.and_then(resource_exists::<Assets<Mesh>>);
    app.add_systems(PostUpdate, stretch.before(TransformSystems::Propagate));
    if wanted {
        app.add_systems(Update, make.run_if(has_scene));
    }
}

/// Gives hands their controllers, and others when others are taken up.
fn make(
    controllers: Res<XrControllers>,
    poses: Query<(Entity, &XrHandPose)>,
    models: Query<(Entity, &XrControllerModel)>,
    rays: Query<&XrRay>,
    mut shapes: Local<Option<Shapes>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut commands: Commands,
) {
    for (entity, pose) in &poses {
        let Some(profile) = controllers.hand(pose.hand).profile else { continue };
        let known = models.iter().find(|(_, model)| model.hand == pose.hand);
        let is_there = if pose.aim {
            rays.iter().any(|ray| ray.hand == pose.hand)
        } else {
            known.is_some_and(|(_, model)| model.profile == profile)
        };
        if is_there {
            continue;
        }
        let shapes = shapes.get_or_insert_with(|| Shapes::new(&mut meshes, &mut materials));
        if pose.aim {
            let ray = XrRay { hand: pose.hand, length: LENGTH };
            let looks = (Mesh3d(shapes.ray.clone()), MeshMaterial3d(shapes.light.clone()));
            commands.spawn((ray, looks, NotShadowCaster, NotShadowReceiver, ChildOf(entity)));
            continue;
        }
        if let Some((old, _)) = known {
            commands.entity(old).despawn();
        }
        let model = XrControllerModel { hand: pose.hand, profile };
        let mut model = commands.spawn((model, ChildOf(entity)));
        model.with_children(|parts| {
            for (mesh, place) in shapes.parts(profile) {
                let body = MeshMaterial3d(shapes.body.clone());
                parts.spawn((Mesh3d(mesh.clone()), body, place, NotShadowCaster));
            }
        });
    }
}

fn stretch(mut rays: Query<(&XrRay, &mut Transform), Changed<XrRay>>) {
    for (ray, mut transform) in &mut rays {
        transform.scale = Vec3::new(1.0, 1.0, ray.length.clamp(0.0, 100.0).max(1e-3));
    }
}

struct Shapes {
    handle: Handle<Mesh>,
    head: Handle<Mesh>,
    ring: Handle<Mesh>,
    fingertip: Handle<Mesh>,
    /// One metre along -z.
    ray: Handle<Mesh>,
    body: Handle<StandardMaterial>,
    light: Handle<StandardMaterial>,
}

impl Shapes {
    fn new(meshes: &mut Assets<Mesh>, materials: &mut Assets<StandardMaterial>) -> Self {
        let ray = Cone { radius: 0.003, height: 1.0 }
            .mesh()
            .resolution(8)
            .build()
            .rotated_by(Quat::from_rotation_x(-FRAC_PI_2))
            .translated_by(Vec3::NEG_Z * 0.5);
        Self {
            handle: meshes.add(Capsule3d::new(0.017, 0.075).mesh().latitudes(8).longitudes(16)),
            head: meshes.add(Cylinder::new(0.024, 0.014).mesh().resolution(24)),
            ring: meshes.add(Torus::new(0.034, 0.044).mesh().major_resolution(32)),
            fingertip: meshes.add(Sphere::new(0.01).mesh().uv(16, 8)),
            ray: meshes.add(ray),
            body: materials.add(StandardMaterial {
                base_color: Color::srgb(0.16, 0.17, 0.19),
                perceptual_roughness: 0.55,
                ..default()
            }),
            // Opaque: what has no depth leaves trails in pictures that refine themselves.
            light: materials.add(StandardMaterial {
                base_color: Color::srgb(0.45, 0.7, 0.95),
                unlit: true,
                ..default()
            }),
        }
    }

    /// What a controller is made of, in the grip's space: -z along the handle to the front.
    fn parts(&self, profile: Profile) -> Vec<(&Handle<Mesh>, Transform)> {
        let along = Quat::from_rotation_x(FRAC_PI_2);
        let tilt = Quat::from_rotation_x(0.5);
        let handle = Transform::from_rotation(along);
        let head = Transform::from_xyz(0.0, 0.016, -0.058).with_rotation(along * tilt);
        let ring = |lift: f32| Transform::from_xyz(0.0, lift, -0.07).with_rotation(along * tilt);
        match profile {
            Profile::Hands => vec![(&self.fingertip, Transform::default())],
            Profile::Simple => vec![(&self.handle, handle)],
            Profile::Vive => vec![(&self.handle, handle), (&self.ring, ring(0.0))],
            Profile::Touch => {
                vec![(&self.handle, handle), (&self.head, head), (&self.ring, ring(0.03))]
            }
            Profile::Index => vec![(&self.handle, handle), (&self.head, head)],
        }
    }
}

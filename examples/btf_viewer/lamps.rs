//! Lamps: one or five point lights, a sun, a spot.

use bevy::{light::CascadeShadowConfigBuilder, prelude::*};

use super::{config::Rig, shown::Shown, stage::Stage, state::Config};

/// Metres from the object's middle.
const DISTANCE: f32 = 3.0;

/// Holds the lamps. The key light stands on its +z axis.
#[derive(Component)]
pub struct LampRig(Option<(Rig, f32)>);

/// Direction in the rig, share of the key light's illuminance, colour.
const FIVE: [([f32; 3], f32, [f32; 3]); 5] = [
    ([0.0, 0.0, 1.0], 0.7, [1.0, 0.95, 0.88]),
    ([-1.0, -0.2, 0.5], 0.25, [0.80, 0.88, 1.0]),
    ([-0.7, 0.2, -0.9], 0.55, [0.85, 0.92, 1.0]),
    ([0.9, 0.1, -0.7], 0.45, [1.0, 0.86, 0.72]),
    ([-0.2, 1.0, 0.1], 0.25, [1.0, 1.0, 1.0]),
];

/// Makes the empty rig.
pub fn spawn(mut commands: Commands) {
    commands.spawn((LampRig(None), Transform::default(), Visibility::default()));
}

/// Hangs and turns the lamps.
pub fn hang(
    mut commands: Commands,
    config: Res<Config>,
    shown: Res<Shown>,
    stage: Res<Stage>,
    rig: Single<(Entity, &mut LampRig, &mut Transform)>,
) {
    let (entity, mut hung, mut transform) = rig.into_inner();
    let (turn, height) = (shown.light.turn, shown.light.height);
    let rotation = Quat::from_euler(EulerRot::YXZ, turn.to_radians(), -height.to_radians(), 0.0);
    transform.set_if_neq(Transform::from_translation(stage.middle).with_rotation(rotation));
    let wanted = (shown.light.lamps, config.0.light.illuminance);
    if hung.0 == Some(wanted) {
        return;
    }
    hung.0 = Some(wanted);
    commands.entity(entity).despawn_related::<Children>();
    let lux = config.0.light.illuminance;
    let at = |direction: [f32; 3]| {
        Transform::from_translation(Vec3::from(direction).normalize() * DISTANCE)
            .looking_at(Vec3::ZERO, Vec3::Y)
    };
    // Lumens of a point light that gives so many lux at the middle.
    let lumens = |lux: f32| lux * DISTANCE * DISTANCE * 4.0 * std::f32::consts::PI;
    let point = |direction, share: f32, [red, green, blue]: [f32; 3]| {
        let lamp = PointLight {
            color: Color::linear_rgb(red, green, blue),
            intensity: lumens(lux * share),
            range: 30.0,
            shadow_maps_enabled: true,
            shadow_depth_bias: 0.02,
            ..default()
        };
        (ChildOf(entity), lamp, at(direction))
    };
    match shown.light.lamps {
        Rig::None => {}
        Rig::Point => {
            commands.spawn(point([0.0, 0.0, 1.0], 1.0, [1.0; 3]));
        }
        Rig::Five => {
            for (direction, share, colour) in FIVE {
                commands.spawn(point(direction, share, colour));
            }
        }
        Rig::Sun => {
            let cascades =
                CascadeShadowConfigBuilder { num_cascades: 1, maximum_distance: 12.0, ..default() };
            let sun = DirectionalLight { illuminance: lux, shadow_maps_enabled: true, ..default() };
            commands.spawn((ChildOf(entity), sun, cascades.build(), at([0.0, 0.0, 1.0])));
        }
        Rig::Spot => {
            let spot = SpotLight {
                intensity: lumens(lux),
                range: 30.0,
                inner_angle: 0.22,
                outer_angle: 0.32,
                shadow_maps_enabled: true,
                ..default()
            };
            commands.spawn((ChildOf(entity), spot, at([0.0, 0.0, 1.0])));
        }
    }
}

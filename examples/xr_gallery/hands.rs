//! What hands show and feel: ticks on the panel, and the arc of a teleport.

use bevy::{
    light::{NotShadowCaster, NotShadowReceiver},
    prelude::*,
};
use farlight::{
    controls::bindings::Hand,
    panel::PanelRay,
    xr::{Haptic, XrRay},
};

use super::moving::Aiming;

/// Beads of the arc.
const BEADS: usize = 28;

/// A bead of the arc, counted from the hand.
#[derive(Component)]
struct Bead(usize);

/// The ring on the floor where one would land.
#[derive(Component)]
pub struct Marker;

/// Systems of what hands show.
pub fn plugin(app: &mut App) {
    app.add_systems(Startup, spawn)
        .add_systems(Update, (feel, hide_ray))
        .add_systems(PostUpdate, draw_arc.before(TransformSystems::Propagate));
}

/// A tick when a ray comes onto a panel, and when it presses there.
fn feel(
    rays: Query<&PanelRay>,
    mut before: Local<[(bool, bool); 2]>,
    mut haptics: MessageWriter<Haptic>,
) {
    for ray in &rays {
        let Some(hand) = ray.hand else { continue };
        let now = (ray.hit.is_some(), ray.pressed);
        let before = std::mem::replace(&mut before[hand as usize], now);
        if now.0 && !before.0 {
            haptics.write(Haptic { amplitude: 0.2, ..Haptic::tick(hand) });
        }
        if now.0 && now.1 && !before.1 {
            haptics.write(Haptic::tick(hand));
        }
    }
}

/// An arc takes the ray's place.
fn hide_ray(aiming: Res<Aiming>, mut rays: Query<(&XrRay, &mut Visibility)>) {
    for (ray, mut visibility) in &mut rays {
        let aims = ray.hand == Hand::Left && aiming.0.is_some();
        visibility.set_if_neq(if aims { Visibility::Hidden } else { Visibility::Inherited });
    }
}

/// The colours of an arc that lands, and of one that doesn't.
#[derive(Resource)]
struct Colours {
    lands: Handle<StandardMaterial>,
    fails: Handle<StandardMaterial>,
}

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut light = |r: f32, g: f32, b: f32| {
        materials.add(StandardMaterial {
            base_color: Color::linear_rgb(r, g, b),
            unlit: true,
            fog_enabled: false,
            ..default()
        })
    };
    let colours = Colours { lands: light(0.20, 0.75, 0.85), fails: light(0.75, 0.16, 0.08) };
    let bead = meshes.add(Sphere::new(0.011).mesh().uv(16, 8));
    let helper = (NotShadowCaster, NotShadowReceiver, Visibility::Hidden);
    for i in 0..BEADS {
        let looks = (Mesh3d(bead.clone()), MeshMaterial3d(colours.lands.clone()));
        commands.spawn((Bead(i), looks, helper.clone()));
    }
    let ring = meshes.add(Torus::new(0.26, 0.29).mesh().minor_resolution(12).major_resolution(64));
    let dot = meshes.add(Cylinder::new(0.05, 0.006).mesh().resolution(32));
    commands
        .spawn((Marker, Transform::default(), Visibility::Hidden))
        .with_child((
            Mesh3d(ring),
            MeshMaterial3d(colours.lands.clone()),
            Transform::from_scale(Vec3::new(1.0, 0.35, 1.0)),
            NotShadowCaster,
            NotShadowReceiver,
        ))
        .with_child((
            Mesh3d(dot),
            MeshMaterial3d(colours.lands.clone()),
            Transform::from_xyz(0.0, 0.004, 0.0),
            NotShadowCaster,
            NotShadowReceiver,
        ));
    commands.insert_resource(colours);
}

fn draw_arc(
    aiming: Res<Aiming>,
    colours: Res<Colours>,
    mut beads: Query<
        (&Bead, &mut Transform, &mut Visibility, &mut MeshMaterial3d<StandardMaterial>),
        Without<Marker>,
    >,
    mut markers: Query<(&mut Transform, &mut Visibility), With<Marker>>,
) {
    if !aiming.is_changed() {
        return;
    }
    let arc = aiming.0.as_ref().filter(|arc| arc.points.len() > 1);
    let landing = arc.and_then(|arc| arc.landing);
    for (bead, mut transform, mut visibility, mut material) in &mut beads {
        let Some(arc) = arc else {
            visibility.set_if_neq(Visibility::Hidden);
            continue;
        };
        // Evenly along the arc, none in the hand itself.
        let at = (bead.0 + 1) as f32 / BEADS as f32 * (arc.points.len() - 1) as f32;
        let (from, part) = (at as usize, at.fract());
        let next = arc.points[(from + 1).min(arc.points.len() - 1)];
        transform.translation = arc.points[from].lerp(next, part);
        visibility.set_if_neq(Visibility::Visible);
        let colour = if landing.is_some() { &colours.lands } else { &colours.fails };
        if material.0 != *colour {
            material.0 = colour.clone();
        }
    }
    for (mut transform, mut visibility) in &mut markers {
        if let Some(landing) = landing {
            transform.translation = landing + Vec3::Y * 0.012;
        }
        visibility.set_if_neq(if landing.is_some() {
            Visibility::Visible
        } else {
            Visibility::Hidden
        });
    }
}

//! An object, a light and a camera that follow the actions.

use std::f32::consts::FRAC_PI_2;

use bevy::prelude::*;
use farlight::controls::{Controls, actions::*};

/// What is shown.
#[derive(Resource, Clone, Debug)]
pub struct Shown {
    /// Which of [`COLOURS`].
    material: usize,
    /// Which of the shapes.
    model: usize,
    /// Which of [`SKIES`].
    sky: usize,
    /// Stops above the usual light.
    stops: f32,
    /// Whether there is a plinth.
    plinth: bool,
    /// Whether the object turns by itself.
    turning: bool,
    object: Quat,
    /// Angles of the light, radians.
    light: Vec2,
    /// Angles of the camera, radians.
    look: Vec2,
    /// Metres from what is looked at.
    distance: f32,
    target: Vec3,
}

impl Default for Shown {
    fn default() -> Self {
        Self {
            material: 0,
            model: 0,
            sky: 0,
            stops: 0.0,
            plinth: true,
            turning: false,
            object: Quat::from_rotation_x(0.5) * Quat::from_rotation_y(0.4),
            light: Vec2::new(0.7, 0.9),
            look: Vec2::new(-0.45, 0.35),
            distance: 6.6,
            target: Vec3::new(0.0, -0.1, 0.0),
        }
    }
}

/// Base colours, metallic, roughness.
const COLOURS: &[([f32; 3], f32, f32)] = &[
    ([0.90, 0.36, 0.16], 0.0, 0.35),
    ([0.95, 0.78, 0.40], 1.0, 0.25),
    ([0.16, 0.46, 0.60], 0.0, 0.6),
    ([0.86, 0.86, 0.84], 1.0, 0.4),
];

/// Ambient light and background.
const SKIES: &[([u8; 3], f32)] =
    &[([20, 22, 27], 300.0), ([52, 64, 84], 700.0), ([66, 48, 44], 500.0)];

/// The object.
#[derive(Component)]
pub struct Object;

/// What it stands on.
#[derive(Component)]
pub struct Plinth;

/// Its shapes.
#[derive(Resource)]
pub struct Shapes(Vec<Handle<Mesh>>);

/// Makes it all.
pub fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let shapes = vec![
        meshes.add(Torus::new(0.45, 0.95).mesh().major_resolution(96).minor_resolution(48)),
        meshes.add(Cuboid::from_length(1.2)),
        meshes.add(Cone { radius: 0.75, height: 1.4 }.mesh().resolution(96)),
        meshes.add(Sphere::new(0.8).mesh().uv(96, 48)),
    ];
    commands.spawn((
        Object,
        Mesh3d(shapes[0].clone()),
        MeshMaterial3d(materials.add(StandardMaterial::default())),
        Transform::from_xyz(0.0, 0.45, 0.0),
    ));
    commands.insert_resource(Shapes(shapes));
    commands.spawn((
        Plinth,
        Mesh3d(meshes.add(Cylinder::new(1.7, 0.2).mesh().resolution(128))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.19, 0.20, 0.23),
            perceptual_roughness: 0.85,
            ..default()
        })),
        Transform::from_xyz(0.0, -1.0, 0.0),
    ));
    commands
        .spawn((DirectionalLight { shadow_maps_enabled: true, ..default() }, Transform::default()));
    commands.spawn((Camera3d::default(), Transform::default(), Msaa::Sample4, IsDefaultUiCamera));
}

/// Does what the actions say.
pub fn act(controls: Controls, mut shown: ResMut<Shown>, time: Res<Time>) {
    let cycle = |at: &mut usize, forth: bool, back: bool, of: usize| {
        *at = (*at + of + usize::from(forth) - usize::from(back)) % of;
    };
    let s = &mut *shown;
    let (next, back) = (controls.started::<NextMaterial>(), controls.started::<PreviousMaterial>());
    cycle(&mut s.material, next, back, COLOURS.len());
    let (next, back) = (controls.started::<NextModel>(), controls.started::<PreviousModel>());
    cycle(&mut s.model, next, back, 4);
    let next = controls.started::<NextEnvironment>();
    cycle(&mut s.sky, next, controls.started::<PreviousEnvironment>(), SKIES.len());
    s.stops += f32::from(
        i8::from(controls.started::<Brighter>()) - i8::from(controls.started::<Darker>()),
    ) * 0.5;
    s.stops = s.stops.clamp(-4.0, 4.0);
    s.plinth ^= controls.started::<ToggleFloor>();
    s.turning ^= controls.started::<ToggleTurning>();

    let turn = |degrees: Vec2| Vec2::new(degrees.x.to_radians(), degrees.y.to_radians());
    let look = turn(controls.axis2::<Orbit>());
    s.look.x -= look.x;
    s.look.y = (s.look.y - look.y).clamp(-1.4, 1.4);
    let by = turn(controls.axis2::<RotateObject>());
    let facing = Quat::from_rotation_y(s.look.x);
    let right = facing * Vec3::X;
    s.object = Quat::from_rotation_y(by.x) * Quat::from_axis_angle(right, -by.y) * s.object;
    if s.turning {
        s.object = Quat::from_rotation_y(0.6 * time.delta_secs()) * s.object;
    }
    s.light += turn(controls.axis2::<RotateEnvironment>());
    s.light.y = s.light.y.clamp(0.1, FRAC_PI_2);
    s.distance = (s.distance * 0.9f32.powf(controls.axis::<Zoom>())).clamp(1.5, 20.0);
    let pan = controls.axis2::<Pan>() * s.distance / 1000.0;
    let walk = controls.axis2::<Walk>();
    s.target += facing * Vec3::new(walk.x - pan.x, 0.0, -walk.y);
    s.target.y += controls.axis::<Rise>() - pan.y;
    s.target = s.target.clamp(Vec3::splat(-5.0), Vec3::splat(5.0));
    if controls.started::<Recentre>() {
        let start = Shown::default();
        (s.look, s.distance, s.target) = (start.look, start.distance, start.target);
    }
}

/// Shows it.
pub fn apply(
    shown: Res<Shown>,
    shapes: Res<Shapes>,
    mut object: Single<
        (&mut Mesh3d, &MeshMaterial3d<StandardMaterial>, &mut Transform),
        With<Object>,
    >,
    mut plinth: Single<&mut Visibility, With<Plinth>>,
    mut light: Single<(&mut DirectionalLight, &mut Transform), Without<Object>>,
    mut camera: Single<
        &mut Transform,
        (With<Camera3d>, Without<Object>, Without<DirectionalLight>),
    >,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut clear: ResMut<ClearColor>,
    mut ambient: ResMut<GlobalAmbientLight>,
) {
    let (mesh, material, transform) = &mut *object;
    mesh.0 = shapes.0[shown.model].clone();
    transform.rotation = shown.object;
    if let Some(mut material) = materials.get_mut(&material.0) {
        let ([r, g, b], metallic, roughness) = COLOURS[shown.material];
        material.base_color = Color::srgb(r, g, b);
        (material.metallic, material.perceptual_roughness) = (metallic, roughness);
    }
    **plinth = if shown.plinth { Visibility::Inherited } else { Visibility::Hidden };
    let (light, sun) = &mut *light;
    light.illuminance = 9000.0 * shown.stops.exp2();
    sun.rotation = Quat::from_euler(EulerRot::YXZ, shown.light.x, -shown.light.y, 0.0);
    let look = Quat::from_euler(EulerRot::YXZ, shown.look.x, -shown.look.y, 0.0);
    camera.translation = shown.target + look * Vec3::Z * shown.distance;
    camera.rotation = look;
    let ([r, g, b], brightness) = SKIES[shown.sky];
    clear.0 = Color::srgb_u8(r, g, b);
    ambient.brightness = brightness;
}

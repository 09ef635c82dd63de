//! What is drawn: balls on a floor, under five lights with shadows.

use bevy::{
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass},
    prelude::*,
    render::{camera::TemporalJitter, diagnostic::RenderDiagnosticsPlugin},
};
use farlight::{
    ibl::{IblPlugin, ProgressiveCamera, ProgressiveLighting, Refinement},
    prelude::DerivedLight,
};
use serde::Serialize;

/// Lights a frame, and in all.
const PER_FRAME: u32 = 5;
const LIGHTS: u32 = 200;
/// How far shadows reach, in metres.
const FAR: f32 = 20.0;

/// Which app it is.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Subject {
    /// Five lights as they are drawn, without prepasses; the camera stands still.
    Plain,
    /// The camera sways.
    PlainSwaying,
    /// A still picture that goes on refining.
    Refining,
    /// A swaying camera, what is kept moves along.
    RefiningSwaying,
    /// A refined picture.
    Resting,
}

impl Subject {
    pub(crate) const ALL: [Self; 5] =
        [Self::Plain, Self::PlainSwaying, Self::Refining, Self::RefiningSwaying, Self::Resting];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::PlainSwaying => "plain, swaying",
            Self::Refining => "refining",
            Self::RefiningSwaying => "refining, swaying",
            Self::Resting => "resting",
        }
    }

    /// What it is compared with.
    pub(crate) fn beside(self) -> Self {
        match self {
            Self::Plain | Self::Refining => Self::Plain,
            Self::PlainSwaying | Self::RefiningSwaying => Self::PlainSwaying,
            Self::Resting => Self::Refining,
        }
    }

    fn sways(self) -> bool {
        matches!(self, Self::PlainSwaying | Self::RefiningSwaying)
    }
}

/// The scene of one subject.
pub(crate) fn build(app: &mut App, subject: Subject) {
    app.add_plugins((IblPlugin, RenderDiagnosticsPlugin))
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(subject)
        .add_systems(Startup, setup)
        .add_systems(Update, sway);
}

fn setup(
    mut commands: Commands,
    subject: Res<Subject>,
    server: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(12.0, 12.0))),
        MeshMaterial3d(materials.add(StandardMaterial::from(Color::srgb(0.7, 0.7, 0.7)))),
    ));
    let ball = meshes.add(Sphere::new(0.4).mesh().uv(48, 24));
    for i in 0..49 {
        let (x, z) = ((i % 7) as f32 - 3.0, (i / 7) as f32 - 3.0);
        let material = materials.add(StandardMaterial {
            base_color: Color::hsl(i as f32 * 37.0 % 360.0, 0.6, 0.5),
            perceptual_roughness: 0.3 + 0.1 * (i % 7) as f32,
            ..default()
        });
        commands.spawn((
            Mesh3d(ball.clone()),
            MeshMaterial3d(material),
            Transform::from_xyz(x * 1.3, 0.4, z * 1.3),
        ));
    }
    let place = Transform::from_xyz(0.0, 3.5, 7.0).looking_at(Vec3::ZERO, Vec3::Y);
    let accumulate = !matches!(*subject, Subject::Plain | Subject::PlainSwaying);
    let rest = *subject == Subject::Resting;
    let camera = commands
        .spawn((ProgressiveCamera { accumulate, rest, ..default() }, Msaa::Off, place))
        .id();
    if !accumulate {
        // The same lights with the same shadows, but what a plain camera has.
        commands.entity(camera).remove::<(DepthPrepass, MotionVectorPrepass, TemporalJitter)>();
    }
    commands.insert_resource(ProgressiveLighting {
        environment: Some(server.load("environments/sky.hdr")),
        brightness: 4000.0,
        lights: LIGHTS,
        per_frame: PER_FRAME,
        shadow_distance: FAR,
        ..default()
    });
}

fn sway(
    subject: Res<Subject>,
    time: Res<Time>,
    mut camera: Single<&mut Transform, With<Camera3d>>,
) {
    if subject.sways() {
        let t = time.elapsed_secs();
        let eye = Vec3::new(0.3 * (1.9 * t).sin(), 3.5 + 0.1 * (2.7 * t).sin(), 7.0);
        **camera = Transform::from_translation(eye).looking_at(Vec3::ZERO, Vec3::Y);
    }
}

/// Whether the app does what it is called.
pub(crate) fn check(world: &mut World, subject: Subject) -> Result<(), String> {
    let lights = world
        .query_filtered::<&ViewVisibility, (With<DirectionalLight>, With<DerivedLight>)>()
        .iter(world)
        .filter(|visibility| visibility.get())
        .count();
    let refinement = world.query::<&Refinement>().iter(world).next().copied();
    let fine = match (subject, refinement) {
        (Subject::Plain | Subject::PlainSwaying, Some(r)) => {
            lights == PER_FRAME as usize && r.frames == 0
        }
        (Subject::Refining, Some(r)) => lights == PER_FRAME as usize && r.frames > 0,
        (Subject::RefiningSwaying, Some(r)) => lights == PER_FRAME as usize && r.frames == 0,
        (Subject::Resting, Some(r)) => r.is_refined(),
        _ => false,
    };
    fine.then_some(()).ok_or(format!("{}: {lights} lights, {refinement:?}", subject.name()))
}

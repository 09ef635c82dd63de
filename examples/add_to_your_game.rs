//! The shortest use: tag the root of a scene, and it is lit indirectly.

use bevy::{camera::Exposure, prelude::*};
use farlight::prelude::*;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, FarlightPlugins))
        .insert_resource(GlobalAmbientLight::NONE)
        .add_systems(Startup, setup)
        .run()
}

pub(crate) fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    // Everything below the tag blocks, reflects and receives light. It may load later.
    commands.spawn((GiScene, WorldAssetRoot(assets.load("scenes/doorway.glb#Scene0"))));

    // Bevy's own lights. Move them: the indirect light follows.
    commands.spawn((
        PointLight { intensity: 2_000.0, shadow_maps_enabled: true, ..default() },
        Transform::from_xyz(-1.2, 2.2, 0.8),
    ));

    // What moves is lit by the probes of a box around its ways.
    commands.spawn((
        GiProbeVolume { resolution: UVec3::new(10, 3, 5) },
        Transform::from_xyz(0.0, 1.5, 0.0).with_scale(Vec3::new(10.0, 3.0, 5.0)),
    ));

    commands.spawn((
        Camera3d::default(),
        Exposure { ev100: 2.0 },
        Transform::from_xyz(4.6, 1.7, 2.0).looking_at(Vec3::new(0.0, 1.2, 0.3), Vec3::Y),
    ));
}

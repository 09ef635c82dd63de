//! The game's own lights are never evicted or changed.

use bevy::{
    light::{FogVolume, VolumetricFog, VolumetricLight},
    prelude::*,
};
use farlight::{ibl::environment_maps::Environment, prelude::*};

use crate::stage::{Stage, save};

/// Light of the environment that takes places but can't be seen.
const INVISIBLE: f32 = 1e-9;

fn stage() -> (Stage, Entity) {
    let mut stage = Stage::new();
    stage.ball();
    let map = Environment::from_equirect(16, 8, vec![Vec3::ONE; 128]).unwrap();
    let settings = ProgressiveLighting { lights: 23, brightness: INVISIBLE, ..default() };
    stage.light(map, settings);
    let camera = stage.camera(Vec3::new(0.0, 2.0, 3.0), Vec3::new(0.0, 0.3, 0.0));
    // Not moved by parts of pixels: pictures are equal to the bit.
    let shown = ProgressiveCamera { accumulate: false, ..default() };
    stage.world().entity_mut(camera).insert(shown);
    (stage, camera)
}

/// Directional lights of all directions, every second or each of them with shadows of four cascades.
fn own(stage: &mut Stage, count: usize, with_shadows: impl Fn(usize) -> bool) -> Vec<Entity> {
    let one = |i: usize| {
        let turned = Quat::from_rotation_y(i as f32 * 0.7) * Quat::from_rotation_x(-0.9);
        let light = DirectionalLight {
            illuminance: 0.5 + 0.1 * i as f32,
            color: Color::hsl(30.0 * i as f32, 0.8, 0.5),
            shadow_maps_enabled: with_shadows(i),
            ..default()
        };
        (light, Transform::from_rotation(turned))
    };
    (0..count).map(|i| stage.spawn(one(i))).collect()
}

/// With or without the environment's lights.
fn switch(stage: &mut Stage, enabled: bool, per_frame: u32) {
    stage.world().resource_mut::<ProgressiveLighting>().enabled = enabled;
    stage.shine(if enabled { per_frame } else { 0 });
    for _ in 0..3 {
        stage.update();
    }
}

#[test]
fn own_directional_lights_keep_their_places() {
    let (mut stage, _) = stage();
    let near = Transform::from_xyz(1.5, 1.5, 1.0).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y);
    let spot = SpotLight { intensity: 40.0, shadow_maps_enabled: true, ..default() };
    stage.spawn((spot, near));
    let point = PointLight { intensity: 20.0, shadow_maps_enabled: true, ..default() };
    stage.spawn((point, Transform::from_xyz(-1.2, 1.2, 0.6)));
    for (count, per_frame) in [(0, 5), (3, 5), (9, 1), (10, 0), (12, 0)] {
        // All with shadows or every second; the game's lights come first, or the environment's.
        for (shadows, own_first) in [(1, true), (2, false)] {
            let with_shadows = |i: usize| i.is_multiple_of(shadows);
            switch(&mut stage, !own_first, 5);
            let lights = own(&mut stage, count, with_shadows);
            switch(&mut stage, own_first, per_frame);
            let first = stage.floats();
            switch(&mut stage, !own_first, per_frame);
            let second = stage.floats();
            if own_first {
                save(&first, &format!("own-{count}"));
            }
            let apart = Stage::apart(&first, &second);
            assert_eq!(
                apart, 0.0,
                "{count} own lights, shadows {shadows}, own lights first: {own_first}"
            );
            switch(&mut stage, true, per_frame);
            let status = stage.world().resource::<EnvironmentStatus>();
            assert_eq!(status.crowded_out, per_frame < 5, "{count} own lights");
            for light in lights {
                stage.world().despawn(light);
            }
        }
    }
}

#[test]
fn hidden_lights_and_those_on_other_layers_take_no_places() {
    use bevy::camera::visibility::RenderLayers;
    let (mut stage, _) = stage();
    let parent = stage.spawn((Transform::default(), Visibility::Hidden));
    let all = own(&mut stage, 9, |_| false);
    for (i, light) in all.iter().enumerate() {
        let mut light = stage.world().entity_mut(*light);
        match i % 3 {
            0 => drop(light.insert(Visibility::Hidden)),
            1 => drop(light.insert(ChildOf(parent))),
            _ => drop(light.insert(RenderLayers::layer(3))),
        }
    }
    switch(&mut stage, true, 5);
    // What becomes visible has its place in the same frame.
    stage.world().entity_mut(parent).insert(Visibility::Visible);
    for i in [0, 3] {
        stage.world().entity_mut(all[i]).insert(Visibility::Inherited);
    }
    for i in [2, 5] {
        stage.world().entity_mut(all[i]).insert(RenderLayers::from_layers(&[0, 3]));
    }
    stage.update();
    assert_eq!(stage.world().resource::<EnvironmentStatus>().per_frame, 3);
}

#[test]
fn beams_in_fog_stay() {
    let (mut stage, camera) = stage();
    stage.world().entity_mut(camera).insert(VolumetricFog { ambient_intensity: 0.0, ..default() });
    let fog = FogVolume { density_factor: 0.3, ..default() };
    stage.spawn((fog, Transform::from_scale(Vec3::splat(6.0))));
    let sun = own(&mut stage, 1, |_| true)[0];
    switch(&mut stage, false, 0);
    let clear = stage.floats();
    stage.world().entity_mut(sun).insert(VolumetricLight);
    let pictures = [false, true].map(|enabled| {
        switch(&mut stage, enabled, 5);
        stage.floats()
    });
    save(&pictures[1], "fog");
    assert!(Stage::apart(&clear, &pictures[0]) > 0.05, "there is fog");
    let apart = Stage::apart(&pictures[0], &pictures[1]);
    assert!(apart < 1e-3, "the sun's beams: {apart}");
}

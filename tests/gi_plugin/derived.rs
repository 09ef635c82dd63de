//! Lights that plugins made are no lights of the scene, whatever they do.

use bevy::{light::DirectionalLightShadowMap, prelude::*};
use farlight::{
    gi::{
        ExtractedScene,
        solver::{scene::LightId, session::SnapshotId},
    },
    prelude::*,
};

use crate::{Flat, game::Game, lightmapped_quad, pictures::Stage};

/// Five directional lights as a plugin makes them of a sky.
fn spawn(world: &mut World) -> [Entity; 5] {
    // Visible even where no plugin passes visibility on.
    let visible = (Visibility::Visible, InheritedVisibility::VISIBLE);
    [(); 5].map(|()| world.spawn((DirectionalLight::default(), DerivedLight, visible)).id())
}

/// Other directions, colours, strengths and shadows every frame.
fn change(world: &mut World, lights: &[Entity], frame: u32) {
    for (i, &light) in lights.iter().enumerate() {
        let phase = frame as f32 * 0.37 + i as f32;
        let mut entity = world.entity_mut(light);
        let mut sun = entity.get_mut::<DirectionalLight>().unwrap();
        sun.color = Color::linear_rgb(phase.sin().abs(), 0.5, phase.cos().abs());
        sun.illuminance = 1000.0 + 900.0 * phase.sin();
        sun.shadow_maps_enabled = (frame + i as u32).is_multiple_of(2);
        *entity.get_mut::<Transform>().unwrap() =
            Transform::from_rotation(Quat::from_euler(EulerRot::YXZ, phase, -1.0, 0.0));
    }
}

#[test]
fn derived_and_hidden_lights_do_not_count() {
    let mut flat = Flat::new();
    let lamp =
        |flat: &mut Flat| flat.world().spawn((PointLight::default(), Transform::default())).id();
    let (derived, hidden, stays) = (lamp(&mut flat), lamp(&mut flat), lamp(&mut flat));
    let made = flat.world().spawn((PointLight::default(), DerivedLight)).id();
    flat.app.update();
    let count = |flat: &mut Flat| flat.world().resource::<ExtractedScene>().scene.lights.len();
    assert_eq!(count(&mut flat), 3);
    flat.world().entity_mut(derived).insert(DerivedLight);
    flat.world().entity_mut(hidden).insert(Visibility::Hidden);
    flat.app.update();
    assert_eq!(count(&mut flat), 1);
    flat.world().entity_mut(hidden).insert(Visibility::Visible);
    flat.app.update();
    assert_eq!(count(&mut flat), 2);
    let lights = &flat.world().resource::<ExtractedScene>().scene.lights;
    assert!(lights.contains_key(&LightId(stays.to_bits())));
    assert!(!lights.contains_key(&LightId(made.to_bits())));
}

#[test]
fn derived_lights_that_come_change_and_go_are_never_submitted() {
    // Bevy can't despawn lights where there is no renderer.
    let mut stage = Stage::new();
    stage.world().insert_resource(DirectionalLightShadowMap { size: 64 });
    stage.quad(true);
    let sun = stage.world().spawn(DirectionalLight::default()).id();
    stage.settle();
    let submitted = |stage: &Stage| stage.mock.lock().submitted.len();
    let before = submitted(&stage);
    let mut lights = spawn(stage.world());
    // Below a tagged root, and together with other kinds of light.
    let root = stage.world().spawn((GiScene, Transform::default(), Visibility::default())).id();
    stage.world().entity_mut(lights[0]).insert(ChildOf(root));
    stage.world().entity_mut(lights[1]).insert((PointLight::default(), SpotLight::default()));
    stage.world().entity_mut(lights[2]).insert(RectLight::default());
    for frame in 0..24 {
        if frame % 8 == 7 {
            for light in lights {
                stage.world().entity_mut(light).despawn();
            }
            stage.update();
            lights = spawn(stage.world());
        }
        change(stage.world(), &lights, frame);
        let hidden = if frame % 3 == 0 { Visibility::Hidden } else { Visibility::Visible };
        stage.world().entity_mut(lights[4]).insert(hidden);
        stage.update();
    }
    assert_eq!(submitted(&stage), before, "{:?}", stage.mock.lock().submitted);
    let left_out = &stage.world().resource::<GiStatus>().left_out;
    assert!(left_out.is_empty(), "{left_out:?}");
    let scene = &stage.world().resource::<ExtractedScene>().scene;
    assert_eq!(scene.lights.keys().collect::<Vec<_>>(), [&LightId(sun.to_bits())]);

    // The test can fail: the same light unmarked is a light of the scene.
    stage.world().entity_mut(lights[0]).remove::<DerivedLight>();
    stage.update();
    assert_eq!(submitted(&stage), before + 1);
}

#[test]
fn a_mesh_that_carries_a_derived_light_is_a_mesh() {
    let mut flat = Flat::new();
    let mesh = flat.mesh(lightmapped_quad(1.0));
    let material = flat.material(StandardMaterial::default());
    let lamp = (PointLight::default(), DerivedLight);
    let quad = flat.world().spawn((Mesh3d(mesh), MeshMaterial3d(material), GiScene, lamp)).id();
    flat.settle();
    flat.mock.take_changes();
    let scene = flat.world().resource::<ExtractedScene>();
    assert_eq!((scene.scene.instances.len(), scene.scene.lights.len()), (1, 0));
    for intensity in 0..10 {
        let mut lamp = flat.world().get_mut::<PointLight>(quad).unwrap();
        lamp.intensity = intensity as f32;
        flat.app.update();
    }
    assert!(flat.mock.take_changes().is_empty());
}

/// With the real solver: it converges while such lights change every frame, and then rests.
#[test]
fn a_still_scene_converges_under_derived_lights_that_never_rest() {
    let mut game = Game::new(GiPlugin::default());
    let lights = spawn(game.app.world_mut());
    let mut frame = 0;
    game.until("light", |game| {
        let status = game.status();
        status.state == GiState::Converged && status.shown == status.submitted
    });
    let told = |game: &Game| {
        let status = game.status();
        let submitted: SnapshotId = status.submitted;
        (status.state.clone(), submitted, status.updates, status.uploaded_bytes)
    };
    // What comes last is on its way.
    for _ in 0..20 {
        change(game.app.world_mut(), &lights, frame);
        frame += 1;
        game.app.update();
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let before = told(&game);
    assert_eq!(before.0, GiState::Converged);
    for _ in 0..200 {
        change(game.app.world_mut(), &lights, frame);
        frame += 1;
        game.app.update();
        std::thread::sleep(std::time::Duration::from_millis(1));
        assert_eq!(told(&game), before, "frame {frame}");
    }
}

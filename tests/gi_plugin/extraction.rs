//! What the backend is told of a scene.

use std::f32::consts::PI;

use bevy::{
    asset::RenderAssetUsages,
    mesh::{PrimitiveTopology, skinning::SkinnedMesh},
    prelude::*,
};
use farlight::{
    gi::{
        BackendState, ExtractedScene, LinkStatus,
        solver::{
            SceneChange,
            scene::{AlphaMode as SolverAlpha, InstanceId, LightId, LightKind},
            session::{GridId, SessionChange},
        },
    },
    prelude::*,
};

use crate::{Flat, lightmapped_quad, lines, mock::scene_changes};

fn tagged_quad(flat: &mut Flat) -> Entity {
    let quad = flat.quad();
    flat.world().entity_mut(quad).insert(GiScene);
    quad
}

#[test]
fn a_tagged_mesh_arrives_with_its_material_and_place() {
    let mut flat = Flat::new();
    let quad = tagged_quad(&mut flat);
    flat.world().entity_mut(quad).insert(Transform::from_xyz(1.0, 2.0, 3.0));
    flat.settle();
    let changes = flat.mock.take_changes();
    let id = InstanceId(quad.to_bits());
    assert!(changes.iter().any(|c| matches!(c, SessionChange::AddReceiver(i) if *i == id)));
    let extracted = flat.world().resource::<ExtractedScene>();
    let instance = &extracted.scene.instances[&id];
    assert_eq!(instance.transform.translation, Vec3::new(1.0, 2.0, 3.0).into());
    let mesh = &extracted.scene.meshes[&instance.mesh];
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 2));
    assert_eq!(mesh.uv1.len(), 4);
    assert!(extracted.scene.materials.contains_key(&instance.material));

    flat.world().entity_mut(quad).insert(Transform::from_xyz(0.0, 2.0, 3.0));
    flat.app.update();
    let changes = flat.mock.take_changes();
    assert!(
        matches!(&changes[..], [SessionChange::Scene(SceneChange::SetInstance(i, _))] if *i == id),
        "{changes:?}"
    );
    flat.app.update();
    assert!(flat.mock.take_changes().is_empty(), "a still scene sends nothing");
}

#[test]
fn the_order_of_changes_names_things_before_they_are_used() {
    let mut flat = Flat::new();
    tagged_quad(&mut flat);
    flat.settle();
    let changes = flat.mock.take_changes();
    let at = |what: fn(&SessionChange) -> bool| changes.iter().position(what).unwrap();
    let mesh = at(|c| matches!(c, SessionChange::Scene(SceneChange::SetMesh(..))));
    let material = at(|c| matches!(c, SessionChange::Scene(SceneChange::SetMaterial(..))));
    let instance = at(|c| matches!(c, SessionChange::Scene(SceneChange::SetInstance(..))));
    let receiver = at(|c| matches!(c, SessionChange::AddReceiver(_)));
    assert!(mesh < instance && material < instance && instance < receiver, "{changes:?}");
}

#[test]
fn despawning_frees_everything() {
    let mut flat = Flat::new();
    let quad = tagged_quad(&mut flat);
    flat.settle();
    flat.world().entity_mut(quad).despawn();
    flat.settle();
    let extracted = flat.world().resource::<ExtractedScene>();
    assert!(extracted.scene.instances.is_empty() && extracted.receivers.is_empty());
    assert!(extracted.scene.meshes.is_empty() && extracted.scene.materials.is_empty());
}

#[test]
fn hidden_and_untagged_meshes_leave_the_scene_and_come_back() {
    let mut flat = Flat::new();
    let quad = tagged_quad(&mut flat);
    let id = InstanceId(quad.to_bits());
    let there = |flat: &mut Flat| {
        flat.settle();
        let extracted = flat.world().resource::<ExtractedScene>();
        (extracted.scene.instances.contains_key(&id), extracted.receivers.contains(&id))
    };
    assert_eq!(there(&mut flat), (true, true));
    flat.world().entity_mut(quad).insert(Visibility::Hidden);
    assert_eq!(there(&mut flat), (false, false));
    flat.world().entity_mut(quad).insert(Visibility::Inherited);
    assert_eq!(there(&mut flat), (true, true));
    flat.world().entity_mut(quad).remove::<GiScene>();
    assert_eq!(there(&mut flat), (false, false));
    flat.world().entity_mut(quad).insert(GiScene);
    assert_eq!(there(&mut flat), (true, true));
}

#[test]
fn what_cannot_take_part_is_named_with_the_reason() {
    let mut flat = Flat::new();
    let with_mesh = |flat: &mut Flat, mesh: Mesh| {
        let quad = tagged_quad(flat);
        let mesh = flat.mesh(mesh);
        flat.world().entity_mut(quad).insert(Mesh3d(mesh));
        quad
    };
    let gpu_only = {
        let mut mesh = lightmapped_quad(1.0);
        mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
        mesh.take_gpu_data().unwrap();
        with_mesh(&mut flat, mesh)
    };
    let line = with_mesh(&mut flat, lines());
    let mut not_finite = lightmapped_quad(1.0);
    not_finite.insert_attribute(
        Mesh::ATTRIBUTE_POSITION,
        vec![[f32::NAN, 0.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    );
    let not_finite = with_mesh(&mut flat, not_finite);
    let empty = with_mesh(
        &mut flat,
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, Vec::<[f32; 3]>::new()),
    );
    let bad_index = with_mesh(
        &mut flat,
        lightmapped_quad(1.0).with_inserted_indices(bevy::mesh::Indices::U32(vec![0, 1, 9])),
    );
    let blended = tagged_quad(&mut flat);
    let glass = flat.material(StandardMaterial { alpha_mode: AlphaMode::Blend, ..default() });
    flat.world().entity_mut(blended).insert(MeshMaterial3d(glass));
    let skinned = tagged_quad(&mut flat);
    flat.world().entity_mut(skinned).insert(SkinnedMesh::default());
    let bare = tagged_quad(&mut flat);
    flat.world().entity_mut(bare).remove::<MeshMaterial3d<StandardMaterial>>();
    let scaled = tagged_quad(&mut flat);
    flat.world().entity_mut(scaled).insert(Transform::from_scale(Vec3::new(1.0, f32::NAN, 1.0)));
    let fine = tagged_quad(&mut flat);
    flat.settle();
    for (entity, word) in [
        (gpu_only, "CPU"),
        (line, "lines"),
        (not_finite, "finite"),
        (empty, "no triangles"),
        (bad_index, "names vertex 9"),
        (blended, "blended"),
        (skinned, "bones"),
        (bare, "StandardMaterial"),
        (scaled, "transform"),
    ] {
        let reason = flat.left_out(entity).unwrap_or_else(|| panic!("nothing says {word:?}"));
        assert!(reason.contains(word), "{word:?} isn't in {reason:?}");
    }
    assert_eq!(flat.left_out(fine), None);

    // The reason goes with what caused it.
    let matte = flat.material(StandardMaterial::default());
    flat.world().entity_mut(blended).insert(MeshMaterial3d(matte));
    flat.world().entity_mut(line).despawn();
    flat.settle();
    assert_eq!(flat.left_out(blended), None);
    assert_eq!(flat.left_out(line), None);
}

#[test]
fn a_changed_light_is_a_light_only_change_in_the_next_frame() {
    let mut flat = Flat::new();
    tagged_quad(&mut flat);
    let lamp = flat
        .world()
        .spawn((PointLight { intensity: 1000.0, ..default() }, Transform::from_xyz(0.0, 1.0, 0.0)))
        .id();
    flat.settle();
    flat.mock.take_changes();
    flat.world().get_mut::<PointLight>(lamp).unwrap().intensity = 2000.0;
    flat.app.update();
    let changes = flat.mock.take_changes();
    let [SessionChange::Scene(SceneChange::SetLight(id, light))] = &changes[..] else {
        panic!("{changes:?}")
    };
    assert_eq!(*id, LightId(lamp.to_bits()));
    assert!((light.intensity.x - 2000.0 / (4.0 * PI)).abs() < 1e-3);
    flat.world().get_mut::<Transform>(lamp).unwrap().translation.y = 2.0;
    flat.app.update();
    let changes = flat.mock.take_changes();
    assert!(changes.len() == 1 && scene_changes(&changes)[0].is_light_only(), "{changes:?}");
}

#[test]
fn lights_arrive_in_photometric_units() {
    let mut flat = Flat::new();
    let spot = SpotLight {
        color: Color::linear_rgb(1.0, 0.5, 0.25),
        intensity: 4.0 * PI * 100.0,
        range: 7.0,
        inner_angle: 0.2,
        outer_angle: 0.5,
        ..default()
    };
    let down = Transform::from_xyz(0.0, 3.0, 0.0).looking_at(Vec3::ZERO, Vec3::X);
    let spot = flat.world().spawn((spot, down)).id();
    let sun = DirectionalLight { illuminance: 5000.0, ..default() };
    let sun = flat.world().spawn((sun, down)).id();
    flat.app.update();
    let scene = &flat.world().resource::<ExtractedScene>().scene;
    let light = scene.lights[&LightId(spot.to_bits())];
    assert_eq!(light.kind, LightKind::Spot { inner_angle: 0.2, outer_angle: 0.5 });
    assert!((light.intensity - Vec3::new(100.0, 50.0, 25.0)).abs().max_element() < 1e-3);
    assert!((light.direction - Vec3::NEG_Y).length() < 1e-5 && light.range == 7.0);
    let light = scene.lights[&LightId(sun.to_bits())];
    assert_eq!(light.kind, LightKind::Directional);
    assert!((light.intensity - 5000.0).abs().max_element() < 1e-2);
    assert!((light.direction - Vec3::NEG_Y).length() < 1e-5);
}

#[test]
fn images_may_arrive_after_their_materials() {
    let mut flat = Flat::new();
    let image = flat.world().resource::<Assets<Image>>().reserve_handle();
    let quad = tagged_quad(&mut flat);
    let material = flat.material(StandardMaterial {
        base_color_texture: Some(image.clone()),
        base_color: Color::linear_rgb(0.5, 0.5, 0.5),
        alpha_mode: AlphaMode::Mask(0.25),
        ..default()
    });
    flat.world().entity_mut(quad).insert(MeshMaterial3d(material.clone()));
    flat.settle();
    let material_of = |flat: &mut Flat| {
        let scene = &flat.world().resource::<ExtractedScene>().scene;
        let instance = &scene.instances[&InstanceId(quad.to_bits())];
        (scene.materials[&instance.material].clone(), scene.textures.clone())
    };
    let (converted, textures) = material_of(&mut flat);
    let id = converted.base_color_texture.unwrap();
    assert_eq!(converted.alpha_mode, SolverAlpha::Mask(0.25));
    assert!(textures.is_empty());

    let red = Image::new_fill(
        bevy::render::render_resource::Extent3d { width: 2, height: 2, depth_or_array_layers: 1 },
        bevy::render::render_resource::TextureDimension::D2,
        &[255, 0, 0, 255],
        bevy::render::render_resource::TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    flat.world().resource_mut::<Assets<Image>>().insert(&image, red).unwrap();
    flat.settle();
    assert_eq!(material_of(&mut flat).1[&id].texels[0], [255, 0, 0, 255]);

    // An image that no material uses any more is forgotten.
    let mut materials = flat.world().resource_mut::<Assets<StandardMaterial>>();
    materials.get_mut(&material).unwrap().base_color_texture = None;
    flat.settle();
    assert!(material_of(&mut flat).1.is_empty());
}

#[test]
fn volumes_arrive_move_and_go() {
    let mut flat = Flat::new();
    let scale = Transform::from_scale(Vec3::new(4.0, 2.0, 4.0));
    let resolution = UVec3::new(4, 2, 4);
    let volume = flat.world().spawn((GiProbeVolume { resolution }, scale)).id();
    let id = GridId(volume.to_bits());
    flat.app.update();
    let grids = |flat: &mut Flat| flat.world().resource::<ExtractedScene>().grids.clone();
    assert_eq!(grids(&mut flat)[&id].resolution, resolution);
    flat.world().get_mut::<Transform>(volume).unwrap().translation.x = 5.0;
    flat.app.update();
    assert_eq!(grids(&mut flat)[&id].transform.translation.x, 5.0);
    flat.world().entity_mut(volume).insert(GiProbeVolume { resolution: UVec3::splat(1000) });
    flat.app.update();
    assert!(grids(&mut flat).is_empty());
    flat.app.update();
    assert!(flat.left_out(volume).unwrap().contains("too large"));
    flat.world().entity_mut(volume).insert(GiProbeVolume { resolution });
    flat.app.update();
    flat.world().entity_mut(volume).despawn();
    flat.app.update();
    assert!(grids(&mut flat).is_empty());
}

#[test]
fn a_backend_that_lost_the_scene_gets_all_of_it_again() {
    let mut flat = Flat::new();
    tagged_quad(&mut flat);
    flat.world().spawn(PointLight::default());
    flat.settle();
    flat.mock.take_changes();
    flat.mock.lock().lost = true;
    flat.app.update();
    let changes = flat.mock.take_changes();
    let count = |what: fn(&SessionChange) -> bool| changes.iter().filter(|c| what(c)).count();
    assert_eq!(count(|c| matches!(c, SessionChange::Scene(SceneChange::SetMesh(..)))), 1);
    assert_eq!(count(|c| matches!(c, SessionChange::Scene(SceneChange::SetInstance(..)))), 1);
    assert_eq!(count(|c| matches!(c, SessionChange::Scene(SceneChange::SetLight(..)))), 1);
    assert_eq!(count(|c| matches!(c, SessionChange::AddReceiver(_))), 1);
}

#[test]
fn new_solver_settings_start_a_new_backend_and_bad_ones_do_not() {
    let mut flat = Flat::new();
    tagged_quad(&mut flat);
    flat.settle();
    flat.mock.take_changes();
    assert_eq!(flat.mock.lock().made, 1);
    flat.world().resource_mut::<GiSettings>().upload_bytes_per_frame = 5000;
    flat.app.update();
    assert_eq!(flat.mock.lock().made, 1);
    flat.world().resource_mut::<GiSettings>().page_size = 100;
    flat.app.update();
    assert_eq!(flat.mock.lock().made, 1, "100 isn't a power of two");
    flat.world().resource_mut::<GiSettings>().page_size = 128;
    flat.app.update();
    assert_eq!(flat.mock.lock().made, 2);
    assert!(!flat.mock.take_changes().is_empty(), "the new backend gets the scene");
}

#[test]
fn a_failed_backend_is_a_state_and_nothing_else_stops() {
    let mut flat = Flat::new();
    flat.mock.lock().state = BackendState::Failed("the server is gone".into());
    flat.app.update();
    let status = flat.world().resource::<GiStatus>();
    let GiState::Failed { reason } = &status.state else { panic!("{:?}", status.state) };
    assert_eq!(&**reason, "the server is gone");
}

#[test]
fn a_lost_connection_is_a_state_and_the_link_is_shown() {
    let mut flat = Flat::new();
    assert!(flat.world().resource::<GiStatus>().link.is_none());
    let link = LinkStatus { peer: "server:4433".into(), sent_bytes: 7, ..default() };
    {
        let mut mock = flat.mock.lock();
        mock.state = BackendState::Disconnected { reason: "the line is cut".into() };
        mock.link = Some(link.clone());
    }
    flat.app.update();
    let status = flat.world().resource::<GiStatus>();
    assert_eq!(status.state, GiState::Disconnected { reason: "the line is cut".into() });
    assert_eq!(status.link.as_ref(), Some(&link));
    flat.mock.lock().state = BackendState::Idle;
    flat.app.update();
    assert_eq!(flat.world().resource::<GiStatus>().state, GiState::Idle);
}

#[test]
fn a_mesh_without_a_second_uv_set_gets_one_and_keeps_its_attributes() {
    let mut flat = Flat::new();
    let mesh = flat.mesh(Cuboid::from_length(1.0));
    let colors = vec![[0.5_f32, 0.25, 0.125, 1.0]; 24];
    flat.world()
        .resource_mut::<Assets<Mesh>>()
        .get_mut(&mesh)
        .unwrap()
        .insert_attribute(Mesh::ATTRIBUTE_COLOR, colors);
    let spawn = |flat: &mut Flat| {
        let material = flat.material(StandardMaterial::default());
        flat.world().spawn((Mesh3d(mesh.clone()), MeshMaterial3d(material), GiScene)).id()
    };
    let cube = spawn(&mut flat);
    flat.settle();
    assert_eq!(flat.left_out(cube), None);
    let drawn = flat.world().get::<Mesh3d>(cube).unwrap().id();
    assert_ne!(drawn, mesh.id());
    // Another one of the same mesh shares what was made.
    let other = spawn(&mut flat);
    flat.settle();
    assert_eq!(flat.world().get::<Mesh3d>(other).unwrap().id(), drawn);
    let meshes = flat.world().resource::<Assets<Mesh>>();
    let made = meshes.get(drawn).unwrap();
    let vertices = made.count_vertices();
    for attribute in [
        Mesh::ATTRIBUTE_POSITION,
        Mesh::ATTRIBUTE_NORMAL,
        Mesh::ATTRIBUTE_UV_0,
        Mesh::ATTRIBUTE_UV_1,
        Mesh::ATTRIBUTE_COLOR,
    ] {
        assert_eq!(made.attribute(attribute).unwrap().len(), vertices, "{attribute:?}");
    }
    assert_eq!(meshes.get(&mesh).unwrap().count_vertices(), 24, "the original is untouched");
    let extracted = flat.world().resource::<ExtractedScene>();
    assert_eq!((extracted.receivers.len(), extracted.scene.meshes.len()), (2, 1));
    let geometry = extracted.scene.meshes.values().next().unwrap();
    assert_eq!((geometry.uv1.len(), geometry.triangles.len()), (vertices, 12));
}

#[test]
fn an_edited_mesh_is_converted_again() {
    let mut flat = Flat::new();
    let quad = tagged_quad(&mut flat);
    flat.settle();
    flat.mock.take_changes();
    let mesh = flat.world().get::<Mesh3d>(quad).unwrap().0.clone();
    let mut meshes = flat.world().resource_mut::<Assets<Mesh>>();
    *meshes.get_mut(&mesh).unwrap() = lightmapped_quad(3.0);
    flat.settle();
    let changes = flat.mock.take_changes();
    let [SessionChange::Scene(SceneChange::SetMesh(_, mesh))] = &changes[..] else {
        panic!("{changes:?}")
    };
    assert_eq!(mesh.positions[0].abs(), Vec3::new(1.5, 1.5, 0.0));
}

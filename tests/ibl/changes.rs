//! What changes pictures disturbs them, and nothing else does.

use bevy::{
    camera::{Exposure, visibility::RenderLayers},
    light::{DirectionalLightShadowMap, NotShadowCaster, Skybox},
    mesh::{
        VertexAttributeValues,
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    pbr::DistanceFog,
    prelude::*,
};
use farlight::{
    core::LightingChanged,
    ibl::{Disturb, environment_maps::Environment},
    prelude::*,
};

use crate::stage::Stage;

struct Scene {
    stage: Stage,
    camera: Entity,
    ball: Entity,
    material: Handle<StandardMaterial>,
    image: Handle<Image>,
    lamp: Entity,
}

impl Scene {
    fn new() -> Self {
        let mut stage = Stage::new();
        stage.world().insert_resource(DirectionalLightShadowMap { size: 64 });
        stage.ball();
        let grey = Image::new_fill(
            bevy::render::render_resource::Extent3d {
                width: 4,
                height: 4,
                depth_or_array_layers: 1,
            },
            bevy::render::render_resource::TextureDimension::D2,
            &[128, 128, 128, 255],
            bevy::render::render_resource::TextureFormat::Rgba8UnormSrgb,
            bevy::asset::RenderAssetUsages::all(),
        );
        let image = stage.world().resource_mut::<Assets<Image>>().add(grey);
        let material = stage
            .material(StandardMaterial { base_color_texture: Some(image.clone()), ..default() });
        let cuboid = stage.mesh(Cuboid::from_length(0.4));
        let at = Transform::from_xyz(-0.9, 0.2, 0.6);
        let ball = stage.spawn((cuboid, material.clone(), at));
        let lamp = PointLight { intensity: 10.0, shadow_maps_enabled: true, ..default() };
        let lamp = stage.spawn((lamp, Transform::from_xyz(1.0, 1.5, 1.0)));
        let map = Environment::from_equirect(16, 8, vec![Vec3::ONE; 128]).unwrap();
        stage.light(map, ProgressiveLighting { lights: 4, brightness: 0.5, ..default() });
        let camera = stage.camera(Vec3::new(0.0, 1.5, 3.0), Vec3::new(0.0, 0.3, 0.0));
        stage.refine(camera);
        Self { stage, camera, ball, material: material.0, image, lamp }
    }

    /// Frames since everything is still.
    fn still(&mut self) -> u32 {
        self.stage.world().get::<Refinement>(self.camera).unwrap().frames
    }

    /// Whether `change` is noticed within three frames.
    fn notices(&mut self, change: impl FnOnce(&mut Self)) -> bool {
        let waited = (0..30).find(|_| {
            self.stage.update();
            self.still() >= 6
        });
        assert!(waited.is_some(), "it comes to rest");
        let before = self.still();
        change(self);
        for _ in 0..3 {
            self.stage.update();
        }
        self.still() < before
    }

    fn entity(&mut self, entity: Entity) -> EntityWorldMut<'_> {
        self.stage.world().entity_mut(entity)
    }

    fn edit<T: Component<Mutability = bevy::ecs::component::Mutable>>(
        &mut self,
        entity: Entity,
        edit: impl FnOnce(&mut T),
    ) {
        let mut entity = self.entity(entity);
        let mut component = entity.get_mut::<T>().unwrap();
        component.set_changed();
        edit(&mut component);
    }
}

type Change = (&'static str, fn(&mut Scene));

#[test]
fn every_kind_of_change_is_noticed() {
    let changes: &[Change] = &[
        ("moved", |s| s.edit::<Transform>(s.ball, |t| t.translation.x += 0.1)),
        ("turned", |s| s.edit::<Transform>(s.ball, |t| t.rotate_y(0.3))),
        ("hidden", |s| s.edit::<Visibility>(s.ball, |v| *v = Visibility::Hidden)),
        ("shown", |s| s.edit::<Visibility>(s.ball, |v| *v = Visibility::Inherited)),
        ("another shape", |s| {
            let mesh = s.stage.mesh(Cuboid::from_length(0.5));
            let ball = s.ball;
            s.entity(ball).insert(mesh);
        }),
        ("a changed shape", |s| {
            let mesh = s.stage.world().get::<Mesh3d>(s.ball).unwrap().0.clone();
            let mut meshes = s.stage.world().resource_mut::<Assets<Mesh>>();
            *meshes.get_mut(&mesh).unwrap() = Cuboid::from_length(0.3).into();
        }),
        ("another material", |s| {
            let material = s.stage.matte(Color::srgb(0.0, 1.0, 0.0));
            let ball = s.ball;
            s.entity(ball).insert(material);
        }),
        ("the material back", |s| {
            let (ball, material) = (s.ball, s.material.clone());
            s.entity(ball).insert(MeshMaterial3d(material));
        }),
        ("a changed material", |s| {
            let id = s.material.id();
            let mut materials = s.stage.world().resource_mut::<Assets<StandardMaterial>>();
            materials.get_mut(id).unwrap().base_color = Color::srgb(1.0, 0.0, 0.0);
        }),
        ("a changed image", |s| {
            let id = s.image.id();
            let mut images = s.stage.world().resource_mut::<Assets<Image>>();
            images.get_mut(id).unwrap().data = Some([200, 100, 100, 255].repeat(16));
        }),
        ("layers", |s| {
            let ball = s.ball;
            s.entity(ball).insert(RenderLayers::from_layers(&[0, 2]));
        }),
        ("no shadow", |s| {
            let ball = s.ball;
            s.entity(ball).insert(NotShadowCaster);
        }),
        ("a lamp's light", |s| s.edit::<PointLight>(s.lamp, |l| l.intensity *= 2.0)),
        ("a lamp's place", |s| s.edit::<Transform>(s.lamp, |t| t.translation.x += 0.5)),
        ("a lamp is off", |s| s.edit::<Visibility>(s.lamp, |v| *v = Visibility::Hidden)),
        ("a new lamp", |s| {
            s.stage.spawn(DirectionalLight { illuminance: 0.3, ..default() });
        }),
        ("a lamp is gone", |s| {
            let mut lamps = s.stage.world().query_filtered::<Entity, With<DirectionalLight>>();
            let world = s.stage.world();
            let lamps: Vec<_> = lamps
                .iter(world)
                .filter(|lamp| world.get::<DerivedLight>(*lamp).is_none())
                .collect();
            assert_eq!(lamps.len(), 1);
            world.despawn(lamps[0]);
        }),
        ("light from all around", |s| {
            s.stage.world().resource_mut::<GlobalAmbientLight>().brightness = 0.2;
        }),
        ("light from all around, a camera's", |s| {
            let camera = s.camera;
            s.entity(camera).insert(AmbientLight { brightness: 0.1, ..default() });
        }),
        ("clear colour", |s| {
            s.stage.world().resource_mut::<ClearColor>().0 = Color::srgb(0.1, 0.2, 0.3);
        }),
        ("a camera's clear colour", |s| {
            s.edit::<Camera>(s.camera, |c| c.clear_color = Color::srgb(0.3, 0.2, 0.1).into());
        }),
        ("fog", |s| {
            let camera = s.camera;
            s.entity(camera).insert(DistanceFog::default());
        }),
        ("thicker fog", |s| {
            s.edit::<DistanceFog>(s.camera, |f| {
                f.falloff = FogFalloff::Linear { start: 1.0, end: 50.0 }
            });
        }),
        ("no fog", |s| {
            let camera = s.camera;
            s.entity(camera).remove::<DistanceFog>();
        }),
        ("exposure", |s| s.edit::<Exposure>(s.camera, |e| e.ev100 += 0.5)),
        ("projection", |s| {
            let wide = PerspectiveProjection { fov: 1.2, ..default() };
            let camera = s.camera;
            s.entity(camera).insert(Projection::from(wide));
        }),
        ("a camera's turn", |s| s.edit::<Transform>(s.camera, |t| t.rotate_y(0.05))),
        ("viewport", |s| {
            s.edit::<Camera>(s.camera, |c| {
                c.viewport =
                    Some(bevy::camera::Viewport { physical_size: UVec2::new(32, 32), ..default() });
            });
        }),
        ("the environment's brightness", |s| {
            s.stage.world().resource_mut::<ProgressiveLighting>().brightness = 0.7;
        }),
        ("the environment's turn", |s| {
            s.stage.world().resource_mut::<ProgressiveLighting>().rotation =
                Quat::from_rotation_y(1.0);
        }),
        ("more lights", |s| s.stage.world().resource_mut::<ProgressiveLighting>().lights = 6),
        ("told", |s| {
            s.stage.world().write_message(Disturb { sphere: None, keep: 0.0 });
        }),
        ("solved light", |s| {
            s.stage.world().write_message(LightingChanged);
        }),
        ("gone", |s| {
            let ball = s.ball;
            s.stage.world().despawn(ball);
        }),
    ];
    let mut scene = Scene::new();
    let camera = scene.camera;
    let missed: Vec<_> =
        changes.iter().filter(|(_, change)| !scene.notices(change)).map(|(name, _)| name).collect();
    assert!(missed.is_empty(), "not noticed: {missed:?}");
    scene.stage.refine(camera);
}

#[test]
fn nothing_else_disturbs() {
    let changes: &[Change] = &[
        ("the same transforms", |s| {
            for entity in [s.ball, s.lamp, s.camera] {
                s.edit::<Transform>(entity, |_| ());
            }
        }),
        ("the same lights", |s| {
            s.edit::<PointLight>(s.lamp, |l| l.intensity *= 1.0);
            s.stage.world().resource_mut::<ProgressiveLighting>().set_changed();
            s.stage.world().resource_mut::<GlobalAmbientLight>().set_changed();
            s.stage.world().resource_mut::<ClearColor>().set_changed();
        }),
        ("the same camera", |s| {
            s.edit::<Camera>(s.camera, |c| c.order += 0);
            s.edit::<Projection>(s.camera, |_| ());
        }),
        ("the same material", |s| {
            let (ball, material) = (s.ball, s.material.clone());
            s.entity(ball).insert(MeshMaterial3d(material));
        }),
        ("entities without meshes", |s| {
            s.stage.spawn((Transform::from_xyz(1.0, 0.0, 0.0), Visibility::default()));
        }),
        ("a user interface", |s| {
            s.stage
                .spawn((Node { width: percent(50), ..default() }, BackgroundColor(Color::WHITE)));
            s.stage.spawn(Text::new("score 12"));
        }),
        ("another text", |s| {
            let mut texts = s.stage.world().query::<&mut Text>();
            for mut text in texts.iter_mut(s.stage.world()) {
                text.0 = "score 13".into();
            }
        }),
        ("assets that nothing shows", |s| {
            s.stage.matte(Color::WHITE);
            s.stage.mesh(Cuboid::from_length(1.0));
            let image = Image::default();
            s.stage.world().resource_mut::<Assets<Image>>().add(image);
        }),
        ("a hidden mesh", |s| {
            let mesh = (s.stage.mesh(Cuboid::from_length(1.0)), MeshMaterial3d(s.material.clone()));
            s.stage.spawn((mesh, Visibility::Hidden));
        }),
    ];
    let mut scene = Scene::new();
    let disturbed: Vec<_> =
        changes.iter().filter(|(_, change)| scene.notices(change)).map(|(name, _)| name).collect();
    // A mesh that is new is uploaded, hidden or not.
    let unexpected: Vec<_> = disturbed.iter().filter(|name| ***name != "a hidden mesh").collect();
    assert!(unexpected.is_empty(), "disturbed by {unexpected:?}");
    let camera = scene.camera;
    scene.stage.refine(camera);
}

#[test]
fn bones_disturb_when_they_move() {
    let mut scene = Scene::new();
    let mut mesh: Mesh = Cuboid::from_length(0.4).into();
    let vertices = mesh.count_vertices();
    let joints = VertexAttributeValues::Uint16x4(vec![[0; 4]; vertices]);
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints);
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0, 0.0, 0.0, 0.0]; vertices]);
    let poses = SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY]);
    let inverse_bindposes = scene.stage.world().resource_mut::<Assets<_>>().add(poses);
    let joint = scene.stage.spawn(Transform::from_xyz(0.9, 0.3, 0.6));
    let skin = SkinnedMesh { inverse_bindposes, joints: vec![joint] };
    let shown = (scene.stage.mesh(mesh), MeshMaterial3d(scene.material.clone()));
    scene.stage.spawn((shown, skin, Transform::default()));
    assert!(!scene.notices(|s| s.edit::<Transform>(joint, |_| ())), "the same pose");
    assert!(scene.notices(|s| s.edit::<Transform>(joint, |t| t.rotate_y(0.5))));
    let camera = scene.camera;
    scene.stage.refine(camera);
}

#[test]
fn a_sky_disturbs_when_it_is_another() {
    let mut scene = Scene::new();
    let faces = Image {
        texture_view_descriptor: Some(bevy::render::render_resource::TextureViewDescriptor {
            dimension: Some(bevy::render::render_resource::TextureViewDimension::Cube),
            ..default()
        }),
        ..Image::new_fill(
            bevy::render::render_resource::Extent3d {
                width: 4,
                height: 4,
                depth_or_array_layers: 6,
            },
            bevy::render::render_resource::TextureDimension::D2,
            &[90, 120, 200, 255],
            bevy::render::render_resource::TextureFormat::Rgba8UnormSrgb,
            bevy::asset::RenderAssetUsages::all(),
        )
    };
    let image = scene.stage.world().resource_mut::<Assets<Image>>().add(faces);
    let camera = scene.camera;
    let sky = Skybox { image: Some(image), brightness: 1.0, ..default() };
    assert!(scene.notices(|s| {
        s.entity(camera).insert(sky);
    }));
    assert!(
        scene
            .notices(|s| s.edit::<Skybox>(camera, |sky| sky.rotation = Quat::from_rotation_y(1.0)))
    );
    assert!(!scene.notices(|s| s.edit::<Skybox>(camera, |sky| sky.brightness *= 1.0)));
}

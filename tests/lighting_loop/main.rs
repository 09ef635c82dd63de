//! The light loop of `shaders/lighting` with StandardMaterial's reflection draws what Bevy's own
//! StandardMaterial draws.

#[path = "../support/mod.rs"]
mod support;

use std::f32::consts::PI;

use bevy::{
    asset::uuid_handle,
    camera::Exposure,
    core_pipeline::tonemapping::Tonemapping,
    light::CascadeShadowConfigBuilder,
    pbr::{ContactShadows, ExtendedMaterial, MaterialExtension},
    prelude::*,
    render::render_resource::AsBindGroup,
    shader::{Shader, ShaderRef},
};
use farlight::prelude::*;
use support::{
    flip,
    headless::{Headless, Picture},
};

const SHADER: Handle<Shader> = uuid_handle!("5d0fd3ce-6c3c-4b3e-9a6c-0a1d5d7b8f11");

#[derive(Asset, TypePath, AsBindGroup, Clone, Default)]
struct OwnLoop {}

impl MaterialExtension for OwnLoop {
    fn fragment_shader() -> ShaderRef {
        ShaderRef::Handle(SHADER)
    }
}

type OwnLoopMaterial = ExtendedMaterial<StandardMaterial, OwnLoop>;

/// What shines in a scene.
#[derive(Clone, Copy, Default)]
struct Lights {
    clustered: bool,
    directional: bool,
    /// Shadows of the depth buffer, too.
    contact: bool,
    orthographic: bool,
}

struct Stage {
    headless: Headless,
    objects: Vec<(Entity, Handle<StandardMaterial>)>,
}

impl Stage {
    fn new(lights: Lights) -> Self {
        let headless = Headless::new(UVec2::new(192, 128), &support::assets(), |app| {
            app.add_plugins((FarlightPlugins, MaterialPlugin::<OwnLoopMaterial>::default()))
                .insert_resource(GlobalAmbientLight::NONE)
                .insert_resource(ClearColor(Color::BLACK))
                .insert_resource(bevy::light::DirectionalLightShadowMap { size: 512 })
                .insert_resource(bevy::light::PointLightShadowMap { size: 256 });
            app.world_mut()
                .resource_mut::<Assets<Shader>>()
                .insert(
                    &SHADER,
                    Shader::from_wgsl(include_str!("standard.wgsl"), "lighting_loop/standard.wgsl"),
                )
                .unwrap();
        });
        let headless = headless.unwrap_or_else(|problem| panic!("{problem}"));
        let mut stage = Self { headless, objects: Vec::new() };
        stage.camera(lights);
        stage.objects();
        if lights.clustered {
            stage.clustered_lights(lights.contact);
        }
        if lights.directional {
            stage.directional_lights(lights.contact);
        }
        stage
    }

    fn world(&mut self) -> &mut World {
        self.headless.app.world_mut()
    }

    fn camera(&mut self, lights: Lights) {
        let projection = if lights.orthographic {
            Projection::from(OrthographicProjection {
                scaling_mode: bevy::camera::ScalingMode::FixedVertical { viewport_height: 8.0 },
                ..OrthographicProjection::default_3d()
            })
        } else {
            Projection::default()
        };
        let mut camera = self.world().spawn((
            Camera3d::default(),
            projection,
            Msaa::Off,
            Tonemapping::None,
            Exposure { ev100: 7.0 },
            Transform::from_xyz(4.0, 5.0, 8.0).looking_at(Vec3::new(0.0, 0.3, 0.0), Vec3::Y),
        ));
        if lights.contact {
            camera.insert(ContactShadows::default());
        }
    }

    fn objects(&mut self) {
        let mut meshes = self.world().resource_mut::<Assets<Mesh>>();
        let floor = meshes.add(Plane3d::default().mesh().size(12.0, 12.0));
        let ball = meshes.add(Sphere::new(0.6).mesh().uv(24, 16));
        let block = meshes.add(Cuboid::new(0.8, 1.6, 0.8));
        self.object(floor, Color::srgb(0.7, 0.7, 0.7), 0.9, 0.0, Vec3::ZERO);
        for i in 0..5 {
            let turn = i as f32 * 2.0 * PI / 5.0;
            let place = Vec3::new(2.5 * turn.cos(), 0.7, 2.5 * turn.sin());
            let roughness = 0.1 + 0.2 * i as f32;
            self.object(
                ball.clone(),
                Color::hsl(72.0 * i as f32, 0.6, 0.5),
                roughness,
                (i % 2) as f32,
                place,
            );
        }
        self.object(block, Color::WHITE, 0.5, 0.0, Vec3::new(0.0, 0.8, 0.0));
    }

    fn object(&mut self, mesh: Handle<Mesh>, colour: Color, roughness: f32, metal: f32, at: Vec3) {
        let material =
            self.world().resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial {
                base_color: colour,
                perceptual_roughness: roughness,
                metallic: metal,
                ..default()
            });
        let place = Transform::from_translation(at);
        let object =
            self.world().spawn((Mesh3d(mesh), MeshMaterial3d(material.clone()), place)).id();
        self.objects.push((object, material));
    }

    /// Forty lights of small range, so that clusters differ; every fourth throws shadows.
    fn clustered_lights(&mut self, contact: bool) {
        for i in 0..40_u32 {
            let turn = i as f32 * 2.399_963; // the golden angle: spread evenly
            let distance = 0.8 * (i as f32 + 0.5).sqrt();
            let place =
                Vec3::new(distance * turn.cos(), 0.4 + 0.6 * (i % 5) as f32, distance * turn.sin());
            let color = Color::hsl(40.0 * i as f32 % 360.0, 0.8, 0.6);
            let shadows = i % 8 < 2;
            if i % 2 == 0 {
                self.world().spawn((
                    PointLight {
                        color,
                        intensity: 3000.0,
                        range: 3.0,
                        radius: if i % 3 == 0 { 0.2 } else { 0.0 },
                        shadow_maps_enabled: shadows,
                        contact_shadows_enabled: contact,
                        ..default()
                    },
                    Transform::from_translation(place),
                ));
            } else {
                let target = Vec3::new(0.0, if i % 3 == 0 { 3.0 } else { 0.0 }, 0.0);
                self.world().spawn((
                    SpotLight {
                        color,
                        intensity: 12_000.0,
                        range: 5.0,
                        inner_angle: 0.3,
                        outer_angle: 0.7,
                        shadow_maps_enabled: shadows,
                        contact_shadows_enabled: contact,
                        ..default()
                    },
                    Transform::from_translation(place).looking_at(target, Vec3::X),
                ));
            }
        }
    }

    fn directional_lights(&mut self, contact: bool) {
        let cascades = CascadeShadowConfigBuilder {
            num_cascades: 3,
            first_cascade_far_bound: 7.0,
            maximum_distance: 20.0,
            ..default()
        };
        self.world().spawn((
            DirectionalLight {
                illuminance: 400.0,
                shadow_maps_enabled: true,
                contact_shadows_enabled: contact,
                ..default()
            },
            cascades.build(),
            Transform::from_xyz(3.0, 4.0, -1.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
        self.world().spawn((
            DirectionalLight { illuminance: 60.0, color: Color::srgb(0.4, 0.5, 1.0), ..default() },
            Transform::from_xyz(-3.0, 2.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
    }

    fn picture(&mut self) -> Picture {
        let mut frames = || {
            // Pipelines and shadow maps of the first frames may be missing.
            for _ in 0..4 {
                self.headless.update()?;
            }
            self.headless.capture()
        };
        frames().unwrap_or_else(|problem| panic!("{problem}"))
    }

    /// Gives every object the same material on the other loop.
    fn change_to_own_loop(&mut self) {
        for (object, material) in self.objects.clone() {
            let base = self.world().resource::<Assets<StandardMaterial>>().get(&material);
            let base = base.cloned().unwrap_or_default();
            let own = OwnLoopMaterial { base, extension: OwnLoop {} };
            let own = self.world().resource_mut::<Assets<OwnLoopMaterial>>().add(own);
            self.world()
                .entity_mut(object)
                .remove::<MeshMaterial3d<StandardMaterial>>()
                .insert(MeshMaterial3d(own));
        }
    }
}

/// Both loops add the same floats in nearly the same order, so that only rounding to 8 bits may
/// differ.
fn assert_same(name: &str, lights: Lights) {
    // Two apps at the same frame: contact shadows change their noise every frame.
    let bevy = Stage::new(lights).picture();
    let mut stage = Stage::new(lights);
    stage.change_to_own_loop();
    let own = stage.picture();
    bevy.save(support::scratch(&format!("lighting_loop/{name}.bevy.png"))).unwrap();
    own.save(support::scratch(&format!("lighting_loop/{name}.own.png"))).unwrap();
    assert!(bevy.mean() > 15.0, "{name}: the scene is too dark to say anything: {}", bevy.mean());
    let worst = bevy
        .pixels
        .as_flattened()
        .iter()
        .zip(own.pixels.as_flattened())
        .map(|(a, b)| a.abs_diff(*b))
        .max()
        .unwrap_or_default();
    let difference = flip::between(&bevy, &own);
    println!(
        "{name}: largest difference {worst} of 255, FLIP mean {:.5}, 99th percentile {:.5} ({})",
        difference.mean(),
        difference.percentile(0.99),
        stage.headless.adapter()
    );
    assert!(worst <= 1 && difference.percentile(0.99) < 0.01, "{name}: {worst} of 255");
}

#[test]
fn clustered_lights_with_shadows() {
    assert_same("clustered", Lights { clustered: true, ..default() });
}

#[test]
fn directional_lights_with_cascades() {
    assert_same("directional", Lights { directional: true, ..default() });
}

#[test]
fn all_lights() {
    assert_same("all", Lights { clustered: true, directional: true, ..default() });
}

#[test]
fn contact_shadows() {
    assert_same(
        "contact",
        Lights { clustered: true, directional: true, contact: true, ..default() },
    );
}

#[test]
fn orthographic_camera() {
    assert_same(
        "orthographic",
        Lights { clustered: true, directional: true, orthographic: true, ..default() },
    );
}

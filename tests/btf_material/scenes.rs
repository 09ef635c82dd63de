//! Everything of a scene, compared with `StandardMaterial` or with a formula.

use std::f32::consts::PI;

use bevy::{
    camera::Viewport,
    core_pipeline::{
        prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass},
        tonemapping::DebandDither,
    },
    light::{IrradianceVolume, LightProbe, NotShadowCaster},
    pbr::{Lightmap, ScreenSpaceAmbientOcclusion},
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use half::f16;

use crate::support::flip;
use crate::*;

/// A ball over a floor; what is measured in the second picture is `StandardMaterial` in the first.
fn compare(name: &str, limit: f32, dress: impl Fn(&mut Stage)) {
    let mut pictures = Vec::new();
    for measured in [false, true] {
        let mut stage = Stage::new();
        let floor = stage.mesh(Plane3d::default().mesh().size(6.0, 6.0));
        let ball = stage.mesh(Sphere::new(0.6).mesh().uv(32, 24));
        let at = Transform::from_xyz(0.0, 0.9, 0.0);
        if measured {
            let material = stage.white();
            stage.spawn((Mesh3d(floor), material.clone()));
            stage.spawn((Mesh3d(ball), material, at));
            stage.settle();
        } else {
            let material = stage.standard();
            stage.spawn((Mesh3d(floor), material.clone()));
            stage.spawn((Mesh3d(ball), material, at));
        }
        dress(&mut stage);
        let picture = stage.picture();
        stage.save(&picture, &format!("{name}-{}", if measured { "measured" } else { "standard" }));
        pictures.push(picture);
    }
    let difference = flip::between(&pictures[0], &pictures[1]);
    println!(
        "{name}: FLIP mean {:.4}, 99th percentile {:.4}",
        difference.mean(),
        difference.percentile(0.99)
    );
    assert!(pictures[0].mean() > 10.0, "{name}: too dark to say anything");
    assert!(difference.mean() < limit, "{name}: FLIP {}", difference.mean());
}

/// Burley's term deviates from 1 where light and view are far apart, by up to a few percent at this
/// roughness: that is less than FLIP 0.03, a missing or displaced shadow is more.
const LIMIT: f32 = 0.03;

fn eye(stage: &mut Stage) -> Entity {
    stage.camera(Vec3::new(1.0, 3.0, 4.0), Vec3::new(0.0, 0.4, 0.0), 0.0)
}

fn sun(stage: &mut Stage) {
    stage.spawn((
        DirectionalLight { illuminance: 2.5, shadow_maps_enabled: true, ..default() },
        Transform::from_xyz(2.0, 3.0, 1.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

#[test]
fn shadows_of_a_point_light() {
    compare("shadow-point", LIMIT, |stage| {
        eye(stage);
        stage.spawn((
            PointLight { intensity: 4.0 * PI * 30.0, shadow_maps_enabled: true, ..default() },
            Transform::from_xyz(1.5, 3.0, 1.0),
        ));
    });
}

#[test]
fn shadows_of_a_spot_light() {
    compare("shadow-spot", LIMIT, |stage| {
        eye(stage);
        stage.spawn((
            SpotLight {
                intensity: 4.0 * PI * 30.0,
                outer_angle: 0.6,
                inner_angle: 0.4,
                shadow_maps_enabled: true,
                ..default()
            },
            Transform::from_xyz(1.5, 3.0, 1.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
    });
}

#[test]
fn shadows_of_a_directional_light() {
    compare("shadow-directional", LIMIT, |stage| {
        eye(stage);
        sun(stage);
    });
}

#[test]
fn fog() {
    compare("fog", LIMIT, |stage| {
        let eye = eye(stage);
        stage.world().entity_mut(eye).insert(DistanceFog {
            color: Color::srgb(0.2, 0.3, 0.6),
            falloff: FogFalloff::Linear { start: 3.0, end: 7.0 },
            ..default()
        });
        sun(stage);
    });
}

#[test]
fn tone_mapping_and_dither() {
    compare("tone-mapping", LIMIT, |stage| {
        let eye = eye(stage);
        stage.world().entity_mut(eye).insert((Tonemapping::AcesFitted, DebandDither::Enabled));
        sun(stage);
    });
}

#[test]
fn high_dynamic_range_and_tone_mapping() {
    compare("hdr", LIMIT, |stage| {
        let eye = eye(stage);
        stage.world().entity_mut(eye).insert((Hdr, Tonemapping::AcesFitted));
        sun(stage);
    });
}

#[test]
fn multisampling() {
    compare("msaa", LIMIT, |stage| {
        let eye = eye(stage);
        stage.world().entity_mut(eye).insert(Msaa::Sample4);
        sun(stage);
    });
}

#[test]
fn all_prepasses() {
    compare("prepasses", LIMIT, |stage| {
        let eye = eye(stage);
        let passes = (DepthPrepass, NormalPrepass, MotionVectorPrepass);
        stage.world().entity_mut(eye).insert(passes);
        sun(stage);
    });
}

#[test]
fn prepasses_with_multisampling() {
    compare("prepasses-msaa", LIMIT, |stage| {
        let eye = eye(stage);
        stage.world().entity_mut(eye).insert((DepthPrepass, NormalPrepass, Msaa::Sample4));
        sun(stage);
    });
}

#[test]
fn ambient_occlusion_and_ambient_light() {
    compare("ssao", LIMIT, |stage| {
        let eye = eye(stage);
        stage.world().entity_mut(eye).insert(ScreenSpaceAmbientOcclusion::default());
        stage.world().resource_mut::<GlobalAmbientLight>().brightness = 0.5;
    });
}

#[test]
fn the_deferred_renderer_leaves_measured_materials_to_the_forward_pass() {
    compare("deferred", LIMIT, |stage| {
        use bevy::{core_pipeline::prepass::DeferredPrepass, pbr::DefaultOpaqueRendererMethod};
        stage.world().insert_resource(DefaultOpaqueRendererMethod::deferred());
        let eye = eye(stage);
        stage.world().entity_mut(eye).insert((DepthPrepass, DeferredPrepass));
        sun(stage);
    });
}

#[test]
fn two_cameras() {
    compare("two-cameras", LIMIT, |stage| {
        let half = UVec2::new(SIZE / 2, SIZE);
        for (side, from) in
            [Vec3::new(-2.0, 2.0, 3.0), Vec3::new(3.0, 2.0, 1.0)].into_iter().enumerate()
        {
            let eye =
                stage.camera(from, Vec3::new(0.0, 0.5, 0.0), if side == 0 { 0.0 } else { 4.0 });
            stage.world().entity_mut(eye).insert(Camera {
                order: side as isize,
                viewport: Some(Viewport {
                    physical_position: UVec2::new(side as u32 * SIZE / 2, 0),
                    physical_size: half,
                    ..default()
                }),
                clear_color: if side == 0 {
                    ClearColorConfig::Default
                } else {
                    ClearColorConfig::None
                },
                ..default()
            });
        }
        sun(stage);
    });
}

/// Half floats of one colour.
fn flat(size: Extent3d, dimension: TextureDimension, value: f32) -> Image {
    let texel: Vec<u8> =
        [value, value, value, 1.0].iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()).collect();
    Image::new_fill(
        size,
        dimension,
        &texel,
        TextureFormat::Rgba16Float,
        bevy::asset::RenderAssetUsages::default(),
    )
}

/// A plane of albedo one half seen from above; what indirect light makes of it.
struct Indirect {
    stage: Stage,
    plane: Entity,
    camera: Entity,
}

impl Indirect {
    fn new() -> Self {
        let mut stage = Stage::new();
        let camera = stage.float_camera(Vec3::new(1.0, 2.0, 0.5), Vec3::ZERO, 1.0);
        let mut mesh = Plane3d::default().mesh().size(4.0, 4.0).build();
        let uv = mesh.attribute(Mesh::ATTRIBUTE_UV_0).unwrap().clone();
        mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, uv);
        let mesh = stage.mesh(mesh);
        let btf = stage.btf(synthetic::lambert([0.5; 3], [4, 4]).unwrap());
        let material = stage.material(BtfMaterial::new(btf));
        let plane = stage.spawn((Mesh3d(mesh), material));
        stage.settle();
        Self { stage, plane, camera }
    }

    /// The sum over directions is exact for diffuse surfaces, but for tables and half floats.
    fn assert_middle(&mut self, expected: f32, what: &str) {
        let pixels = self.stage.floats();
        let found = at(&pixels, SIZE / 2, SIZE / 2);
        let off = (found / expected - 1.0).abs().max_element();
        println!("{what}: {found} for {expected}");
        assert!(off < 0.01, "{what}: {found} instead of {expected}");
    }

    fn lightmap(&mut self, value: f32) {
        let image =
            flat(Extent3d { width: 4, height: 4, ..default() }, TextureDimension::D2, value);
        let image = self.stage.world().resource_mut::<Assets<Image>>().add(image);
        let plane = self.plane;
        self.stage.world().entity_mut(plane).insert(Lightmap { image, ..default() });
    }
}

#[test]
fn ambient_light() {
    compare("ambient", LIMIT, |stage| {
        eye(stage);
        stage.world().resource_mut::<GlobalAmbientLight>().brightness = 0.8;
    });
}

#[test]
fn lightmaps() {
    let mut scene = Indirect::new();
    scene.lightmap(0.8);
    scene.assert_middle(0.4, "lightmap");
    // Light that it holds already is not counted twice; other light is.
    let light =
        DirectionalLight { illuminance: PI, affects_lightmapped_mesh_diffuse: false, ..default() };
    let down = Transform::from_xyz(0.0, 1.0, 0.0).looking_at(Vec3::ZERO, Vec3::X);
    let sun = scene.stage.spawn((light, down));
    scene.assert_middle(0.4, "lightmap that holds the sun");
    let light = DirectionalLight { affects_lightmapped_mesh_diffuse: true, ..light };
    scene.stage.world().entity_mut(sun).insert(light);
    scene.assert_middle(0.9, "lightmap and sun");
}

#[test]
fn irradiance_volumes() {
    let mut scene = Indirect::new();
    let size = Extent3d { width: 1, height: 2, depth_or_array_layers: 3 };
    let voxels = flat(size, TextureDimension::D3, 0.6);
    let voxels = scene.stage.world().resource_mut::<Assets<Image>>().add(voxels);
    scene.stage.spawn((
        LightProbe::default(),
        IrradianceVolume { voxels, intensity: 1.0, ..default() },
        Transform::from_scale(Vec3::splat(8.0)),
    ));
    scene.assert_middle(0.3, "irradiance volume");
}

#[test]
fn environment_maps() {
    let mut scene = Indirect::new();
    let uniform = {
        let mut images = scene.stage.world().resource_mut::<Assets<Image>>();
        let white = EnvironmentMapLight::solid_color(&mut images, Color::WHITE);
        EnvironmentMapLight { intensity: 0.8, ..white }
    };
    let camera = scene.camera;
    scene.stage.world().entity_mut(camera).insert(uniform.clone());
    scene.assert_middle(0.4, "uniform environment");
    // A lightmap holds it already.
    scene.lightmap(0.2);
    scene.assert_middle(0.1, "environment and lightmap");

    // Where it comes from matters.
    let mut scene = Indirect::new();
    let sky = {
        let mut images = scene.stage.world().resource_mut::<Assets<Image>>();
        let light = EnvironmentMapLight::hemispherical_gradient(
            &mut images,
            Color::WHITE,
            Color::srgb(0.5, 0.5, 0.5),
            Color::BLACK,
        );
        EnvironmentMapLight { intensity: 1.0, ..light }
    };
    let camera = scene.camera;
    scene.stage.world().entity_mut(camera).insert(sky);
    let up = at(&scene.stage.floats(), SIZE / 2, SIZE / 2);
    let plane = scene.plane;
    let tilted = Transform::from_rotation(Quat::from_rotation_x(1.2));
    scene.stage.world().entity_mut(plane).insert((tilted, NotShadowCaster));
    let aside = at(&scene.stage.floats(), SIZE / 2, SIZE / 2);
    println!("sky: up {up}, tilted {aside}");
    assert!(up.x > 1.2 * aside.x && aside.x > 0.05);
}

//! Lights of the file and added ones.

use std::f32::consts::PI;

use bevy::prelude::*;
use farlight::{
    baked::{
        BakedPart,
        format::manifest::{Direct, Light, LightKind},
    },
    prelude::*,
};
use serde_json::json;

use crate::{folder::Folder, stage::Stage};

fn light(name: &str, node: Option<u32>, kind: LightKind, intensity: f32) -> Light {
    Light {
        node,
        name: name.into(),
        direct: Direct::Baked,
        kind,
        position: [0.0, 0.0, 1.0],
        direction: [0.0, 0.0, -1.0],
        intensity: [intensity, intensity / 2.0, 0.0],
        range: 12.0,
        radius: 0.1,
    }
}

/// A square, a light of the file (node 1), and an added one that only the second scenario has.
fn folder(test: &str) -> Folder {
    let scenarios = [("noon", Vec3::splat(0.4)), ("evening", Vec3::splat(0.1))];
    let (folder, mut manifest) = Folder::square(test, &scenarios);
    let own = json!({"type": "point", "color": [1, 1, 1], "intensity": 7.0});
    folder.scene(&[Vec3::ZERO], &[own]);
    let noon = vec![
        light("own", Some(1), LightKind::Point, 3.0),
        light("sun", None, LightKind::Directional, 100.0),
    ];
    let mut lamp = light("lamp", None, LightKind::Spot { inner: 0.2, outer: 0.6 }, 50.0);
    lamp.direct = Direct::Realtime;
    let evening = vec![light("own", Some(1), LightKind::Point, 5.0), lamp];
    manifest.scenarios[0].lights = noon;
    manifest.scenarios[1].lights = evening;
    folder.manifest(&manifest);
    folder
}

fn near(a: f32, b: f32) -> bool {
    (a - b).abs() <= 1e-4 * b.abs().max(1e-3)
}

#[test]
fn lights_come_once_and_follow_the_weights() {
    let folder = folder("lights");
    let mut stage = Stage::new(&folder);
    let root = stage.lit();
    assert_eq!(stage.status(root).lights, 3);
    for (noon, evening) in [(1.0, 0.0), (0.5, 0.25), (0.0, 2.0)] {
        stage.lighting(root).scenarios =
            [("noon", noon), ("evening", evening)].into_iter().collect();
        for _ in 0..3 {
            stage.update();
        }
        let world = stage.world();
        let mut points = world.query::<(&PointLight, Has<BakedPart>)>();
        let (point, added) = points.single(world).unwrap();
        assert!(!added && !point.affects_lightmapped_mesh_diffuse);
        assert!(near(point.intensity, 4.0 * PI * (3.0 * noon + 5.0 * evening)), "{point:?}");
        assert!(near(point.color.to_linear().green, 0.5) && point.range == 12.0);
        let mut suns = world.query::<(&DirectionalLight, &ChildOf, &Transform)>();
        let (sun, parent, transform) = suns.single(world).unwrap();
        assert_eq!(parent.parent(), root);
        assert!(near(sun.illuminance, 100.0 * noon), "{sun:?}");
        assert_eq!(sun.shadow_maps_enabled, noon > 0.0, "no shadow map of no light");
        assert!(!sun.affects_lightmapped_mesh_diffuse);
        assert!(transform.forward().abs_diff_eq(Vec3::NEG_Z, 1e-5));
        let mut spots = world.query::<(&SpotLight, &Transform)>();
        let (spot, transform) = spots.single(world).unwrap();
        assert!(near(spot.intensity, 4.0 * PI * 50.0 * evening), "{spot:?}");
        assert!(spot.affects_lightmapped_mesh_diffuse, "its direct light is not baked");
        assert_eq!((spot.inner_angle, spot.outer_angle), (0.2, 0.6));
        assert_eq!(transform.translation, Vec3::Z);
    }
    stage.world().entity_mut(root).remove::<BakedLighting>();
    stage.update();
    stage.update();
    let world = stage.world();
    let point = *world.query::<&PointLight>().single(world).unwrap();
    assert!(near(point.intensity, 4.0 * PI * 7.0) && point.affects_lightmapped_mesh_diffuse);
    assert_eq!(world.query::<&DirectionalLight>().iter(world).count(), 0);
    assert_eq!(world.query::<&SpotLight>().iter(world).count(), 0);
}

/// A light whose direct light is baked leaves lightmapped surfaces' diffuse light alone, and lights a
/// thing beside them.
#[test]
fn baked_lights_light_what_has_no_lightmap() {
    let (folder, mut manifest) = Folder::square("roles", &[("noon", Vec3::splat(0.4))]);
    let mut sun = light("sun", None, LightKind::Directional, PI * 0.4);
    sun.intensity = [PI * 0.4; 3];
    manifest.scenarios[0].lights = vec![sun];
    folder.manifest(&manifest);
    let mut stage = Stage::new(&folder);
    stage.lit();
    let mesh = stage.world().resource_mut::<Assets<Mesh>>().add(Rectangle::new(1.0, 2.0));
    let material = stage.world().resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial {
        base_color: Color::linear_rgb(0.5, 0.5, 0.5),
        perceptual_roughness: 1.0,
        reflectance: 0.0,
        ..default()
    });
    let beside = Transform::from_xyz(0.5, 0.0, 0.5);
    stage.world().spawn((Mesh3d(mesh), MeshMaterial3d(material), beside));
    let picture = stage.picture();
    // The square has a specular reflection, which the lamp does not lose: 4 % at most, from a rough
    // surface.
    let left = picture.pixels[(32 * picture.width + 8) as usize];
    let diffuse = Srgba::from(LinearRgba::rgb(0.2, 0.2, 0.2)).red * 255.0;
    let brighter = f32::from(left[0]) - diffuse;
    assert!((-2.0..12.0).contains(&brighter), "{left:?} and {diffuse}");
    // Bevy's diffuse is Burley's: at roughness 1 and straight light it is Lambert's.
    stage.assert_pixel(&picture, 56, 32, Vec3::splat(0.2));
}

/// Suns of several scenarios that come and go keep their shadows.
#[test]
fn suns_below_a_roof_stay_out() {
    let scenarios = [("noon", Vec3::ZERO), ("evening", Vec3::ZERO)];
    let (folder, mut manifest) = Folder::square("suns", &scenarios);
    for (scenario, tilt) in manifest.scenarios.iter_mut().zip([0.1, -0.1]) {
        let mut sun = light("sun", None, LightKind::Directional, 1.0);
        sun.intensity = [10.0; 3];
        sun.direction = Vec3::new(tilt, 0.0, -1.0).normalize().to_array();
        scenario.lights = vec![sun];
    }
    folder.manifest(&manifest);
    let mut stage = Stage::new(&folder);
    let root = stage.lit();
    // A square that is no part of the bake, and a roof over it behind the camera.
    let mesh = stage.world().resource_mut::<Assets<Mesh>>().add(Rectangle::new(9.0, 9.0));
    let material = stage.world().resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial {
        double_sided: true,
        cull_mode: None,
        ..default()
    });
    for z in [0.5, 3.0] {
        let parts = (Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()));
        stage.world().spawn((parts, Transform::from_xyz(0.0, 0.0, z)));
    }
    for t in [0.0, 0.5, 1.0, 0.5, 0.0, 0.5] {
        stage.lighting(root).scenarios.blend("noon", "evening", t);
        let picture = stage.picture();
        assert!(picture.mean() < 2.0, "sunlight comes through the roof at {t}: {}", picture.mean());
    }
}

/// The sun behind a single-sided wall lights nothing in front of it, unless that is asked for.
#[test]
fn backs_of_walls_cast_shadows() {
    let (folder, mut manifest) = Folder::square("backs", &[("noon", Vec3::ZERO)]);
    let mut sun = light("sun", None, LightKind::Directional, 1.0);
    sun.intensity = [10.0; 3];
    sun.direction = Vec3::new(0.0, -0.9, 0.43).normalize().to_array();
    manifest.scenarios[0].lights = vec![sun];
    folder.manifest(&manifest);
    let mut stage = Stage::new(&folder);
    let root = stage.lit();
    // A board that is no part of the bake, turned up to the sun and to the camera.
    let mesh = stage.world().resource_mut::<Assets<Mesh>>().add(Rectangle::new(1.0, 1.0));
    let material = stage.world().resource_mut::<Assets<StandardMaterial>>().add(Color::WHITE);
    let board = Transform::from_xyz(0.0, -0.3, 0.5).with_rotation(Quat::from_rotation_x(-0.8));
    stage.world().spawn((Mesh3d(mesh), MeshMaterial3d(material), board));
    for solid_backs in [true, false, true] {
        stage.lighting(root).solid_backs = solid_backs;
        for _ in 0..4 {
            stage.update();
        }
        stage.until_lit(root);
        let picture = stage.picture();
        let [board, ..] = picture.pixels[(42 * picture.width + 32) as usize];
        assert_eq!(board < 3, solid_backs, "{board}");
        let world = stage.world();
        let twins = world.query_filtered::<(), (With<BakedPart>, With<Mesh3d>)>();
        assert_eq!({ twins }.iter(world).count(), usize::from(solid_backs));
    }
    stage.world().entity_mut(root).remove::<BakedLighting>();
    stage.update();
    let world = stage.world();
    assert_eq!(world.query_filtered::<(), With<BakedPart>>().iter(world).count(), 0);
}

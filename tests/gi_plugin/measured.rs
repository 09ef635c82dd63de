//! Surfaces whose material the lighting does not know: measured materials, and whatever carries a
//! `DiffuseReflectance`.

use std::{sync::Arc, time::Duration};

use bevy::{pbr::Lightmap, prelude::*};
use farlight::{
    btf::{BtfStatus, codec::synthetic},
    core::DiffuseReflectance,
    gi::{
        ExtractedScene,
        solver::{SceneChange, atlas::TexelRect, scene, scene::InstanceId, session::SessionChange},
    },
    prelude::*,
};

use crate::{
    Flat, lightmapped_quad,
    pictures::{SIZE, Stage},
    rooms::solve,
    support::{self, flip, headless::Picture},
};

/// What the measured floor reflects: a saturated red.
const RED: [f32; 3] = [0.8, 0.1, 0.05];

fn measured(world: &mut World, albedo: [f32; 3]) -> MeshMaterial3d<BtfMaterial> {
    let btf = BtfAsset(Arc::new(synthetic::lambert(albedo, [4, 4]).unwrap()));
    let btf = world.resource_mut::<Assets<BtfAsset>>().add(btf);
    MeshMaterial3d(world.resource_mut::<Assets<BtfMaterial>>().add(BtfMaterial::new(btf)))
}

/// Runs frames until the entity's reflectance is known.
fn known(flat: &mut Flat, entity: Entity) -> Vec3 {
    let patience = std::time::Instant::now() + Duration::from_secs(60);
    loop {
        flat.settle();
        if let Some(albedo) = flat.world().get::<DiffuseReflectance>(entity).unwrap().albedo {
            flat.settle();
            return albedo;
        }
        assert!(std::time::Instant::now() < patience, "the reflectance doesn't become known");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn submitted(flat: &mut Flat, entity: Entity) -> Option<(scene::Material, bool)> {
    let id = InstanceId(entity.to_bits());
    let extracted = flat.world().resource::<ExtractedScene>();
    let instance = extracted.scene.instances.get(&id)?;
    let material = extracted.scene.materials[&instance.material].clone();
    Some((material, extracted.receivers.contains(&id)))
}

#[test]
fn a_measured_surface_arrives_in_its_mean_colour_and_follows_its_gain() {
    let mut flat = Flat::new();
    let material = measured(flat.world(), RED);
    let mesh = flat.mesh(lightmapped_quad(1.0));
    let quad = flat.world().spawn((GiScene, Mesh3d(mesh), material.clone())).id();
    flat.app.update();
    assert_eq!(flat.left_out(quad), None, "what is on its way is not left out");
    let albedo = known(&mut flat, quad);
    assert!((albedo - Vec3::from(RED)).abs().max_element() < 0.005, "{albedo}");
    let (sent, receives) = submitted(&mut flat, quad).expect("it is part of the scene");
    assert_eq!(sent.base_color, albedo.extend(1.0));
    assert_eq!((sent.metallic, sent.emissive, sent.double_sided), (0.0, Vec3::ZERO, false));
    assert!(receives && sent.base_color_texture.is_none());
    flat.mock.take_changes();

    // Neither geometry nor place: the solver's rays stay.
    let change = |flat: &mut Flat, change: fn(&mut BtfMaterial)| {
        let mut materials = flat.world().resource_mut::<Assets<BtfMaterial>>();
        change(&mut materials.get_mut(&material.0).unwrap());
        flat.settle();
        let changes = flat.mock.take_changes();
        assert!(
            matches!(&changes[..], [SessionChange::Scene(SceneChange::SetMaterial(..))]),
            "{changes:?}"
        );
    };
    change(&mut flat, |material| material.gain = 0.5);
    let (sent, _) = submitted(&mut flat, quad).unwrap();
    assert!((sent.base_color.truncate() - 0.5 * albedo).abs().max_element() < 1e-6);
    // No surface reflects more light than arrives.
    change(&mut flat, |material| material.gain = 5.0);
    let (sent, _) = submitted(&mut flat, quad).unwrap();
    assert!(sent.base_color.x == 1.0 && sent.base_color.y < 0.6, "{}", sent.base_color);
    change(&mut flat, |material| material.double_sided = true);
    assert!(submitted(&mut flat, quad).unwrap().0.double_sided);
    change(&mut flat, |material| material.gain = f32::NAN);
    assert_eq!(submitted(&mut flat, quad).unwrap().0.base_color, albedo.extend(1.0));

    // Another file under the same handle.
    let green = Arc::new(synthetic::lambert([0.1, 0.6, 0.1], [4, 4]).unwrap());
    let btf = flat.world().resource::<Assets<BtfMaterial>>().get(&material.0).unwrap().btf.clone();
    flat.world().resource_mut::<Assets<BtfAsset>>().insert(&btf, BtfAsset(green)).unwrap();
    let patience = std::time::Instant::now() + Duration::from_secs(60);
    while submitted(&mut flat, quad).unwrap().0.base_color.y < 0.5 {
        flat.settle();
        assert!(std::time::Instant::now() < patience, "the new colour doesn't arrive");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn materials_come_and_go() {
    let mut flat = Flat::new();
    let material = measured(flat.world(), RED);
    let quad = flat.quad();
    let standard = flat.world().get::<MeshMaterial3d<StandardMaterial>>(quad).unwrap().clone();
    flat.world().entity_mut(quad).insert(GiScene);
    flat.settle();
    assert_eq!(submitted(&mut flat, quad).unwrap().0.base_color, Vec4::ONE);
    flat.world()
        .entity_mut(quad)
        .remove::<MeshMaterial3d<StandardMaterial>>()
        .insert(material.clone());
    known(&mut flat, quad);
    assert!(submitted(&mut flat, quad).unwrap().0.base_color.y < 0.2);
    // A StandardMaterial says more.
    flat.world().entity_mut(quad).insert(standard);
    flat.settle();
    assert_eq!(submitted(&mut flat, quad).unwrap().0.base_color, Vec4::ONE);
    flat.world().entity_mut(quad).remove::<MeshMaterial3d<StandardMaterial>>();
    flat.settle();
    assert!(submitted(&mut flat, quad).unwrap().0.base_color.y < 0.2);
    // Without any, it goes, and with it all that it used.
    flat.world().entity_mut(quad).remove::<MeshMaterial3d<BtfMaterial>>();
    flat.settle();
    assert!(!flat.world().entity(quad).contains::<DiffuseReflectance>());
    assert_eq!(submitted(&mut flat, quad), None);
    let reason = flat.left_out(quad).unwrap();
    assert!(reason.contains("DiffuseReflectance"), "{reason}");
    // A game's own material.
    let own = DiffuseReflectance { albedo: Some(Vec3::splat(0.25)), double_sided: true };
    flat.world().entity_mut(quad).insert(own);
    flat.settle();
    let (sent, receives) = submitted(&mut flat, quad).unwrap();
    assert_eq!((sent.base_color, receives), (Vec3::splat(0.25).extend(1.0), true));
    assert!(sent.double_sided);
    assert_eq!(flat.left_out(quad), None);
    flat.world().entity_mut(quad).despawn();
    flat.settle();
    let extracted = flat.world().resource::<ExtractedScene>();
    assert!(extracted.scene.instances.is_empty() && extracted.scene.materials.is_empty());
}

/// Runs frames until materials are on the GPU.
fn load(stage: &mut Stage) {
    let ready = |world: &mut World| {
        let status = world.resource::<BtfStatus>();
        status.waiting == 0 && status.resident > 0
    };
    let loaded = stage.headless.update_until("materials", Duration::from_secs(60), ready);
    loaded.unwrap_or_else(|problem| panic!("{problem}"));
}

#[test]
fn lightmaps_come_move_and_go_on_a_measured_surface() {
    let mut stage = Stage::new();
    let mesh = stage.world().resource_mut::<Assets<Mesh>>().add(lightmapped_quad(2.0));
    let material = measured(stage.world(), [0.5; 3]);
    let quad = stage.world().spawn((GiScene, Mesh3d(mesh), material)).id();
    load(&mut stage);
    stage.settle();
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::ZERO);
    for (x, light) in [(8, 0.8), (32, 0.4)] {
        let rect = TexelRect { x, y: 16, width: 16, height: 16 };
        stage.mock.place(quad, rect, |_, _| Vec3::splat(light));
        stage.settle();
        let picture = stage.picture();
        stage.assert_all(&picture, Vec3::splat(0.5 * light));
    }
    stage.world().entity_mut(quad).remove::<GiScene>();
    stage.settle();
    assert!(!stage.world().entity(quad).contains::<Lightmap>());
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::ZERO);
}

/// A white room over a red floor, lit by a shining panel below the ceiling alone: all that is seen
/// of it is indirect. A red ball hangs in it, lit by probes.
struct Room {
    stage: Stage,
    floor: Entity,
    ceiling: Entity,
}

impl Room {
    /// With the same colour as a measured or as a standard material.
    fn new(is_measured: bool) -> Self {
        let mut stage = Stage::solved();
        stage.world().insert_resource(GiSettings {
            page_size: 128,
            max_pages: 1,
            texels_per_metre: 6.0,
            rays_per_texel: 256,
            rays_per_probe: 512,
            converged_paths: 256,
            seed: 5,
            ..default()
        });
        let standard = |stage: &mut Stage, color: Vec3, glow: f32| {
            let material = StandardMaterial {
                base_color: Color::linear_rgb(color.x, color.y, color.z),
                emissive: LinearRgba::gray(glow),
                emissive_exposure_weight: 1.0,
                perceptual_roughness: 1.0,
                reflectance: 0.0,
                ..default()
            };
            MeshMaterial3d(stage.world().resource_mut::<Assets<StandardMaterial>>().add(material))
        };
        let add = |stage: &mut Stage, mesh: Mesh| {
            Mesh3d(stage.world().resource_mut::<Assets<Mesh>>().add(mesh))
        };
        let white = standard(&mut stage, Vec3::splat(0.8), 0.0);
        let wall = add(&mut stage, lightmapped_quad(2.0));
        let root = stage.world().spawn((GiScene, Transform::default(), Visibility::default())).id();
        let place = |outward: Vec3| {
            Transform::from_translation(outward)
                .with_rotation(Quat::from_rotation_arc(Vec3::Z, -outward))
        };
        let walls = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z, Vec3::Y].map(|outward| {
            let bundle = (wall.clone(), white.clone(), place(outward), ChildOf(root));
            stage.world().spawn(bundle).id()
        });
        let panel = add(&mut stage, lightmapped_quad(1.0));
        let glow = standard(&mut stage, Vec3::ZERO, 6.0);
        stage.world().spawn((panel, glow, place(0.9 * Vec3::Y), ChildOf(root)));
        // Panels shine to both sides; this one must not light the ceiling.
        let shade = add(&mut stage, lightmapped_quad(1.2));
        let black = standard(&mut stage, Vec3::ZERO, 0.0);
        stage.world().spawn((shade, black, place(0.92 * Vec3::Y), ChildOf(root)));
        let floor = stage.world().spawn((wall, place(Vec3::NEG_Y), ChildOf(root))).id();
        let ball = add(&mut stage, Sphere::new(0.25).mesh().uv(24, 16));
        let ball = stage.world().spawn((ball, Transform::from_xyz(0.4, -0.3, 0.0))).id();
        if is_measured {
            let material = measured(stage.world(), RED);
            for entity in [floor, ball] {
                stage.world().entity_mut(entity).insert(material.clone());
            }
            load(&mut stage);
        } else {
            let material = standard(&mut stage, RED.into(), 0.0);
            for entity in [floor, ball] {
                stage.world().entity_mut(entity).insert(material.clone());
            }
        }
        let probes = Transform::from_scale(Vec3::splat(2.0));
        stage.world().spawn((GiProbeVolume { resolution: UVec3::splat(3) }, probes));
        let view =
            Transform::from_xyz(0.0, 0.4, 0.9).looking_at(Vec3::new(0.0, -0.4, 0.0), Vec3::Y);
        let camera = stage.camera;
        let eye = PerspectiveProjection { fov: 1.6, ..default() };
        stage.world().entity_mut(camera).insert((view, Projection::from(eye)));
        // Let everything be submitted before asking whether it is solved.
        for _ in 0..8 {
            stage.update();
        }
        solve(&mut stage);
        Self { stage, floor, ceiling: walls[4] }
    }

    /// Texels of a mesh's lightmap but for its rim, row by row.
    fn texels(&mut self, entity: Entity) -> Vec<Vec3> {
        let lightmaps = self.stage.world().resource::<GiLightmaps>();
        let placement = lightmaps.placement(entity).expect("it has a lightmap");
        let rect = placement.rect;
        let rows = rect.y + 1..rect.y + rect.height - 1;
        rows.flat_map(|y| (rect.x + 1..rect.x + rect.width - 1).map(move |x| (x, y)))
            .map(|(x, y)| lightmaps.texel(placement.page, x, y).unwrap())
            .collect()
    }
}

fn mean(texels: &[Vec3]) -> Vec3 {
    texels.iter().sum::<Vec3>() / texels.len() as f32
}

#[test]
fn a_room_with_a_measured_floor_is_lit_as_with_a_standard_one() {
    let [mut measured, mut standard] = [true, false].map(Room::new);
    let pairs = [
        ("floor", measured.floor, standard.floor),
        ("ceiling", measured.ceiling, standard.ceiling),
    ];
    for (what, entity, twin) in pairs {
        let (found, expected) = (measured.texels(entity), standard.texels(twin));
        assert_eq!(found.len(), expected.len());
        let (found_mean, expected_mean) = (mean(&found), mean(&expected));
        println!("{what}: {found_mean} for {expected_mean}");
        // The same rays over the same geometry; the floor's tables and the rest of noise (which
        // stands still at different samples) differ.
        let off = (found_mean / expected_mean - 1.0).abs().max_element();
        assert!(off < 0.02, "{what}: {found_mean} instead of {expected_mean}");
        let apart: f32 =
            found.iter().zip(&expected).map(|(a, b)| (a - b).abs().element_sum()).sum::<f32>();
        let apart = apart / found.len() as f32 / expected_mean.element_sum();
        assert!(apart < 0.05, "{what}: texels differ by {apart}");
    }
    // What the panel sends down comes back from the floor, in its colour.
    let ceiling = measured.ceiling;
    let ceiling = mean(&measured.texels(ceiling));
    assert!(ceiling.x > 1.5 * ceiling.y && ceiling.y > 0.0, "{ceiling}");

    let pictures = [&mut measured, &mut standard].map(|room| room.stage.picture());
    for (picture, name) in pictures.iter().zip(["measured", "standard"]) {
        picture.save(support::scratch(&format!("gi_plugin/room-{name}.png"))).unwrap();
    }
    let [found, expected] = &pictures;
    let difference = flip::between(expected, found);
    println!(
        "room: FLIP mean {:.4}, 99th percentile {:.4}",
        difference.mean(),
        difference.percentile(0.99)
    );
    assert!(expected.mean() > 20.0, "too dark to say anything");
    assert!(difference.mean() < 0.02 && difference.percentile(0.99) < 0.1);
    let pixel = |picture: &Picture, x: u32, y: u32| picture.pixels[(y * SIZE + x) as usize];
    let (x, y) = (SIZE * 45 / 64, SIZE * 33 / 64);
    let (ball, twin) = (pixel(found, x, y), pixel(expected, x, y));
    println!("ball: {ball:?} for {twin:?}");
    // Rounding of the picture and of half floats.
    assert!(ball.iter().zip(twin).all(|(found, expected)| found.abs_diff(expected) <= 3));
    assert!(twin[0] > 100 && twin[0] > 2 * twin[1], "the ball is not where the test looks");
}

//! What only shows from inside: that choices made for speed do not change the mean.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};

use super::*;
use crate::{
    Scene,
    sampling::{Rng, hash_pair, uniform_sphere},
    scene::{
        AlphaMode, Instance, InstanceId, Light, LightId, LightKind, Material, MaterialId, Mesh,
        MeshId, Sky, SkyImage, Texture, TextureId,
    },
};

fn add(scene: &mut Scene, mesh: Mesh, material: Material) {
    let id = scene.meshes.len() as u64;
    scene.meshes.insert(MeshId(id), Arc::new(mesh));
    scene.materials.insert(MaterialId(id), material);
    let (mesh, material) = (MeshId(id), MaterialId(id));
    let instance = Instance { mesh, material, transform: Affine3A::IDENTITY };
    scene.instances.insert(InstanceId(id), instance);
}

/// The faces of a tetrahedron in different colours; `faces` of the four.
fn tetrahedron(faces: usize) -> Scene {
    let mut scene = Scene::default();
    let corners = [Vec3::ZERO, Vec3::X * 3.0, Vec3::Y * 3.0, Vec3::Z * 3.0];
    let all = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
    for (i, face) in all.into_iter().take(faces).enumerate() {
        let mesh = Mesh { positions: corners.to_vec(), triangles: vec![face], ..Mesh::default() };
        let albedo = 0.3 + 0.2 * i as f32;
        let base_color = Vec4::new(albedo, 1.0 - albedo, 0.8, 1.0);
        add(&mut scene, mesh, Material { base_color, ..Material::default() });
    }
    scene
}

/// Mean and standard error of the light at a point from independent paths, cosine-distributed about
/// +x, with or without sampling emitters and the sky at the point itself.
fn irradiance(tracer: &PathTracer<'_>, seed: u64, weighed: bool) -> (f64, f64) {
    let n = 60_000_u32;
    let origin = Vec3::splat(0.5);
    let normal = Vec3::X;
    let frame = Frame::new(normal);
    let pdf_of = |d: Vec3| normal.dot(d).max(0.0) * FRAC_1_PI;
    let (mut sum, mut squares) = (0.0_f64, 0.0_f64);
    for i in 0..n {
        // Sets of one path each: independent, so that the spread of single paths is the error.
        let mut sampler = PathSampler::new(hash_pair(seed, i.into()), 0, 0);
        let local = cosine_hemisphere(sampler.next_2d());
        let direction = frame.to_world(local);
        let mut light = Vec3::ZERO;
        let arriving = if weighed {
            for toward in [
                tracer.toward_emitter(origin, &mut sampler, pdf_of),
                tracer.toward_sky(origin, &mut sampler, pdf_of),
            ]
            .into_iter()
            .flatten()
            {
                light += toward.weighted * pdf_of(toward.direction);
            }
            tracer.trace_weighed(origin, direction, Some(pdf_of(direction)), &mut sampler)
        } else {
            tracer.trace(origin, direction, &mut sampler)
        };
        light += arriving.sky + arriving.indirect;
        let x = f64::from(light.element_sum());
        sum += x;
        squares += x * x;
    }
    let n = f64::from(n);
    (sum / n, ((squares / n - (sum / n).powi(2)) / n).sqrt())
}

#[track_caller]
fn same((a, a_se): (f64, f64), (b, b_se): (f64, f64), relative_se: f64) {
    let z = (a - b) / a_se.hypot(b_se);
    assert!(z.abs() < 4.5, "{a} +- {a_se}, {b} +- {b_se}: z = {z}");
    assert!(a_se < relative_se * a && b_se < relative_se * b, "{a} +- {a_se}, {b} +- {b_se}");
}

/// However early paths are ended, the mean stays the same.
#[test]
fn roulette_is_unbiased() {
    let mut scene = tetrahedron(4);
    let light = Light {
        kind: LightKind::Point,
        position: Vec3::new(0.3, 0.9, 0.6),
        direction: -Vec3::Y,
        intensity: Vec3::ONE,
        range: f32::INFINITY,
    };
    scene.lights.insert(LightId(0), light);
    let world = World::new(&scene);
    let with = |roulette| PathTracer { roulette, ..PathTracer::new(&world) };
    let never = with(Roulette { threshold: 1e-6, forced_after: 1000 });
    let truth = irradiance(&never, 1, false);
    for (i, roulette) in [
        Roulette::STANDARD,
        Roulette { threshold: 1.0, forced_after: 24 },
        Roulette { threshold: 0.1, forced_after: 0 },
        Roulette { threshold: 3.0, forced_after: 0 },
    ]
    .into_iter()
    .enumerate()
    {
        same(irradiance(&with(roulette), 2 + i as u64, false), truth, 0.02);
    }
}

/// Sampling emitters gives the same mean as meeting them by chance, for emitters that are plain,
/// textured, or cut out, and with far less noise where they are small.
#[test]
fn sampling_emitters_is_unbiased() {
    let mut scene = tetrahedron(4);
    let texture = |texels: [[u8; 4]; 4]| Texture {
        width: 2,
        height: 2,
        texels: texels.to_vec(),
        srgb: false,
    };
    let (white, black) = ([255; 4], [0, 0, 0, 255]);
    scene.textures.insert(TextureId(0), Arc::new(texture([white, black, black, black])));
    let holes = texture([white, [255, 255, 255, 0], [255, 255, 255, 0], white]);
    scene.textures.insert(TextureId(1), Arc::new(holes));
    let quad = |corner: Vec3, size: f32| Mesh {
        positions: [Vec3::ZERO, Vec3::Y, Vec3::Y + Vec3::Z, Vec3::Z]
            .map(|p| corner + p * size)
            .to_vec(),
        uv0: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let glowing = Material {
        base_color: Vec4::new(0.5, 0.5, 0.5, 1.0),
        emissive: Vec3::new(2.0, 3.0, 4.0),
        ..Material::default()
    };
    add(&mut scene, quad(Vec3::new(1.2, 0.2, 0.2), 0.3), glowing.clone());
    let textured = Material { emissive_texture: Some(TextureId(0)), ..glowing.clone() };
    add(&mut scene, quad(Vec3::new(1.0, 0.6, 0.6), 0.4), textured);
    let cut_out = Material {
        base_color_texture: Some(TextureId(1)),
        alpha_mode: AlphaMode::Mask(0.5),
        ..glowing
    };
    add(&mut scene, quad(Vec3::new(0.9, 0.1, 0.9), 0.5), cut_out);
    let world = World::new(&scene);
    let chance = PathTracer { emitters: Emitters::default(), ..PathTracer::new(&world) };
    let sampled = PathTracer::new(&world);
    let truth = irradiance(&chance, 1, false);
    let found = irradiance(&sampled, 2, true);
    same(found, truth, 0.04);
    same(irradiance(&sampled, 3, false), truth, 0.04);
    assert!(found.1 < 0.5 * truth.1, "{found:?} {truth:?}");
}

/// Sampling the sky image gives the same mean as meeting its bright texels by chance.
#[test]
fn sampling_the_sky_is_unbiased() {
    // One face is open.
    let mut scene = tetrahedron(3);
    let mut rng = Rng::new(5, 0);
    let texels = (0..32 * 16)
        .map(|i| Vec3::new(0.1, 0.2, 0.3) * rng.next_f32() * if i % 50 == 0 { 40.0 } else { 1.0 });
    scene.sky = Sky::Image {
        image: Arc::new(SkyImage { width: 32, height: 16, texels: texels.collect() }),
        rotation: Quat::from_rotation_z(0.5) * Quat::from_rotation_y(1.0),
        scale: 2.0,
    };
    let world = World::new(&scene);
    let chance = PathTracer { sky: None, ..PathTracer::new(&world) };
    let sampled = PathTracer::new(&world);
    let truth = irradiance(&chance, 1, false);
    let found = irradiance(&sampled, 2, true);
    same(found, truth, 0.04);
    same(irradiance(&sampled, 3, false), truth, 0.04);
    assert!(found.1 < 0.6 * truth.1, "{found:?} {truth:?}");
}

/// Directions over the whole sphere end somewhere, whatever the scene.
#[test]
fn an_empty_world_is_black() {
    let world = World::new(&Scene::default());
    let tracer = PathTracer::new(&world);
    let mut rng = Rng::new(1, 0);
    for i in 0..100 {
        let direction = uniform_sphere(rng.next_2d().into());
        let arriving = tracer.trace(Vec3::ZERO, direction, &mut PathSampler::new(1, i, 8));
        assert_eq!(arriving, Arriving { distance: f32::INFINITY, ..Arriving::default() });
    }
}

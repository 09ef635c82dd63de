//! Surfaces that are smooth, mirrored, or stand in each other's way.

use std::{f32::consts::PI, sync::Arc};

use farlight_gi_solver::{
    Scene, World,
    bake::{
        Density, DirectLight, Gathered, Gatherer, GathererSettings, Layout, LayoutSettings, direct,
        pages,
    },
    estimate::no_progress,
    scene::{
        DirectSky, Instance, InstanceId, Light, LightId, LightKind, Material, MaterialId, Mesh,
        MeshId, Sky,
    },
};
use glam::{Affine3A, Vec2, Vec3};

use crate::{common::Builder, scenes::built};

const SETTINGS: GathererSettings =
    GathererSettings { seed: 5, bounces: 0, direct_sky: DirectSky::Included };

fn layout(scene: &Scene, world: &World, density: f32) -> Layout {
    let settings =
        LayoutSettings { page_size: 128, max_pages: 1, density: Density::TexelsPerMetre(density) };
    Layout::new(scene, world, scene.instances.keys().copied(), &settings)
}

/// A ball of few triangles with normals as if it were round; the poles are left out.
fn ball() -> Mesh {
    let (columns, rows) = (12_u32, 6_u32);
    let mut mesh = Mesh::default();
    for y in 0..=rows {
        for x in 0..=columns {
            let (u, v) = (x as f32 / columns as f32, 0.1 + 0.8 * y as f32 / rows as f32);
            let (sin, cos) = (v * PI).sin_cos();
            let p = Vec3::new(sin * (u * 2.0 * PI).sin(), cos, sin * (u * 2.0 * PI).cos());
            mesh.positions.push(p);
            mesh.normals.push(p);
            mesh.uv1.push(Vec2::new(u, y as f32 / rows as f32));
        }
    }
    for y in 0..rows {
        for x in 0..columns {
            let a = y * (columns + 1) + x;
            let b = a + columns + 1;
            mesh.triangles.push([a, b, b + 1]);
            mesh.triangles.push([a, b + 1, a + 1]);
        }
    }
    mesh
}

fn alone(mesh: Mesh, transform: Affine3A) -> Scene {
    let mut scene = Scene::default();
    scene.meshes.insert(MeshId(0), Arc::new(mesh));
    scene.materials.insert(MaterialId(0), Material::default());
    let instance = Instance { mesh: MeshId(0), material: MaterialId(0), transform };
    scene.instances.insert(InstanceId(0), instance);
    scene.sky = Sky::Constant(Vec3::ONE);
    scene
}

/// Under light that is the same from everywhere a ball is the same all over, however its normals lean.
#[test]
fn smooth_normals_do_not_darken() {
    for mirror in [1.0, -1.0] {
        let scene = alone(ball(), Affine3A::from_scale(Vec3::new(mirror, 1.0, 1.0)));
        let world = World::new(&scene);
        let layout = layout(&scene, &world, 8.0);
        let mut bent = 0;
        for texel in layout.texels() {
            assert!(texel.normal.dot(texel.position) > 0.8, "outwards: {texel:?}");
            assert!(texel.geometric.dot(texel.position) > 0.8, "outwards: {texel:?}");
            assert!((texel.normal.length() - 1.0).abs() < 1e-4);
            bent += i32::from(texel.normal != texel.geometric);
        }
        assert!(bent > layout.len() as i32 / 2);
        let gatherer = Gatherer::new(&world, &layout, SETTINGS, no_progress()).unwrap();
        let mut gathered = Gathered::new(&layout);
        gatherer.pass(&mut gathered, 32, no_progress()).unwrap();
        for (i, texel) in layout.texels().enumerate().filter(|(_, t)| t.open) {
            let e = gathered.irradiance(i).x / PI;
            assert!((e - 1.0).abs() < 0.02, "{e} at {texel:?}");
        }
    }
}

/// The sun on a ball of few triangles: no triangle is in its own shadow before the ball is.
#[test]
fn triangles_are_not_in_their_own_shadow() {
    let scene = alone(ball(), Affine3A::IDENTITY);
    let world = World::new(&scene);
    let layout = layout(&scene, &world, 8.0);
    let light = Light {
        kind: LightKind::Directional,
        position: Vec3::ZERO,
        direction: Vec3::new(-1.0, -0.3, 0.0).normalize(),
        intensity: Vec3::ONE,
        range: f32::INFINITY,
    };
    let found =
        direct(&world, &layout, &[DirectLight { light, radius: 0.0 }], no_progress()).unwrap();
    let mut lit = 0;
    for (e, texel) in found.iter().zip(layout.texels()) {
        let cos = texel.normal.dot(-light.direction);
        if cos > 0.25 {
            // The texel's mean is not the value at its point.
            assert!((e.x - cos).abs() < 0.12, "{} instead of {cos} at {texel:?}", e.x);
            lit += 1;
        } else if cos < -0.15 {
            assert!(e.x < 0.01, "{} behind at {texel:?}", e.x);
        }
    }
    assert!(lit > 100);
}

/// In a closed room whose walls all emit and reflect alike the irradiance is π L / (1 - albedo); bounces
/// are counted to the last.
#[test]
fn light_between_walls_adds_up() {
    for (bounces, expected) in [(0, 2.0), (1, 1.5), (2, 1.75), (4, 1.9375)] {
        let mut b = Builder::default();
        let white = Vec3::splat(0.5);
        b.room(Vec3::ZERO, Vec3::new(3.0, 2.0, 4.0), [white; 6], Vec3::ONE);
        let (scene, _) = built(b);
        let world = World::new(&scene);
        let layout = layout(&scene, &world, 6.0);
        let settings = GathererSettings { bounces, ..SETTINGS };
        let gatherer = Gatherer::new(&world, &layout, settings, no_progress()).unwrap();
        let mut gathered = Gathered::new(&layout);
        gatherer.pass(&mut gathered, 64, no_progress()).unwrap();
        let sum: f32 = (0..layout.len()).map(|i| gathered.irradiance(i).x / PI).sum();
        let mean = sum / layout.len() as f32;
        println!("{bounces} bounces: {mean} instead of {expected}");
        assert!((mean / expected - 1.0).abs() < 3e-3, "{bounces}: {mean} {expected}");
    }
}

/// Perfect reflectors keep light for ever: what comes out is finite, however they are made.
#[test]
fn perfect_reflectors_do_not_explode() {
    let mut b = Builder::default();
    b.room(Vec3::ZERO, Vec3::splat(2.0), [Vec3::ONE; 6], Vec3::ZERO);
    // Half of the light meets a shell without texels first.
    let mut shell = crate::common::quad(Vec3::new(0.0, 1.0, 0.0), Vec3::X * 2.0, Vec3::Z * 2.0);
    shell.uv1.clear();
    b.add(shell, Vec3::ONE, Vec3::ZERO);
    b.point_light(1, Vec3::new(1.0, 0.5, 1.0), Vec3::ONE);
    let (scene, _) = built(b);
    let world = World::new(&scene);
    let layout = layout(&scene, &world, 4.0);
    let gatherer = Gatherer::new(&world, &layout, SETTINGS, no_progress()).unwrap();
    let mut gathered = Gathered::new(&layout);
    gatherer.pass(&mut gathered, 16, no_progress()).unwrap();
    for i in 0..layout.len() {
        assert!(gathered.irradiance(i).max_element() < 1e4, "{}", gathered.irradiance(i));
    }
}

/// A thin wall stands across the texels of a floor, a box stands on it: no light gets through, and the
/// floor is as bright at the foot of the wall as the wall lets it be.
#[test]
fn walls_neither_leak_nor_darken() {
    let mut b = Builder::default();
    // A closed room of two halves, the wall between them at x = 2.1, in the middle of a texel.
    let (x, y, z) = (Vec3::X * 4.0, Vec3::Y * 2.0, Vec3::Z * 4.0);
    let white = Vec3::splat(0.7);
    b.room(Vec3::ZERO, Vec3::new(4.0, 2.0, 4.0), [white; 6], Vec3::ZERO);
    let wall = Vec3::X * 2.1;
    b.quad(wall, y, z, white);
    b.quad(wall + Vec3::X * 0.01, z, y, white);
    // A box on the floor of the lit half, its sides without textures.
    let (low, size) = (Vec3::new(0.55, -0.02, 1.05), 0.7);
    for (origin, u, v) in [
        (low + Vec3::Y * size, Vec3::Z, Vec3::X),
        (low, Vec3::X, Vec3::Z),
        (low, Vec3::Y, Vec3::X),
        (low + Vec3::Z * size, Vec3::X, Vec3::Y),
        (low, Vec3::Z, Vec3::Y),
        (low + Vec3::X * size, Vec3::Y, Vec3::Z),
    ] {
        let mut side = crate::common::quad(origin, u * size, v * size);
        side.uv1.clear();
        b.add(side, white, Vec3::ZERO);
    }
    b.point_light(1, Vec3::new(1.0, 1.7, 2.0), Vec3::splat(100.0));
    let _ = x;
    let (mut scene, receivers) = built(b);
    scene.instances.retain(|id, _| receivers.contains(id) || id.0 > 7);
    let world = World::new(&scene);
    let settings =
        LayoutSettings { page_size: 128, max_pages: 1, density: Density::TexelsPerMetre(5.0) };
    let layout = Layout::new(&scene, &world, receivers.iter().copied(), &settings);
    let lights: Vec<_> = scene.lights[&LightId(1)].into_direct();
    let gatherer = Gatherer::new(&world, &layout, SETTINGS, no_progress()).unwrap();
    let mut gathered = Gathered::new(&layout);
    gatherer.pass(&mut gathered, 256, no_progress()).unwrap();
    let straight = direct(&world, &layout, &lights, no_progress()).unwrap();
    let total: Vec<Vec3> =
        (0..layout.len()).map(|i| gathered.irradiance(i) + straight[i]).collect();
    let mean = |of: &dyn Fn(Vec3) -> bool| {
        let floor = layout
            .texels()
            .zip(&total)
            .filter(|(t, _)| t.instance == receivers[0] && t.open && of(t.position));
        let (sum, n) = floor.fold((0.0, 0), |(s, n), (_, e)| (s + e.x, n + 1));
        assert!(n > 0);
        sum / n as f32
    };
    let bright = mean(&|p| p.x < 1.9);
    let dark = mean(&|p| p.x > 2.15);
    assert!(dark < bright * 1e-3, "the dark half has {dark}, the lit one {bright}");
    // Along the wall's foot, in the lit half: nothing darker than half of what is near.
    let near = mean(&|p| (1.5..1.9).contains(&p.x));
    let rect = layout.placements[0].rect;
    let page = &pages(&layout, &total)[0];
    let cell = 4.0 / rect.width as f32;
    for i in 0..rect.height {
        for j in 0..rect.width {
            // u runs along z, v along x.
            let (px, pz) = ((i as f32 + 0.5) * cell, (j as f32 + 0.5) * cell);
            let value = page[((rect.y + i) * 128 + rect.x + j) as usize].x * PI;
            if (1.75..2.05).contains(&px) && (0.6..3.4).contains(&pz) {
                assert!(value > near * 0.5, "a fringe of {value} at {px}, {pz}: {near}");
            }
            if px > 2.3 {
                assert!(value < bright * 2e-3, "a leak of {value} at {px}, {pz}: {bright}");
            }
            // Under the box lies what is around it, not black.
            if (0.6..1.2).contains(&px) && (1.1..1.7).contains(&pz) {
                assert!(value > 0.02 * bright, "{value} under the box");
            }
        }
    }
}

trait IntoDirect {
    fn into_direct(self) -> Vec<DirectLight>;
}

impl IntoDirect for Light {
    fn into_direct(self) -> Vec<DirectLight> {
        vec![DirectLight { light: self, radius: 0.0 }]
    }
}

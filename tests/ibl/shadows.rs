//! Shadows of the environment's lights.

use bevy::{camera::ScalingMode, prelude::*};
use farlight::{
    ibl::environment_maps::{Environment, EnvironmentLight, LightRequest},
    prelude::*,
};

use crate::stage::{SIZE, Stage, save};

/// One light: a single bright pixel, 256 to 128.
fn one_light(column: usize, row: usize) -> (Environment, EnvironmentLight, ProgressiveLighting) {
    let mut pixels = vec![Vec3::ZERO; 256 * 128];
    pixels[row * 256 + column] = Vec3::splat(2000.0);
    let map = Environment::from_equirect(256, 128, pixels).unwrap();
    let settings = ProgressiveLighting { lights: 1, per_frame: 1, ..default() };
    let request = LightRequest { count: 1, method: settings.method, seed: settings.seed };
    let light = map.lights(&request)[0];
    (map, light, settings)
}

/// Refined pictures without and with shadows.
fn unshadowed_and_shadowed(stage: &mut Stage, camera: Entity) -> [Vec<Vec3>; 2] {
    [false, true].map(|shadows| {
        stage.world().resource_mut::<ProgressiveLighting>().shadows = shadows;
        stage.update();
        stage.refine(camera);
        stage.floats()
    })
}

/// The worst pixel that is lit well, and the mean difference, relative to the mean.
fn lost(pictures: &[Vec<Vec3>; 2]) -> (f32, f32) {
    let mean = pictures[0].iter().map(|pixel| pixel.y).sum::<f32>() / pictures[0].len() as f32;
    let (mut worst, mut sum) = (0.0_f32, 0.0);
    for (without, with) in pictures[0].iter().zip(&pictures[1]) {
        let difference = (without.y - with.y).abs();
        sum += difference;
        if without.y > 0.5 * mean {
            worst = worst.max(difference / without.y);
        }
    }
    (worst, sum / pictures[0].len() as f32 / mean)
}

#[test]
fn what_nothing_shadows_is_as_without_shadows() {
    let scenes: [(&str, fn(&mut Stage)); 3] = [
        ("floor", |stage| {
            let floor =
                (stage.mesh(Plane3d::default().mesh().size(8.0, 8.0)), stage.matte(Color::WHITE));
            stage.spawn(floor);
        }),
        ("ball", |stage| {
            // Fine enough that its facets don't shadow each other.
            let ball =
                (stage.mesh(Sphere::new(0.8).mesh().uv(256, 128)), stage.matte(Color::WHITE));
            stage.spawn((ball, Transform::from_xyz(0.0, 0.4, 0.0)));
        }),
        ("box", |stage| {
            let cuboid = (stage.mesh(Cuboid::from_length(1.2)), stage.matte(Color::WHITE));
            let turned = Quat::from_euler(EulerRot::YXZ, 0.6, 0.4, 0.2);
            stage.spawn((cuboid, Transform::from_xyz(0.0, 0.4, 0.0).with_rotation(turned)));
        }),
    ];
    for (name, spawn) in scenes {
        let mut stage = Stage::new();
        spawn(&mut stage);
        // The upper half of the sky, so that floors seen from below don't matter.
        let map = Environment::from_equirect(
            32,
            16,
            (0..512).map(|i| if i < 256 { Vec3::ONE } else { Vec3::ZERO }).collect(),
        );
        stage.light(map.unwrap(), ProgressiveLighting { lights: 64, ..default() });
        let camera = stage.camera(Vec3::new(0.0, 2.0, 3.0), Vec3::new(0.0, 0.3, 0.0));
        let pictures = unshadowed_and_shadowed(&mut stage, camera);
        let (worst, mean) = lost(&pictures);
        println!(
            "{name}: shadows take {:.3} % at most, {:.3} % on average",
            100.0 * worst,
            100.0 * mean
        );
        save(&pictures[1], &format!("unshadowed-{name}"));
        assert!(mean < 5e-3 && worst < 2e-2, "{name}: {worst} {mean}");
    }
}

/// A box in the world.
struct Block {
    middle: Vec3,
    half: Vec3,
}

impl Block {
    /// Whether a ray meets the box grown by `margin`.
    fn is_met(&self, from: Vec3, direction: Vec3, margin: f32) -> bool {
        let half = self.half + margin;
        let low = (self.middle - half - from) / direction;
        let high = (self.middle + half - from) / direction;
        let enter = low.min(high).max_element();
        let leave = low.max(high).min_element();
        half.min_element() > 0.0 && leave >= enter.max(0.0)
    }
}

/// Compares the shadow of `block` on a floor of `floor` metres with rays, where the answer is clear
/// within `margin` metres; the block itself isn't looked at.
fn compare_with_rays(
    name: &str,
    mut stage: Stage,
    camera: Entity,
    light: &EnvironmentLight,
    block: &Block,
    margin: f32,
    floor: f32,
) {
    let pictures = unshadowed_and_shadowed(&mut stage, camera);
    save(&pictures[1], &format!("shadow-{name}"));
    let world = stage.world();
    let transform = *world.get::<GlobalTransform>(camera).unwrap();
    let component = world.get::<Camera>(camera).unwrap();
    let (mut shadowed, mut lit) = (0, 0);
    for y in 0..SIZE {
        for x in 0..SIZE {
            let at = Vec2::new(x as f32, y as f32) + 0.5;
            let Ok(ray) = component.viewport_to_world(&transform, at) else { continue };
            let distance = -ray.origin.y / ray.direction.y;
            let place = ray.origin + distance * *ray.direction;
            let out = place.xz().abs().max_element() > 0.45 * floor;
            if distance <= 0.0 || out || block.is_met(ray.origin, *ray.direction, 0.1) {
                continue;
            }
            let inside = block.is_met(place, light.direction, -margin);
            let outside = !block.is_met(place, light.direction, margin);
            let i = (y * SIZE + x) as usize;
            let share = pictures[1][i].y / pictures[0][i].y;
            if inside {
                shadowed += 1;
                assert!(share < 0.02, "{name}: {share} in the shadow at {place}, pixel {x} {y}");
            } else if outside {
                lit += 1;
                assert!(share > 0.98, "{name}: {share} in the light at {place}, pixel {x} {y}");
            }
        }
    }
    println!("{name}: {shadowed} pixels in the shadow, {lit} in the light");
    assert!(shadowed > 20 && lit > 100, "{name}: {shadowed} {lit}");
}

fn scene(size: f32, block: &Block, map: Environment, settings: ProgressiveLighting) -> Stage {
    let mut stage = Stage::new();
    let floor = (stage.mesh(Plane3d::default().mesh().size(size, size)), stage.matte(Color::WHITE));
    stage.spawn(floor);
    let size = 2.0 * block.half;
    let cuboid = (stage.mesh(Cuboid::new(size.x, size.y, size.z)), stage.matte(Color::WHITE));
    stage.spawn((cuboid, Transform::from_translation(block.middle)));
    stage.light(map, settings);
    stage
}

#[test]
fn shadows_are_where_rays_say() {
    // From the right, 45 degrees high.
    let (map, light, settings) = one_light(192, 32);
    let block = Block { middle: Vec3::new(0.0, 0.6, 0.0), half: Vec3::new(0.4, 0.2, 0.5) };
    let mut stage = scene(8.0, &block, map.clone(), settings.clone());
    let camera = stage.camera(Vec3::new(-1.0, 3.0, 3.0), Vec3::new(-0.5, 0.0, 0.0));
    // A pixel's width on the floor, and a few texels of 8 m / 512.
    compare_with_rays("perspective", stage, camera, &light, &block, 0.15, 8.0);

    // A parallel projection from far away.
    let mut stage = scene(8.0, &block, map.clone(), settings.clone());
    let camera = stage.camera(Vec3::new(-30.0, 90.0, 90.0), Vec3::new(-0.5, 0.0, 0.0));
    let parallel = OrthographicProjection {
        scaling_mode: ScalingMode::FixedVertical { viewport_height: 4.0 },
        ..OrthographicProjection::default_3d()
    };
    stage.world().entity_mut(camera).insert(Projection::from(parallel));
    compare_with_rays("orthographic", stage, camera, &light, &block, 0.15, 8.0);

    // The block is high above what is seen.
    let high = Block { middle: Vec3::new(4.0, 4.6, 0.0), half: Vec3::splat(0.5) };
    let mut stage = scene(14.0, &high, map.clone(), settings.clone());
    let camera = stage.camera(Vec3::new(-1.0, 3.0, 3.0), Vec3::new(-0.5, 0.0, 0.0));
    compare_with_rays("from-outside", stage, camera, &light, &high, 0.2, 14.0);

    // Two kilometres of floor, of which 20 m have shadows.
    let settings = ProgressiveLighting { shadow_distance: 20.0, ..settings };
    let block = Block { middle: Vec3::new(0.0, 1.0, 0.0), half: Vec3::splat(0.7) };
    let mut stage = scene(2000.0, &block, map, settings);
    let camera = stage.camera(Vec3::new(-1.0, 3.0, 3.0), Vec3::new(-0.5, 0.0, 0.0));
    compare_with_rays("huge-floor", stage, camera, &light, &block, 0.35, 2000.0);
}

#[test]
fn shadows_end_without_a_line_and_touch_what_casts_them() {
    let mut stage = Stage::new();
    let floor =
        (stage.mesh(Plane3d::default().mesh().size(400.0, 400.0)), stage.matte(Color::WHITE));
    stage.spawn(floor);
    let ball = (stage.mesh(Sphere::new(0.5).mesh().uv(64, 32)), stage.matte(Color::WHITE));
    for i in 0..12 {
        stage.spawn((ball.clone(), Transform::from_xyz(1.0, 0.5, -2.0 * i as f32)));
    }
    let map = Environment::open(
        &crate::support::assets().join("environments/sky.hdr"),
        farlight::ibl::environment_maps::Layout::Auto,
    );
    let settings = ProgressiveLighting { brightness: 0.5, shadow_distance: 12.0, ..default() };
    stage.light(map.unwrap(), settings);
    let camera = stage.camera(Vec3::new(0.0, 1.5, 3.0), Vec3::new(0.5, 0.3, -3.0));
    let pictures = unshadowed_and_shadowed(&mut stage, camera);
    save(&pictures[1], "row-of-balls");
    // The empty floor on the left: no step from row to row of more than the light's own.
    for x in [4, 8] {
        let shares: Vec<f32> = (0..SIZE)
            .map(|y| (y * SIZE + x) as usize)
            .filter(|i| pictures[0][*i].y > 0.05)
            .map(|i| pictures[1][i].y / pictures[0][i].y)
            .collect();
        let step = shares.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
        println!("column {x}: steps of {:.2} % at most", 100.0 * step);
        assert!(step < 0.03, "column {x}: a step of {step}");
    }
}

#[test]
fn a_world_without_meshes_is_no_trouble() {
    let (map, _, settings) = one_light(192, 32);
    let mut stage = Stage::new();
    stage.light(map, settings);
    let camera = stage.camera(Vec3::new(0.0, 1.0, 3.0), Vec3::ZERO);
    stage.refine(camera);
    // Bounds and places that are no numbers.
    let mesh = (stage.mesh(Cuboid::from_length(1.0)), stage.matte(Color::WHITE));
    stage.spawn((mesh.clone(), Transform::from_scale(Vec3::ZERO)));
    stage.spawn((mesh.clone(), Transform::from_xyz(f32::NAN, 0.0, 0.0)));
    stage.spawn((mesh, Transform::from_xyz(0.0, 0.0, -1.0)));
    for _ in 0..4 {
        stage.update();
    }
    let picture = stage.floats();
    assert!(picture.iter().any(|pixel| pixel.max_element() > 0.1), "the box is lit");
    assert!(picture.iter().all(|pixel| pixel.is_finite()));
}

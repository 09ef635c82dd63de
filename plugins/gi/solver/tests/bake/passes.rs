//! Passes of gather rays.

use farlight_gi_solver::{
    Scene, World,
    bake::{Density, Gathered, Gatherer, GathererSettings, Layout, LayoutSettings},
    estimate::no_progress,
    scene::DirectSky,
};
use glam::Vec3;

use crate::{common::two_rooms, scenes::built};

fn lit_rooms() -> (Scene, Vec<farlight_gi_solver::scene::InstanceId>) {
    let mut builder = two_rooms(true);
    builder.point_light(1, Vec3::new(2.0, 2.5, 2.0), Vec3::new(100.0, 90.0, 70.0));
    built(builder)
}

fn layout(
    scene: &Scene,
    world: &World,
    receivers: &[farlight_gi_solver::scene::InstanceId],
) -> Layout {
    let settings = LayoutSettings { page_size: 64, max_pages: 1, density: Density::Fit };
    Layout::new(scene, world, receivers.iter().copied(), &settings)
}

const SETTINGS: GathererSettings =
    GathererSettings { seed: 5, bounces: 0, direct_sky: DirectSky::Included };

/// Wherever it is interrupted, and on however many threads: the same to the last bit.
#[test]
fn passes_add_up_on_any_number_of_threads() {
    let (scene, receivers) = lit_rooms();
    let world = World::new(&scene);
    let layout = layout(&scene, &world, &receivers);
    let gather = |threads: usize, passes: &[u32]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let gatherer = Gatherer::new(&world, &layout, SETTINGS, no_progress()).unwrap();
            let mut gathered = Gathered::new(&layout);
            for rays in passes {
                gatherer.pass(&mut gathered, *rays, no_progress()).unwrap();
                gathered = Gathered::from_bytes(&layout, &gathered.to_bytes()).unwrap();
            }
            gathered
        })
    };
    let whole = gather(2, &[64]);
    assert_eq!(whole.rays, 64);
    assert!(whole.halves[0] != whole.halves[1]);
    assert_eq!(gather(3, &[16, 40, 8]), whole);
    assert_eq!(gather(1, &[64]), whole);
}

#[test]
fn a_stopped_pass_adds_nothing() {
    let (scene, receivers) = lit_rooms();
    let world = World::new(&scene);
    let layout = layout(&scene, &world, &receivers);
    let stop: &(dyn Fn(u64) -> std::ops::ControlFlow<()> + Sync) =
        &|_| std::ops::ControlFlow::Break(());
    assert!(Gatherer::new(&world, &layout, SETTINGS, stop).is_none());
    let gatherer = Gatherer::new(&world, &layout, SETTINGS, no_progress()).unwrap();
    let mut gathered = Gathered::new(&layout);
    assert!(gatherer.pass(&mut gathered, 8, stop).is_none());
    assert_eq!(gathered, Gathered::new(&layout));
}

/// What the halves say about the error is what a long run says, and the error falls as it should.
#[test]
fn the_estimated_error_is_honest() {
    let (scene, receivers) = lit_rooms();
    let world = World::new(&scene);
    let layout = layout(&scene, &world, &receivers);
    let gatherer = Gatherer::new(&world, &layout, SETTINGS, no_progress()).unwrap();
    let other = GathererSettings { seed: 6, ..SETTINGS };
    let other = Gatherer::new(&world, &layout, other, no_progress()).unwrap();
    let mut truth = Gathered::new(&layout);
    other.pass(&mut truth, 4096, no_progress()).unwrap();
    let luminance = |c: Vec3| c.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    let brightest = (0..layout.len()).map(|i| luminance(truth.irradiance(i))).fold(0.0, f32::max);
    let mut before = f32::INFINITY;
    for rays in [32, 128] {
        let mut gathered = Gathered::new(&layout);
        gatherer.pass(&mut gathered, rays, no_progress()).unwrap();
        let estimated = gathered.relative_error(&layout);
        let mut errors: Vec<f32> = (0..layout.len())
            .filter(|&i| luminance(truth.irradiance(i)) > brightest * 1e-3)
            .map(|i| {
                let truth = luminance(truth.irradiance(i));
                (luminance(gathered.irradiance(i)) - truth).abs() / truth
            })
            .collect();
        errors.sort_by(f32::total_cmp);
        let found = errors[errors.len() / 2] / 0.6745;
        println!("{rays} rays: estimated {estimated:.4}, found {found:.4}");
        assert!((0.8..1.25).contains(&(estimated / found)), "{rays}: {estimated} {found}");
        assert!(found < before * 0.55, "{found} {before}");
        before = found;
    }
}

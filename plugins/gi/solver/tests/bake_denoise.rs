//! Denoising of gathered light, on a scene with a bright and a dark room.

use std::path::Path;

use farlight_gi_solver::{
    World,
    bake::{Density, Gathered, Gatherer, GathererSettings, Layout, LayoutSettings, denoise},
    estimate::no_progress,
    import::{ImportOptions, load_scene},
    scene::DirectSky,
};
use glam::Vec3;

fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

#[test]
fn two_rooms_lose_most_of_their_noise_and_no_light() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tests/data/TwoRooms.glb");
    let scene = load_scene(&path, &ImportOptions::default()).unwrap().scene;
    let world = World::new(&scene);
    let settings = LayoutSettings { page_size: 128, max_pages: 1, density: Density::Fit };
    let layout = Layout::new(&scene, &world, scene.instances.keys().copied(), &settings);
    let gather = |rays, seed| {
        let settings = GathererSettings { seed, bounces: 0, direct_sky: DirectSky::LeftOut };
        let gatherer = Gatherer::new(&world, &layout, settings, no_progress()).unwrap();
        let mut gathered = Gathered::new(&layout);
        gatherer.pass(&mut gathered, rays, no_progress()).unwrap();
        gathered
    };
    let (noisy, reference) = (gather(64, 1), gather(256, 2));
    let denoised = denoise(&layout, &noisy);

    // Squared errors without the reference's own noise, which its halves tell.
    let (mut before, mut after, mut sums) = (0.0, 0.0, [0.0; 2]);
    for (i, texel) in layout.texels().enumerate().filter(|(_, texel)| texel.open) {
        let truth = luminance(reference.irradiance(i));
        let own = luminance(reference.difference(i)).powi(2);
        let floor = truth.max(0.1);
        let error = |c: Vec3| ((luminance(c) - truth).powi(2) - own) / (floor * floor);
        before += error(noisy.irradiance(i));
        after += error(denoised[i]);
        sums[0] += luminance(noisy.irradiance(i));
        sums[1] += luminance(denoised[i]);
        assert!(denoised[i].is_finite() && denoised[i].min_element() >= 0.0, "{texel:?}");
    }
    let gain = before / after;
    println!("{} texels, equal-time gain {gain}, light {:?}", layout.len(), sums);
    assert!(after > 0.0 && gain > 3.0, "squared error {before} -> {after}");
    assert!((sums[1] / sums[0] - 1.0).abs() < 0.005, "light {sums:?}");
}

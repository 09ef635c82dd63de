//! Screenshots wait until the picture is refined.

use std::sync::{Arc, Mutex};

use bevy::{
    prelude::*,
    render::view::screenshot::{Screenshot, ScreenshotCaptured},
};
use farlight::{
    ibl::environment_maps::{Environment, Layout},
    prelude::*,
};

use crate::{stage::Stage, support};

#[test]
fn a_screenshot_waits_for_the_refined_picture_of_its_image() {
    let mut stage = Stage::new();
    stage.ball();
    let map = Environment::open(&support::assets().join("environments/sky.hdr"), Layout::Auto);
    let settings = ProgressiveLighting { brightness: 0.5, lights: 40, ..default() };
    stage.light(map.unwrap(), settings);
    let camera = stage.camera(Vec3::new(0.0, 1.5, 3.0), Vec3::new(0.0, 0.3, 0.0));
    for _ in 0..4 {
        stage.update();
    }
    let slot = Arc::new(Mutex::new(None));
    let filled = slot.clone();
    let shot = stage.spawn(RefinedScreenshot(camera));
    stage.world().entity_mut(shot).observe(move |captured: On<ScreenshotCaptured>| {
        *filled.lock().unwrap() = captured.image.data.clone();
    });
    // One of a camera that isn't there is given up.
    let nothing = stage.spawn(());
    let lost = stage.spawn(RefinedScreenshot(nothing));
    let (mut at, mut waited) = (None, 0);
    while slot.lock().unwrap().is_none() {
        stage.update();
        waited += 1;
        assert!(waited < 400, "no screenshot");
        if at.is_none() && stage.world().get::<Screenshot>(shot).is_some() {
            at = stage.world().get::<Refinement>(camera).copied();
        }
    }
    assert!(at.is_some_and(|at| at.is_refined()), "taken at {at:?}");
    assert!(stage.world().get_entity(lost).is_err());
    for _ in 0..3 {
        stage.update();
    }
    assert!(stage.world().get_entity(shot).is_err(), "it vanishes");

    // What it shows is the refined picture. A later one may see edges at other parts of pixels by
    // each of the lights.
    let pixels = slot.lock().unwrap().take().unwrap();
    let half = |bytes: &[u8]| half::f16::from_le_bytes([bytes[0], bytes[1]]).to_f32();
    let shown: Vec<Vec3> = pixels
        .chunks_exact(8)
        .map(|pixel| Vec3::new(half(pixel), half(&pixel[2..]), half(&pixel[4..])))
        .collect();
    stage.refine(camera);
    let refined = stage.floats();
    let apart = shown.iter().zip(&refined).map(|(a, b)| (*a - *b).abs().element_sum()).sum::<f32>();
    let all = refined.iter().map(|pixel| pixel.element_sum()).sum::<f32>();
    println!("{:.3} % apart", 100.0 * apart / all);
    assert!(apart < 0.01 * all, "{apart} of {all}");
}

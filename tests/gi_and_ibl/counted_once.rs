//! The feedback test: an environment that is shown by lights and solved in its bounces.

use std::f32::consts::PI;

use bevy::prelude::*;
use farlight::{gi::ExtractedScene, gi::solver::scene, prelude::*};

use crate::{stage::save, terrace::Terrace};

/// Asserts that the floor is in the picture what the path tracer says of the whole.
fn assert_floor(terrace: &mut Terrace, what: &str) {
    let rows = terrace.against_reference(0.0, Terrace::is_free);
    assert_counted_once(&rows, what);
}

fn assert_counted_once(rows: &[[f32; 3]], what: &str) {
    let mean = |of: fn(&[f32; 3]) -> f32| rows.iter().map(of).sum::<f32>() / rows.len() as f32;
    let (seen, whole, sky) = (mean(|r| r[0]), mean(|r| r[1]), mean(|r| r[2]));
    let mut errors: Vec<f32> = rows.iter().map(|r| (r[0] - r[1]).abs() / whole).collect();
    errors.sort_by(f32::total_cmp);
    let median = errors[errors.len() / 2];
    println!(
        "{what}: {} pixels, {seen:.4} seen, {whole:.4} expected ({sky:.4} of it straight from the \
         sky), median error {median:.4}",
        rows.len()
    );
    assert!(rows.len() > 30);
    // Were the sky's direct part shown twice or not at all, the mean would be off by tens of percent.
    assert!(sky > 0.4 * whole && sky < 0.95 * whole, "the scene says little");
    // 200 lights for the map, Burley's diffuse for Lambert's, lightmap texels of 20 cm, probes half a
    // metre apart.
    assert!((seen / whole - 1.0).abs() < 0.03, "{what}: {seen} instead of {whole}");
    assert!(median < 0.05, "{what}: {median}");
}

#[test]
fn the_environment_is_counted_once_and_then_nothing_is_solved_again() {
    let mut terrace = Terrace::new();
    terrace.rest();
    let direct =
        |terrace: &mut Terrace| terrace.stage.world().resource::<ExtractedScene>().scene.direct_sky;
    assert_eq!(direct(&mut terrace), scene::DirectSky::LeftOut);
    assert_floor(&mut terrace, "as it is");

    // Derived lights change in every frame that is drawn, and gi's light came while they did: nothing
    // of it comes back.
    let before = terrace.told();
    let lamps = terrace.stage.world().resource::<ExtractedScene>().scene.lights.len();
    assert_eq!(lamps, 0);
    for frame in 0..60 {
        terrace.stage.update();
        assert_eq!(terrace.told(), before, "frame {frame}");
        assert!(terrace.refinement().is_some_and(|r| r.is_refined()), "frame {frame}");
    }

    // A camera that never rests keeps the lights changing.
    let camera = terrace.camera;
    for frame in 0..60 {
        let mut transform =
            terrace.stage.world().get_mut::<Transform>(camera).expect("the camera is there");
        transform.translation.x = 1e-3 * (frame as f32).sin();
        terrace.stage.update();
        assert_eq!(terrace.told(), before, "frame {frame}");
    }
    terrace.stage.world().get_mut::<Transform>(camera).unwrap().translation.x = 0.0;

    // Turned: the lights at once, the bounces a little later. While new light arrives pictures start
    // anew, and only then.
    let turn = Quat::from_rotation_y(2.0) * Quat::from_rotation_x(0.3);
    terrace.stage.world().resource_mut::<ProgressiveLighting>().rotation = turn;
    terrace.stage.update();
    let (mut frames, mut relit, mut restarts, mut quiet) = (0, 0, 0, 0);
    for frame in 0..4000 {
        terrace.stage.update();
        quiet = if terrace.relit() { 0 } else { quiet + 1 };
        relit += u32::from(quiet == 0);
        let now = terrace.refinement().map_or(0, |r| r.frames);
        if now < frames {
            restarts += 1;
            // A message is seen in its frame or in the next one.
            assert!(quiet <= 2, "frame {frame}: a new start without new light");
        }
        assert!(quiet > 0 || now <= 2, "frame {frame}: new light, and {now} frames of a mean");
        frames = now;
        let (state, ..) = terrace.told();
        if state == GiState::Converged && quiet > 60 {
            break;
        }
    }
    println!("turned: {relit} frames of new light, {restarts} new starts");
    assert!(relit > 0);
    assert!(terrace.told().1 > before.1, "the sky turned");
    terrace.rest();
    assert_floor(&mut terrace, "turned");
}

/// What isn't solved for gets the bounces from probes, which leave out what lights show.
#[test]
fn a_thing_that_moves_is_lit_once_too() {
    let mut terrace = Terrace::new();
    let (height, is_seen) = terrace.add_board();
    terrace.rest();
    save(&terrace.stage.floats(), "terrace");
    let rows = terrace.against_reference(height, is_seen);
    assert_counted_once(&rows, "a board in the air");
}

#[test]
fn without_lights_that_show_it_the_sky_is_solved_as_a_whole() {
    let mut terrace = Terrace::new();
    terrace.rest();
    let floor = |terrace: &mut Terrace| {
        let entity = terrace.floor;
        let lightmaps = terrace.stage.world().resource::<GiLightmaps>();
        let placement = *lightmaps.placement(entity).expect("the floor has a lightmap");
        let rect = placement.rect;
        let texels = (rect.y..rect.y + rect.height)
            .flat_map(|y| (rect.x..rect.x + rect.width).map(move |x| (x, y)));
        texels.map(|(x, y)| lightmaps.texel(placement.page, x, y).unwrap()).sum::<Vec3>() * PI
    };
    let solve = |terrace: &mut Terrace| {
        // Claimed in one frame, submitted in it, and solved some frames later.
        terrace.stage.update();
        terrace.stage.update();
        let solved = terrace.stage.headless.update_until(
            "light",
            std::time::Duration::from_secs(60),
            |world| {
                let status = world.resource::<GiStatus>();
                status.state == GiState::Converged && status.shown == status.submitted
            },
        );
        solved.unwrap_or_else(|problem| panic!("{problem}"));
    };
    let bounces = floor(&mut terrace);
    let owner = |terrace: &mut Terrace| {
        terrace.stage.world().resource::<SkySource>().owner().map(str::to_owned)
    };
    assert_eq!(owner(&mut terrace).as_deref(), Some("farlight_ibl"));

    // Nobody looks: no lights.
    let camera = terrace.camera;
    terrace.stage.world().get_mut::<Camera>(camera).unwrap().is_active = false;
    solve(&mut terrace);
    let whole = floor(&mut terrace);
    assert!(whole.min_element() > 1.5 * bounces.max_element(), "{whole} after {bounces}");

    // Switched off, the environment lights nothing.
    terrace.stage.world().resource_mut::<ProgressiveLighting>().enabled = false;
    solve(&mut terrace);
    assert_eq!(floor(&mut terrace), Vec3::ZERO);
    assert_eq!(owner(&mut terrace), None);

    // And all is as it was.
    terrace.stage.world().resource_mut::<ProgressiveLighting>().enabled = true;
    terrace.stage.world().get_mut::<Camera>(camera).unwrap().is_active = true;
    terrace.rest();
    let again = floor(&mut terrace);
    assert!((again / bounces - 1.0).abs().max_element() < 0.02, "{again} instead of {bounces}");
}

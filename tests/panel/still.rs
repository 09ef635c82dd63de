//! Panels don't disturb what the suite solves and refines.

use bevy::prelude::*;
use farlight::{panel::PanelSettings, prelude::*};

use crate::stage::Stage;

#[test]
fn a_refined_picture_and_solved_light_stay() {
    let settings = PanelSettings { place: PanelPlace::World, hint: false, ..default() };
    let mut stage = Stage::new(UVec2::new(320, 320), settings);
    let camera = stage.camera;
    stage.world().entity_mut(camera).insert(ProgressiveCamera::default());
    stage.world().spawn((GiScene, Transform::default(), Visibility::default()));
    let refined = |stage: &mut Stage| {
        stage.world().get::<Refinement>(camera).is_some_and(|refinement| refinement.is_refined())
    };
    let mut waited = 0;
    while !refined(&mut stage) {
        stage.frames(1);
        waited += 1;
        assert!(waited < 300, "the picture is not refined");
    }
    // The first screenshot and the first panel need pipelines that what is refined has nothing of.
    let before = stage.picture("still_closed.png");
    assert!(refined(&mut stage), "a screenshot is taken");
    let submitted = stage.world().resource::<GiStatus>().submitted;
    for open in [true, false] {
        stage.world().resource_mut::<PanelState>().menu = open;
        for _ in 0..10 {
            stage.frames(1);
            assert!(refined(&mut stage), "open: {open}");
        }
        if open {
            assert_ne!(stage.picture("still_open.png"), before);
        }
    }
    assert_eq!(stage.picture("still_again.png"), before);
    assert_eq!(stage.world().resource::<GiStatus>().submitted, submitted);
}

//! Panels in the world.

use bevy::{
    camera::{Exposure, Hdr},
    core_pipeline::tonemapping::Tonemapping,
    prelude::*,
};
use farlight::{
    controls::InputCapture,
    panel::{PanelSettings, WorldPanel, egui},
    prelude::*,
};

use crate::stage::Stage;

const SIZE: UVec2 = UVec2::new(800, 800);

fn open() -> Stage {
    let settings = PanelSettings { place: PanelPlace::World, hint: false, ..default() };
    let mut stage = Stage::new(SIZE, settings);
    stage.world().resource_mut::<PanelState>().menu = true;
    stage.frames(12);
    stage
}

#[test]
fn it_is_drawn_with_what_points_at_it() {
    let mut stage = open();
    let at = stage.switch(false).center();
    let to = stage.world().resource::<WorldPanel>().world_from_point(Vec2::new(at.x, at.y));
    let from = Transform::from_xyz(0.2, -0.3, 0.1).looking_at(to, Vec3::Y);
    stage.world().spawn((PanelRay::default(), from));
    stage.world().write_message(Notification::new("Lights a frame: 6"));
    stage.frames(6);
    let menu = stage.picture("world_menu.png");
    assert_eq!(menu.problem(), None);
    stage.world().resource_mut::<PanelState>().menu = false;
    stage.world().resource_mut::<PanelState>().help = true;
    stage.frames(6);
    stage.picture("world_help.png");
}

/// Presses with a ray through a point of the panel and says whether the lamp was switched.
fn switches(stage: &mut Stage, ray: Entity, to: Vec3) -> bool {
    let before = stage.lamp().on;
    let from = Transform::from_xyz(0.25, -0.4, 0.1).looking_at(to, Vec3::Y);
    stage.world().entity_mut(ray).insert(from);
    stage.frames(2);
    for pressed in [true, false] {
        stage.world().get_mut::<PanelRay>(ray).unwrap().pressed = pressed;
        stage.frames(2);
    }
    stage.lamp().on != before
}

#[test]
fn a_ray_presses_what_it_meets_and_nothing_beside() {
    let mut stage = open();
    let switch = stage.switch(false);
    let ray =
        stage.world().spawn(PanelRay { hand: Some(farlight_bindings::Hand::Right), ..default() });
    let ray = ray.id();
    let panel = stage.world().resource::<WorldPanel>();
    let to = |point: egui::Pos2| panel.world_from_point(Vec2::new(point.x, point.y));
    let (centre, edge) = (to(switch.center()), to(switch.left_center()));
    let towards = (edge - centre).normalize();
    assert!(switches(&mut stage, ray, centre));
    let hit = stage.world().get::<PanelRay>(ray).unwrap().hit;
    let far = centre.distance(Vec3::new(0.25, -0.4, 0.1));
    assert!(hit.is_some_and(|hit| (hit - far).abs() < 1e-3), "{hit:?} of {far} m");
    assert_eq!(stage.world().resource::<InputCapture>().hands, [false, true]);
    assert!(!switches(&mut stage, ray, edge + towards * 0.01), "1 cm beside it");
    // A press that comes from elsewhere.
    let before = stage.lamp().on;
    stage.world().entity_mut(ray).insert(Transform::from_xyz(0.0, 5.0, 0.0));
    stage.frames(2);
    stage.world().get_mut::<PanelRay>(ray).unwrap().pressed = true;
    stage.frames(1);
    assert_eq!(stage.world().get::<PanelRay>(ray).unwrap().hit, None);
    let over = Transform::from_xyz(0.25, -0.4, 0.1).looking_at(centre, Vec3::Y);
    stage.world().entity_mut(ray).insert(over);
    stage.frames(2);
    stage.world().get_mut::<PanelRay>(ray).unwrap().pressed = false;
    stage.frames(2);
    assert_eq!(stage.lamp().on, before);
}

#[test]
fn the_gaze_presses_after_a_while() {
    let mut stage = open();
    stage.world().resource_mut::<PanelSettings>().gaze_dwell = 0.5;
    let switch = stage.switch(false).center();
    let panel = stage.world().resource::<WorldPanel>();
    let to = panel.world_from_point(Vec2::new(switch.x, switch.y));
    let camera = stage.camera;
    // Less far than what would have it come after.
    stage.world().entity_mut(camera).insert(Transform::default().looking_at(to, Vec3::Y));
    let before = stage.lamp().on;
    stage.frames(15);
    stage.picture("world_gaze.png");
    assert_eq!(stage.lamp().on, before, "after 0.3 s");
    stage.frames(30);
    assert_ne!(stage.lamp().on, before, "after 0.9 s");
    stage.frames(60);
    assert_ne!(stage.lamp().on, before, "once");
}

#[test]
fn it_is_as_bright_at_any_exposure() {
    let mut stage = open();
    let camera = stage.camera;
    let mut pictures = Vec::new();
    let ways = [None, Some(0.0), Some(10.0), Some(15.0)];
    for ev100 in ways {
        if let Some(ev100) = ev100 {
            let world = stage.world();
            world.entity_mut(camera).insert((Hdr, Exposure { ev100 }, Tonemapping::AcesFitted));
            world.spawn((
                DirectionalLight { illuminance: 50_000.0, ..default() },
                Transform::IDENTITY,
            ));
        }
        stage.frames(12);
        let name = ev100.map_or("plain".into(), |ev| format!("ev{ev}"));
        pictures.push(stage.picture(&format!("world_{name}.png")));
    }
    // Inside the panel, whose background lets a twentieth of the scene's through.
    let [plain, rest @ ..] = &pictures[..] else { unreachable!() };
    for (picture, ev) in rest.iter().zip(&ways[1..]) {
        let mut worst = 0;
        for y in 200..600 {
            for x in 300..500 {
                let at = (y * SIZE.x + x) as usize;
                for (a, b) in picture.pixels[at].iter().zip(&plain.pixels[at]) {
                    worst = worst.max(a.abs_diff(*b));
                }
            }
        }
        // Steps of half floats, and the scene behind it under another tone curve.
        assert!(worst <= 6, "EV {ev:?}: {worst} of 255");
    }
}

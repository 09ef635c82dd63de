//! Panels on the screen.

use bevy::prelude::*;
use farlight::{
    controls::InputCapture,
    panel::{PanelSettings, egui},
    prelude::*,
};

use crate::stage::Stage;

#[test]
fn menu_help_and_notifications_are_drawn() {
    let mut stage = Stage::new(UVec2::new(960, 600), PanelSettings::default());
    let hint = stage.picture("hint.png");
    stage.tap(KeyCode::KeyM);
    assert!(stage.world().resource::<PanelState>().menu);
    stage.world().write_message(Notification::new("Lights a frame: 6"));
    stage.world().write_message(Notification::problem("sky.hdr can't be read"));
    stage.frames(12);
    let menu = stage.picture("menu.png");
    stage.tap(KeyCode::Escape);
    assert!(!stage.world().resource::<PanelState>().menu, "Esc closes");
    stage.tap(KeyCode::F1);
    stage.frames(12);
    let help = stage.picture("help.png");
    // Dark panels on a light background, by their area.
    assert!(menu.mean() < 0.8 * hint.mean() && help.mean() < 0.6 * hint.mean());
    stage.tap(KeyCode::F1);
    stage.frames(600);
    let nothing = stage.picture("nothing.png");
    assert_eq!(nothing.problem(), Some("one colour all over"), "hint and lines have gone");
}

#[test]
fn the_mouse_presses_what_it_is_on() {
    let mut stage = Stage::new(UVec2::new(960, 600), PanelSettings::default());
    stage.world().resource_mut::<PanelState>().menu = true;
    stage.frames(3);
    let switch = stage.switch(true);
    let beside = switch.left_center() - egui::vec2(12.0, 0.0);
    for (at, changes) in [(switch.center(), true), (beside, false)] {
        let before = stage.lamp();
        stage.mouse(egui::Event::PointerMoved(at));
        stage.frames(1);
        assert!(stage.world().resource::<InputCapture>().pointer, "the panel has the pointer");
        stage.click(at);
        assert_eq!(stage.lamp().on != before.on, changes, "{at:?}");
    }
    stage.mouse(egui::Event::PointerMoved(egui::pos2(100.0, 100.0)));
    stage.frames(1);
    assert!(!stage.world().resource::<InputCapture>().pointer, "the scene has it");
}

#[derive(Resource, Default)]
struct Changes(u32);

#[test]
fn drawing_changes_nothing() {
    let mut stage = Stage::new(UVec2::new(960, 600), PanelSettings::default());
    let count = |lamp: Res<crate::stage::Lamp>, mut changes: ResMut<Changes>| {
        changes.0 += u32::from(lamp.is_changed());
    };
    stage.world().init_resource::<Changes>();
    stage.headless.app.add_systems(Update, count);
    stage.frames(2);
    stage.world().resource_mut::<Changes>().0 = 0;
    stage.world().resource_mut::<PanelState>().menu = true;
    stage.frames(10);
    assert_eq!(stage.world().resource::<Changes>().0, 0);
}

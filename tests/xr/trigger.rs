//! While a panel is open, what presses its buttons is silent for the game.

use bevy::{ecs::system::RunSystemOnce, prelude::*};
use farlight::{
    controls::{ActionPerformed, UserFile, XrControllers},
    panel::{PanelSettings, WorldPanel, bevy_egui::EguiContext},
    prelude::*,
    xr::{XrHandPose, XrHandTracking, XrHead, XrTracking},
};
use farlight_bindings::{Device, Hand, Profile, Xr};

use crate::stage::Stage;

/// What the panel shows.
#[derive(Resource, Reflect, Default)]
#[reflect(Resource, Default)]
struct Door {
    open: bool,
}

/// Where both hands are.
const HAND: Vec3 = Vec3::new(0.1, -0.3, 0.0);

/// Somebody with controllers.
struct Somebody {
    stage: Stage,
    performed: Vec<&'static str>,
    orbited: Vec2,
}

impl Somebody {
    fn new(profile: Profile) -> Self {
        let mut stage = Stage::with(|app| {
            let user_file = UserFile::Nowhere;
            let controls = ControlsPlugin { gamepads: false, user_file, ..default() };
            app.add_plugins(FarlightPlugins.set(controls))
                .init_resource::<Door>()
                .add_panel_resource::<Door>("Door");
        });
        let world = stage.world();
        world.resource_mut::<PanelSettings>().hint = false;
        world.spawn(XrHead);
        for hand in Hand::ALL {
            world.spawn(XrHandPose { hand, aim: true });
            world.resource_mut::<XrControllers>().hand_mut(hand).profile = Some(profile);
        }
        let mut somebody = Self { stage, performed: Vec::new(), orbited: Vec2::ZERO };
        somebody.aim_at(Vec3::new(0.0, 5.0, 0.0));
        somebody.frames(4);
        somebody
    }

    fn frames(&mut self, count: u32) {
        for _ in 0..count {
            let mut performed = self.stage.world().resource_mut::<Messages<ActionPerformed>>();
            performed.clear();
            self.stage.update();
            let world = self.stage.world();
            let mut performed = world.resource_mut::<Messages<ActionPerformed>>();
            self.performed.extend(performed.drain().map(|performed| performed.action.name));
            let orbited = |controls: Controls| controls.axis2::<actions::Orbit>();
            self.orbited += world.run_system_once(orbited).unwrap();
        }
    }

    /// Both hands point somewhere.
    fn aim_at(&mut self, to: Vec3) {
        let pose = Transform::from_translation(HAND).looking_at(to, Vec3::Y);
        let aim = Some(Isometry3d::new(pose.translation, pose.rotation));
        for hand in Hand::ALL {
            let mut tracking = self.stage.world().resource_mut::<XrTracking>();
            *tracking.hand_mut(hand) = XrHandTracking { grip: aim, aim };
        }
        self.frames(2);
    }

    fn press(&mut self, hand: Hand, input: Xr, down: bool) {
        let value = Vec2::new(f32::from(u8::from(down)), 0.0);
        let mut controllers = self.stage.world().resource_mut::<XrControllers>();
        controllers.hand_mut(hand).values.insert(input, value);
        self.frames(2);
    }

    fn menu(&mut self, open: bool) {
        self.stage.world().resource_mut::<PanelState>().menu = open;
        self.frames(6);
    }

    fn door(&mut self) -> bool {
        self.stage.world().resource::<Door>().open
    }

    /// Where the door's switch is in the world.
    fn switch(&mut self) -> Vec3 {
        let world = self.stage.world();
        let mut contexts = world.query_filtered::<&mut EguiContext, Without<Camera3d>>();
        let ctx = contexts.single_mut(world).unwrap().get_mut().clone();
        let rects = ctx.interactive_rects_last_pass();
        let mut rects: Vec<_> = rects
            .iter()
            .filter(|rect| (rect.width() - 36.0).abs() < 1.0 && (rect.height() - 24.0).abs() < 1.0)
            .collect();
        rects.sort_by(|a, b| a.top().total_cmp(&b.top()));
        let at = rects[0].center();
        world.resource::<WorldPanel>().world_from_point(Vec2::new(at.x, at.y))
    }
}

#[test]
fn a_trigger_presses_the_panel_and_nothing_of_the_game() {
    let profile = Profile::Index;
    let mut somebody = Somebody::new(profile);
    let world = somebody.stage.world();
    let mut in_force = world.resource_mut::<ControlsInForce>();
    in_force.bindings.set("reset", Device::Xr(profile), vec!["Right.Trigger".parse().unwrap()]);
    somebody.frames(2);
    let resets = |somebody: &mut Somebody| {
        let count = somebody.performed.iter().filter(|name| **name == "reset").count();
        somebody.performed.clear();
        count
    };
    let press = |somebody: &mut Somebody| {
        for down in [true, false] {
            somebody.press(Hand::Right, Xr::Trigger, down);
        }
    };
    press(&mut somebody);
    assert_eq!(resets(&mut somebody), 1, "no panel is open");

    somebody.menu(true);
    let switch = somebody.switch();
    somebody.aim_at(switch);
    press(&mut somebody);
    assert!(somebody.door(), "the switch was pressed");
    assert_eq!(resets(&mut somebody), 0, "the panel has it");
    somebody.aim_at(Vec3::new(0.0, 5.0, 0.0));
    press(&mut somebody);
    assert!(somebody.door(), "nothing is there");
    assert_eq!(resets(&mut somebody), 0, "beside the panel, too");

    // What is held when it closes stays silent until it is let go.
    somebody.press(Hand::Right, Xr::Trigger, true);
    somebody.menu(false);
    assert_eq!(resets(&mut somebody), 0);
    somebody.press(Hand::Right, Xr::Trigger, false);
    assert_eq!(resets(&mut somebody), 0);
    press(&mut somebody);
    assert_eq!(resets(&mut somebody), 1, "it is heard again");
}

#[test]
fn a_hand_that_swings_with_the_button_turns_nothing_meanwhile() {
    let mut somebody = Somebody::new(Profile::Simple);
    let swing = |somebody: &mut Somebody, from: Vec3| {
        somebody.aim_at(from);
        somebody.orbited = Vec2::ZERO;
        somebody.press(Hand::Left, Xr::Select, true);
        for step in 1..=5 {
            somebody.aim_at(from + Vec3::X * 0.02 * step as f32);
        }
        somebody.press(Hand::Left, Xr::Select, false);
        somebody.orbited.length()
    };
    assert!(swing(&mut somebody, Vec3::NEG_Z) > 2.0, "{}", somebody.orbited);
    somebody.menu(true);
    let switch = somebody.switch();
    assert_eq!(swing(&mut somebody, switch), 0.0, "on the panel");
    assert_eq!(swing(&mut somebody, Vec3::new(0.0, 5.0, -1.0)), 0.0, "beside it");
    somebody.menu(false);
    assert!(swing(&mut somebody, Vec3::NEG_Z) > 2.0, "{}", somebody.orbited);
}

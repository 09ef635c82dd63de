//! What somebody does in the gallery: teleports, presses a switch in the panel, carries the lantern.

use bevy::prelude::*;
use farlight::{
    controls::bindings::{Hand, Xr},
    prelude::*,
    xr::{DesktopCamera, XrHead, XrRig},
};

use super::{Tour, VIEWS, WINDOW_ROOM, headset::HEAD};
use crate::{
    lamp::{HOME, Lamp},
    moving::Aiming,
    settings::Gallery,
};

impl Tour<'_> {
    /// Aims into the hall with the left hand, lets go, and stands there.
    pub(super) fn teleport(&mut self) -> Result<(), String> {
        let start = Vec3::new(1.6, 0.0, 2.6);
        self.world().resource_mut::<XrRig>().0 = Transform::from_translation(start);
        self.point(Hand::Left, Vec3::new(-0.2, 1.2, -0.3), Vec3::new(0.12, 0.12, -1.0));
        self.look(Vec3::new(3.3, 1.7, 3.1), Vec3::new(0.9, 0.6, -0.6))?;
        self.press(Hand::Left, Xr::Stick, Vec2::Y);
        self.frames(3)?;
        self.picture("teleport")?;
        let aimed = self.world().resource::<Aiming>().0.as_ref().and_then(|arc| arc.landing);
        self.press(Hand::Left, Xr::Stick, Vec2::ZERO);
        self.frames(3)?;
        let world = self.world();
        let mut heads = world.query_filtered::<&GlobalTransform, With<XrHead>>();
        let head = heads.iter(world).next().map(GlobalTransform::translation);
        match (aimed, head) {
            (Some(marker), Some(head)) => println!(
                "teleport: {:.2} m far, {:.4} m from the marker",
                head.xz().distance(start.xz()),
                head.xz().distance(marker.xz())
            ),
            _ => println!("teleport: aimed at nothing"),
        }
        self.hide_hands();
        Ok(())
    }

    /// The panel in the world, and a hand whose ray looks for the lantern's switch and presses it.
    pub(super) fn panel(&mut self) -> Result<(), String> {
        let feet = Vec3::new(0.9, 0.0, 2.6);
        self.world().resource_mut::<XrRig>().0 = Transform::from_translation(feet);
        self.world().resource_mut::<PanelState>().menu = true;
        let hand = Vec3::new(0.24, HEAD - 0.42, -0.28);
        let ahead = Vec3::new(0.0, HEAD - 0.15, -1.2);
        self.point(Hand::Right, hand, ahead - hand);
        self.look(
            feet + Vec3::new(-0.28, HEAD + 0.08, 0.12),
            feet + Vec3::new(0.1, HEAD - 0.2, -1.2),
        )?;
        self.frames(30)?;
        self.activate_desktop(false);
        let found = self.press_switch(hand)?;
        self.activate_desktop(true);
        match found {
            Some(target) => println!("panel: pressed the lantern's switch at {target:.2}"),
            None => println!("panel: nothing was pressed"),
        }
        self.frames(6)?;
        self.picture("panel")?;
        self.world().resource_mut::<PanelState>().menu = false;
        self.world().resource_mut::<Gallery>().lamp = true;
        self.hide_hands();
        self.frames(3)
    }

    /// Moves the right hand's ray over the panel, line by line from the right, and presses until the
    /// lantern goes out. Says where that was.
    pub(super) fn press_switch(&mut self, hand: Vec3) -> Result<Option<Vec3>, String> {
        for row in 0..24 {
            for column in 0..22 {
                let target =
                    Vec3::new(0.42 - 0.04 * column as f32, HEAD + 0.40 - 0.03 * row as f32, -1.25);
                self.point(Hand::Right, hand, target - hand);
                self.frames(1)?;
                if !self.meets_panel() {
                    continue;
                }
                for pressed in [1.0, 0.0] {
                    self.press(Hand::Right, Xr::Trigger, Vec2::new(pressed, 0.0));
                    self.frames(2)?;
                }
                if !self.world().resource::<Gallery>().lamp {
                    return Ok(Some(target));
                }
                if !self.world().resource::<PanelState>().menu {
                    // That was the cross.
                    self.world().resource_mut::<PanelState>().menu = true;
                    self.frames(4)?;
                }
            }
        }
        Ok(None)
    }

    pub(super) fn meets_panel(&mut self) -> bool {
        let world = self.world();
        let mut rays = world.query::<&PanelRay>();
        rays.iter(world).any(|ray| ray.hand == Some(Hand::Right) && ray.hit.is_some())
    }

    /// Whether the camera of the desktop draws.
    pub(super) fn activate_desktop(&mut self, draws: bool) {
        let world = self.world();
        let mut cameras = world.query_filtered::<&mut Camera, With<DesktopCamera>>();
        for mut camera in cameras.iter_mut(world) {
            camera.is_active = draws;
        }
    }

    /// The right hand takes the lantern into another room, and its light follows.
    pub(super) fn carry_lamp(&mut self) -> Result<(), String> {
        let from_feet = Vec3::new(0.0, HOME.y, -0.5);
        let there = Vec3::new(-6.0, HOME.y, 0.3);
        self.point(Hand::Right, from_feet, Vec3::NEG_Z);
        self.world().resource_mut::<XrRig>().0 = Transform::from_translation(HOME - from_feet);
        self.frames(2)?;
        self.press(Hand::Right, Xr::Squeeze, Vec2::X);
        self.frames(3)?;
        self.world().resource_mut::<XrRig>().0 = Transform::from_translation(there - from_feet);
        self.frames(3)?;
        self.press(Hand::Right, Xr::Squeeze, Vec2::ZERO);
        self.frames(2)?;
        self.hide_hands();
        let world = self.world();
        let mut lamps = world.query_filtered::<&GlobalTransform, With<Lamp>>();
        if let Some(lamp) = lamps.iter(world).next().map(GlobalTransform::translation) {
            println!(
                "lantern: carried {:.2} m, {:.4} m from the hand",
                lamp.distance(HOME),
                lamp.distance(there)
            );
        }
        self.converge()?;
        let (_, eyes, at) = VIEWS[WINDOW_ROOM];
        self.look(eyes, at)?;
        self.picture("lantern_by_the_window")?;
        Ok(())
    }
}

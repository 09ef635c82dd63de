//! A headset's hands point at panels, its head is followed by them, its eyes see them.

use bevy::prelude::*;
use farlight_controls::{
    XrControllers,
    bindings::{Hand, Xr},
};
use farlight_panel::{PanelEye, PanelRay, PanelState, PanelSystems, PanelViewer};
use farlight_xr::{XrEye, XrHandPose, XrHead, XrRay, XrSystems};

/// How far a ray is drawn that meets nothing, in metres.
const LENGTH: f32 = 1.5;
/// How far a trigger must be pressed, as for the buttons of actions.
const PRESSED: f32 = 0.5;

/// Joins headset and panels.
pub(crate) struct PanelHands;

impl Plugin for PanelHands {
    fn build(&self, app: &mut App) {
        app.add_observer(|head: On<Add, XrHead>, mut commands: Commands| {
            commands.entity(head.entity).insert(PanelViewer);
        })
        .add_observer(|eye: On<Add, XrEye>, mut commands: Commands| {
            commands.entity(eye.entity).insert(PanelEye);
        })
        .add_observer(give_ray)
        .add_systems(
            PreUpdate,
            press
                .run_if(resource_exists::<XrControllers>.and_then(resource_exists::<PanelState>))
                .after(XrSystems::Read)
                .before(PanelSystems::Point),
        )
        .add_systems(Update, draw.run_if(resource_exists::<PanelState>));
    }
}

/// Every hand that points has a ray.
fn give_ray(added: On<Add, XrHandPose>, poses: Query<&XrHandPose>, mut commands: Commands) {
    if let Ok(XrHandPose { hand, aim: true }) = poses.get(added.entity) {
        commands.entity(added.entity).insert(PanelRay { hand: Some(*hand), ..default() });
    }
}

/// Triggers press, or what a controller has instead. Rays of others know by themselves.
fn press(controllers: Res<XrControllers>, mut rays: Query<&mut PanelRay, With<XrHandPose>>) {
    let presses = |hand: Hand| {
        let inputs = [Xr::Trigger, Xr::Select, Xr::Pinch];
        inputs.into_iter().any(|input| controllers.value(hand, input).x > PRESSED)
    };
    for mut ray in &mut rays {
        let Some(pressed) = ray.hand.map(presses) else { continue };
        if ray.pressed != pressed {
            ray.pressed = pressed;
        }
    }
}

/// Rays are drawn up to the panel.
fn draw(rays: Query<&PanelRay>, mut drawn: Query<&mut XrRay>) {
    for mut drawn in &mut drawn {
        let Some(ray) = rays.iter().find(|ray| ray.hand == Some(drawn.hand)) else { continue };
        let length = ray.hit.unwrap_or(LENGTH);
        if drawn.length != length {
            drawn.length = length;
        }
    }
}

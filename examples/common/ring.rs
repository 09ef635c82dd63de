//! A ring that shows how far the picture is.

use std::f32::consts::TAU;

use bevy::{
    prelude::*,
    ui::{AngularColorStop, BorderGradient, ConicGradient, UiPosition},
};
use farlight::prelude::*;

/// The ring, and what it showed last.
#[derive(Component)]
pub struct Ring(f32);

/// Makes it.
pub fn spawn(mut commands: Commands) {
    commands.spawn((
        Ring(-1.0),
        Node {
            position_type: PositionType::Absolute,
            top: px(14),
            right: px(14),
            width: px(40),
            height: px(40),
            border: UiRect::all(px(6)),
            border_radius: BorderRadius::MAX,
            ..default()
        },
        BackgroundColor(Color::srgba(0.0, 0.0, 0.0, 0.35)),
    ));
}

/// Fills it clockwise; whole, it is green.
pub fn show(
    mut commands: Commands,
    cameras: Query<&Refinement>,
    mut rings: Query<(Entity, &mut Ring)>,
) {
    let progress = cameras.iter().map(Refinement::progress).fold(1.0_f32, f32::min);
    for (entity, mut ring) in &mut rings {
        if ring.0 == progress {
            continue;
        }
        ring.0 = progress;
        let done =
            if progress < 1.0 { Color::srgb(1.0, 0.72, 0.3) } else { Color::srgb(0.45, 0.85, 0.5) };
        let rest = Color::srgba(0.0, 0.0, 0.0, 0.45);
        let edge = progress * TAU;
        let stops = vec![
            AngularColorStop::new(done, 0.0),
            AngularColorStop::new(done, edge),
            AngularColorStop::new(rest, edge),
            AngularColorStop::new(rest, TAU),
        ];
        let gradient = ConicGradient::new(UiPosition::CENTER, stops);
        commands.entity(entity).insert(BorderGradient::from(gradient));
    }
}

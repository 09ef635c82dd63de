//! A line at the upper edge: what is shown, and in red, what is wrong.

use bevy::prelude::*;
use farlight::{ibl::EnvironmentState, prelude::*};

use super::{
    material::{self, Materials},
    ring::Ring,
    shown::Shown,
    state::{Config, Problems},
};

/// The text about what is shown.
#[derive(Component)]
pub struct Line;

/// The text about what is wrong.
#[derive(Component)]
pub struct Wrong;

/// Makes both.
pub fn spawn(mut commands: Commands) {
    let place = Node {
        position_type: PositionType::Absolute,
        top: px(12),
        left: px(14),
        right: px(14),
        flex_direction: FlexDirection::Column,
        row_gap: px(4),
        ..default()
    };
    let font = |size: f32| TextFont { font_size: FontSize::Px(size), ..default() };
    let shadow = TextShadow { offset: Vec2::splat(1.0), color: Color::srgba(0.0, 0.0, 0.0, 0.8) };
    commands.spawn(place).with_children(|column| {
        let red = TextColor(Color::srgb(1.0, 0.5, 0.45));
        column.spawn((Wrong, Text::default(), font(15.0), red, shadow));
        let grey = TextColor(Color::srgba(0.95, 0.95, 0.93, 0.85));
        column.spawn((Line, Text::default(), font(13.0), grey, shadow));
    });
}

/// The ring would lie on the menu.
pub fn make_room(panel: Res<PanelState>, mut rings: Query<&mut Visibility, With<Ring>>) {
    let seen = if panel.menu { Visibility::Hidden } else { Visibility::Inherited };
    for mut visibility in &mut rings {
        visibility.set_if_neq(seen);
    }
}

/// Writes them.
pub fn show(
    config: Res<Config>,
    shown: Res<Shown>,
    materials: Res<Materials>,
    status: Res<EnvironmentStatus>,
    cameras: Query<&Refinement>,
    problems: Res<Problems>,
    mut lines: Query<&mut Text, (With<Line>, Without<Wrong>)>,
    mut wrongs: Query<&mut Text, With<Wrong>>,
) {
    let config = &config.0;
    let object = config.models.get(shown.object.choice);
    let material = config.materials.get(shown.material.choice);
    let environment = shown.light.environment.and_then(|i| config.environments.get(i));
    let mut parts = vec![
        object.map_or("nothing", |object| &object.name).to_owned(),
        material.map_or("no material".into(), |chosen| match materials.about(chosen) {
            Some(about) => {
                let [width, height] = about.texels;
                let size = material::size(chosen, about) * shown.material.size * 1e3;
                let name = &chosen.name;
                format!("{name} {width} x {height} on {:.0} x {:.0} mm", size.x, size.y)
            }
            None if materials.busy() => format!("{} (reading ...)", chosen.name),
            None => format!("{} (not there)", chosen.name),
        }),
        environment.map_or("no environment", |environment| &environment.name).to_owned(),
    ];
    if let EnvironmentState::Loading | EnvironmentState::Choosing = status.state {
        parts.push("reading ...".into());
    } else if let Some(refinement) = cameras.iter().next() {
        parts.push(if refinement.is_refined() {
            format!("{} lights, refined", status.lights)
        } else {
            format!("{} lights, {} of {} frames", status.lights, refinement.frames, refinement.of)
        });
    }
    let line = parts.join(", ");
    let wrong = problems.all().collect::<Vec<_>>().join("\n");
    for mut text in &mut lines {
        text.set_if_neq(Text::new(line.clone()));
    }
    for mut text in &mut wrongs {
        text.set_if_neq(Text::new(wrong.clone()));
    }
}

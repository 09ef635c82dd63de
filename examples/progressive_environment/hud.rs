//! The text on screen.

use bevy::prelude::*;
use farlight::{ibl::EnvironmentState, prelude::*};

use super::{
    panel::{self, State},
    shown::Shown,
};

const KEYS: &str = "\
E  M          next environment, method of choosing lights
N  K          more lights in all, a frame
with Shift    the one before, fewer
P             environment's lights on / off
A             accumulate on / off
I             image-based light where they are off
S             shadows
,  .          turn the environment
W             sway, as a head does
D  F          lights on the sky, on the flat map
+  -          brighter, darker
drag, arrows, wheel   look around
C             screenshot as soon as it is refined
R  H          as at the start, hide this
";

/// Makes the panel.
pub fn spawn(mut commands: Commands) {
    panel::spawn(&mut commands, KEYS);
}

/// Writes what is going on into the panel.
pub fn show(
    shown: Res<Shown>,
    lighting: Res<ProgressiveLighting>,
    status: Res<EnvironmentStatus>,
    cameras: Query<(&Refinement, Has<EnvironmentMapLight>)>,
    mut states: Query<&mut Text, With<State>>,
) {
    let state = match &status.state {
        EnvironmentState::None => "none".into(),
        EnvironmentState::Loading => "reading ...".into(),
        EnvironmentState::Choosing => "choosing lights ...".into(),
        EnvironmentState::Ready => "ready".into(),
        EnvironmentState::Failed(reason) => format!("failed: {reason}"),
    };
    let crowded = if status.crowded_out { " (crowded out)" } else { "" };
    let lights = format!(
        "{} lights by {}, {} of {} a frame{crowded}{}",
        status.lights,
        lighting.method,
        status.per_frame,
        lighting.per_frame,
        if lighting.shadows { "" } else { ", no shadows" },
    );
    let (refinement, image_based) =
        cameras.iter().next().map_or((Refinement::default(), false), |(r, i)| (*r, i));
    let picture = if image_based {
        "Bevy's image-based light".into()
    } else if status.per_frame == 0 {
        "no light".into()
    } else if !shown.accumulate {
        "each frame for itself".into()
    } else if refinement.is_refined() {
        format!("refined, {} frames", refinement.of)
    } else {
        format!("{} of {} frames", refinement.frames, refinement.of)
    };
    let text = format!(
        "{}: {state}\n{lights}\n{picture}, exposure {:.1} EV",
        shown.chosen().name,
        shown.exposure
    );
    for mut state in &mut states {
        if state.0 != text {
            state.0.clone_from(&text);
        }
    }
}

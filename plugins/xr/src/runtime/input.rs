//! From OpenXR's actions to what the app reads.

use std::borrow::Cow;

use bevy::prelude::*;
use bevy_mod_openxr::{
    action_binding::{OxrSendActionBindings, OxrSuggestActionBinding},
    action_set_attaching::OxrAttachActionSet,
    action_set_syncing::{OxrActionSetSyncSet, OxrSyncActionSet},
    openxr_session_running,
    resources::{OxrFrameState, OxrInstance, Pipelined},
    session::OxrSession,
};
use bevy_mod_xr::{
    session::{XrPreDestroySession, XrSessionCreated},
    spaces::XrPrimaryReferenceSpace,
};
use farlight_bindings::{Hand, Xr};
use farlight_controls::{XrControllers, XrHandInputs};
use openxr::{SessionState, SpaceLocationFlags};

use super::{Found, action::Actions, eyes::isometry, session::Session};
use crate::{Haptic, XrHandTracking, XrSystems, XrTracking, tracking};

#[derive(Resource, Clone, Copy)]
struct HandInteraction(bool);

pub(super) fn build(app: &mut App, found: &Found) {
    app.insert_resource(HandInteraction(found.hand_interaction))
        .add_systems(XrSessionCreated, create)
        .add_systems(OxrSendActionBindings, suggest)
        .add_systems(XrPreDestroySession, forget)
        .add_systems(PreUpdate, ask.before(OxrActionSetSyncSet).run_if(openxr_session_running))
        .add_systems(
            PreUpdate,
            (read, locate)
                .chain()
                .after(OxrActionSetSyncSet)
                .before(tracking::follow_hands)
                .in_set(XrSystems::Read),
        )
        .add_systems(Last, shake);
}

/// Every session has its own actions: what was once attached to a session can't be changed any more.
fn create(
    instance: Res<OxrInstance>,
    session: Option<Res<OxrSession>>,
    hands: Res<HandInteraction>,
    mut attach: MessageWriter<OxrAttachActionSet>,
    mut count: Local<u32>,
    mut commands: Commands,
) {
    let Some(session) = session else { return };
    *count += 1;
    match Actions::new(&instance, *count, hands.0) {
        Ok(mut actions) => {
            actions.follow(&session);
            attach.write(OxrAttachActionSet(actions.set.clone()));
            commands.insert_resource(actions);
        }
        Err(error) => warn!("controllers can't be used: {error}"),
    }
}

/// Suggests what the runtime has taken once more, together with what others suggest: the last
/// suggestion for a profile counts.
fn suggest(actions: Option<Res<Actions>>, mut suggestions: MessageWriter<OxrSuggestActionBinding>) {
    let Some(actions) = actions else { return };
    for profile in &actions.profiles {
        for (action, paths) in actions.bindings(*profile) {
            suggestions.write(OxrSuggestActionBinding {
                action,
                interaction_profile: Cow::Borrowed(profile.path_of_profile()),
                bindings: paths.into_iter().map(Cow::Owned).collect(),
            });
        }
    }
}

fn forget(
    mut commands: Commands,
    mut controllers: ResMut<XrControllers>,
    mut tracking: ResMut<XrTracking>,
) {
    commands.remove_resource::<Actions>();
    *controllers = XrControllers::default();
    tracking.hands = Default::default();
}

fn ask(actions: Option<Res<Actions>>, mut sync: MessageWriter<OxrSyncActionSet>) {
    if let Some(actions) = actions {
        sync.write(OxrSyncActionSet(actions.set.clone()));
    }
}

fn read(
    actions: Option<Res<Actions>>,
    present: Option<Res<OxrSession>>,
    mut session: ResMut<Session>,
    mut controllers: ResMut<XrControllers>,
    mut had_focus: Local<bool>,
) {
    let (Some(actions), Some(present)) = (actions, present) else { return };
    let has_focus = session.state == SessionState::FOCUSED;
    if !has_focus {
        // Whatever was held is let go: the runtime's menu has the controllers.
        if std::mem::take(&mut *had_focus) {
            for hand in &mut controllers.hands {
                hand.values.clear();
            }
        }
        return;
    }
    let ask_profile = session.profile_changed || !*had_focus;
    session.profile_changed = false;
    *had_focus = true;
    for hand in Hand::ALL {
        let before = controllers.hand(hand);
        let profile = if ask_profile { actions.profile(&present, hand) } else { before.profile };
        let mut now = XrHandInputs { profile, ..default() };
        // Written later in the frame.
        now.values.extend(before.values.get_key_value(&Xr::Swing));
        for (input, value) in actions.read(&present, hand) {
            if let Some(value) = value {
                now.values.insert(input, value);
            }
        }
        if *before != now {
            *controllers.hand_mut(hand) = now;
        }
    }
}

/// Where hands will be when the frame is seen.
fn locate(
    actions: Option<Res<Actions>>,
    present: Option<Res<OxrSession>>,
    base: Option<Res<XrPrimaryReferenceSpace>>,
    frame: Option<Res<OxrFrameState>>,
    pipelined: Option<Res<Pipelined>>,
    session: Res<Session>,
    mut tracking: ResMut<XrTracking>,
) {
    let (Some(actions), Some(present), Some(base), Some(frame)) = (actions, present, base, frame)
    else {
        return;
    };
    // The next frame is drawn while this one is made.
    let ahead = if pipelined.is_some() { frame.predicted_display_period.as_nanos() } else { 0 };
    let time = openxr::Time::from_nanos(frame.predicted_display_time.as_nanos() + ahead);
    let valid = SpaceLocationFlags::POSITION_VALID | SpaceLocationFlags::ORIENTATION_VALID;
    for hand in Hand::ALL {
        let [grip, aim] = actions.spaces[hand as usize].map(|space| {
            if session.state != SessionState::FOCUSED {
                return None;
            }
            let location = present.locate_space(&space?, &base, time).ok()?;
            location.location_flags.contains(valid).then(|| isometry(location.pose))
        });
        let now = XrHandTracking { grip, aim };
        if *tracking.hand(hand) != now {
            *tracking.hand_mut(hand) = now;
        }
    }
}

fn shake(
    mut wishes: MessageReader<Haptic>,
    actions: Option<Res<Actions>>,
    present: Option<Res<OxrSession>>,
    session: Res<Session>,
) {
    for wish in wishes.read() {
        if let (Some(actions), Some(present)) = (&actions, &present)
            && session.state == SessionState::FOCUSED
            && let Err(error) = actions.shake(present, wish)
        {
            debug!("a controller doesn't shake: {error}");
        }
    }
}

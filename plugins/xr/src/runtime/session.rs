//! The session: what the app learns of it, how it begins again, and how it ends before the app does.

use std::{
    sync::atomic::Ordering,
    time::{Duration, Instant},
};

use bevy::{
    prelude::*,
    window::{PresentMode, PrimaryWindow, RequestRedraw},
};
use bevy_mod_openxr::{
    poll_events::{OxrEventHandlerExt as _, OxrEventIn},
    resources::OxrSessionStarted,
    session::OxrSession,
};
use bevy_mod_xr::session::{
    XrCreateSessionMessage, XrDestroySessionMessage, XrDestroySessionRender, XrFirst,
    XrHandleEvents, XrSessionDestroyedMessage, XrState,
};
use openxr::{Event, SessionState};

use crate::{FarlightXr, XrFocus, XrRequest, XrStatus};

/// How long an app that wants to exit waits for the runtime to let it go.
const PATIENCE: Duration = Duration::from_secs(2);
/// How long after a session was lost the next one is tried.
const PAUSE: Duration = Duration::from_secs(1);

/// The session as the runtime sees it: `bevy_mod_xr` doesn't say whether it is shown, and whether
/// controllers are the app's.
#[derive(Resource)]
pub(super) struct Session {
    pub(super) state: SessionState,
    /// Another kind of controller may be in hand.
    pub(super) profile_changed: bool,
    quit_with_it: bool,
    /// The app has asked for the end.
    ending: bool,
    /// When to begin anew.
    restart: Option<Instant>,
    /// The exit that waits, and since when.
    exit: Option<(AppExit, Instant)>,
}

pub(super) fn build(app: &mut App, settings: &FarlightXr) {
    app.insert_resource(Session {
        state: SessionState::UNKNOWN,
        profile_changed: false,
        quit_with_it: settings.quit_with_session,
        ending: false,
        restart: None,
        exit: None,
    })
    .add_oxr_event_handler(hear)
    .add_systems(
        XrFirst,
        (obey, begin_again).chain().before(XrHandleEvents::SessionStateUpdateEvents),
    )
    .add_systems(First, tell)
    .add_systems(Last, (keep_drawing, hold_exit));
}

fn hear(event: OxrEventIn, mut session: ResMut<Session>, mut exits: MessageWriter<AppExit>) {
    match event.0 {
        Event::SessionStateChanged(change) => {
            session.state = change.state();
            match session.state {
                SessionState::LOSS_PENDING => session.restart = Some(Instant::now() + PAUSE),
                SessionState::EXITING if !session.ending && session.exit.is_none() => {
                    info!("the app was closed from the headset");
                    if session.quit_with_it {
                        exits.write(AppExit::Success);
                    }
                }
                _ => {}
            }
        }
        Event::InteractionProfileChanged(_) => session.profile_changed = true,
        Event::InstanceLossPending(_) => warn!("the OpenXR runtime is about to stop"),
        _ => {}
    }
}

/// Whether frames go to the runtime.
fn runs(started: Option<&OxrSessionStarted>) -> bool {
    started.is_some_and(|started| started.0)
}

/// Tells the app.
fn tell(
    session: Res<Session>,
    present: Option<Res<OxrSession>>,
    mut status: ResMut<XrStatus>,
    mut focus: ResMut<XrFocus>,
    mut windows: Query<&mut Window, With<PrimaryWindow>>,
    mut presented: Local<Option<PresentMode>>,
) {
    let is_there = present.is_some();
    let shown = matches!(session.state, SessionState::VISIBLE | SessionState::FOCUSED);
    let now = if is_there && shown { XrStatus::Running } else { XrStatus::Idle };
    focus.set_if_neq(XrFocus(is_there && session.state == SessionState::FOCUSED));
    if !status.set_if_neq(now) {
        return;
    }
    // A window that waits for its screen would make the headset wait, too.
    for mut window in &mut windows {
        match (&*status, presented.take()) {
            (XrStatus::Running, before) => {
                *presented = Some(before.unwrap_or(window.present_mode));
                window.present_mode = PresentMode::AutoNoVsync;
            }
            (_, Some(before)) => window.present_mode = before,
            (_, None) => {}
        }
    }
}

/// Windows in the background get few frames; the headset needs all.
fn keep_drawing(
    started: Option<Res<OxrSessionStarted>>,
    redraw: Option<MessageWriter<RequestRedraw>>,
) {
    if runs(started.as_deref())
        && let Some(mut redraw) = redraw
    {
        redraw.write(RequestRedraw);
    }
}

/// Begins and ends as the app wishes.
fn obey(
    mut wishes: MessageReader<XrRequest>,
    mut session: ResMut<Session>,
    present: Option<Res<OxrSession>>,
    started: Option<Res<OxrSessionStarted>>,
) {
    for wish in wishes.read() {
        match wish {
            XrRequest::Start if present.is_none() => session.restart = Some(Instant::now()),
            XrRequest::Start => {}
            XrRequest::End => {
                session.restart = None;
                if let Some(present) = &present
                    && runs(started.as_deref())
                {
                    session.ending = true;
                    request_exit(present);
                }
            }
        }
    }
}

fn request_exit(session: &OxrSession) {
    // It may have ended by itself in the meantime.
    if let Err(error) = session.request_exit() {
        debug!("the session does not end: {error}");
    }
}

/// Makes a session where one is wanted and none is left.
fn begin_again(
    mut session: ResMut<Session>,
    state: Option<Res<XrState>>,
    present: Option<Res<OxrSession>>,
    mut destroyed: MessageReader<XrSessionDestroyedMessage>,
    mut create: MessageWriter<XrCreateSessionMessage>,
    mut gone: Local<bool>,
) {
    if destroyed.read().count() > 0 {
        session.ending = false;
        session.state = SessionState::UNKNOWN;
        *gone = true;
    }
    let is_free = *gone && present.is_none() && state.as_deref() == Some(&XrState::Available);
    if is_free && session.restart.is_some_and(|when| when <= Instant::now()) {
        session.restart = None;
        *gone = false;
        create.write_default();
    }
}

/// An app that exits first ends its session, as OpenXR wants it, and waits until both worlds have let
/// it go: what a session holds must not outlive the graphics device.
fn hold_exit(
    mut exits: ResMut<Messages<AppExit>>,
    mut session: ResMut<Session>,
    present: Option<Res<OxrSession>>,
    started: Option<Res<OxrSessionStarted>>,
    rendered: Option<Res<XrDestroySessionRender>>,
    mut state: ResMut<XrState>,
    mut destroy: MessageWriter<XrDestroySessionMessage>,
) {
    let is_held = rendered.is_some_and(|flag| flag.0.load(Ordering::Relaxed));
    let is_gone = present.is_none() && !is_held;
    if let Some((exit, since)) = session.exit.clone() {
        exits.clear();
        if is_gone || since.elapsed() > PATIENCE {
            exits.write(exit);
        }
        return;
    }
    if is_gone || exits.is_empty() {
        return;
    }
    let wanted = exits.drain().reduce(|first, next| if first.is_error() { first } else { next });
    session.exit = wanted.map(|exit| (exit, Instant::now()));
    session.restart = None;
    session.ending = true;
    match present {
        Some(present) if runs(started.as_deref()) => request_exit(&present),
        // It never began, or has ended already: nothing more will come of it.
        Some(_) if !matches!(*state, XrState::Exiting { .. }) => {
            *state = XrState::Exiting { should_restart: false };
            destroy.write_default();
        }
        _ => {}
    }
}

//! Bevy's plugins with a headset.

use bevy::{
    app::{PluginGroup, PluginGroupBuilder},
    prelude::*,
};
use farlight_controls::XrControllers;
use farlight_core::FarlightCorePlugin;

use crate::{
    Haptic, XrFocus, XrRequest, XrStatus, mirror, model, screenshot, show, status, swing, tracking,
};

/// The environment variable that switches headsets off.
const SWITCH: &str = "FARLIGHT_XR";

/// A headset for an app: `FarlightXr::default().wrap(DefaultPlugins)`.
///
/// | setting | default |
/// |---|---|
/// | [`disabled`](Self::disabled), [`switched_by`](Self::switched_by), `FARLIGHT_XR=off` | a headset is used if there is one |
/// | [`app_name`](Self::app_name) | `Farlight` |
/// | [`resolution_scale`](Self::resolution_scale) | 1 |
/// | [`space`](Self::space) | [`XrSpace::Stage`] |
/// | [`near`](Self::near) | 0.05 m |
/// | [`see_through`](Self::see_through) | off |
/// | [`controller_models`](Self::controller_models) | on |
/// | [`mirror`](Self::mirror) | on, if there is a window |
/// | [`quit_with_session`](Self::quit_with_session) | on |
/// | [`synchronous_pipelines`](Self::synchronous_pipelines) | off |
///
/// What the wrapped `RenderPlugin` says of the graphics device doesn't count with a headset, since the
/// runtime chooses the device; all other plugins stay as they are.
#[derive(Clone, Debug, PartialEq)]
pub struct FarlightXr {
    pub(crate) off: Option<String>,
    pub(crate) app_name: String,
    pub(crate) resolution_scale: f32,
    pub(crate) space: XrSpace,
    pub(crate) eye_height: f32,
    pub(crate) near: f32,
    pub(crate) see_through: bool,
    pub(crate) models: bool,
    pub(crate) mirror: bool,
    pub(crate) quit_with_session: bool,
    pub(crate) synchronous_pipelines: bool,
}

/// Where the middle of the person's space is. If the runtime doesn't know the one that was asked for,
/// it is the next that it knows, in this order; below that a floor is supposed
/// [`eye_height`](FarlightXr::eye_height) below the eyes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum XrSpace {
    /// The middle of the floor that the person may walk on.
    #[default]
    Stage,
    /// The floor below where the person was at the start.
    LocalFloor,
    /// The person's head at the start: for who sits.
    Local,
}

impl Default for FarlightXr {
    fn default() -> Self {
        Self {
            off: None,
            app_name: "Farlight".into(),
            resolution_scale: 1.0,
            space: XrSpace::default(),
            eye_height: 1.6,
            near: 0.05,
            see_through: false,
            models: true,
            mirror: true,
            quit_with_session: true,
            synchronous_pipelines: false,
        }
    }
}

impl FarlightXr {
    /// No headset, even if there is one.
    #[must_use]
    pub fn disabled(self) -> Self {
        Self { off: Some("it is switched off".into()), ..self }
    }

    /// Looks for `--xr off` (or `--xr=off`) among the program's arguments; everything else is ignored.
    #[must_use]
    pub fn switched_by(self, arguments: impl IntoIterator<Item = String>) -> Self {
        let mut arguments = arguments.into_iter();
        while let Some(argument) = arguments.next() {
            let value = match argument.strip_prefix("--xr") {
                Some("") => arguments.next(),
                Some(rest) => rest.strip_prefix('=').map(str::to_owned),
                None => None,
            };
            if value.is_some_and(|value| is_off(&value)) {
                return Self { off: Some("it is switched off by --xr off".into()), ..self };
            }
        }
        self
    }

    /// What the runtime calls the app, in its list of what runs.
    #[must_use]
    pub fn app_name(self, name: impl Into<String>) -> Self {
        Self { app_name: name.into(), ..self }
    }

    /// Pixels along each edge of an eye's picture, as a part of what the runtime recommends: from 0.25
    /// to 2. Less is faster and coarser.
    #[must_use]
    pub fn resolution_scale(self, scale: f32) -> Self {
        let scale = if scale.is_finite() { scale.clamp(0.25, 2.0) } else { 1.0 };
        Self { resolution_scale: scale, ..self }
    }

    /// Where the middle of the person's space is.
    #[must_use]
    pub fn space(self, space: XrSpace) -> Self {
        Self { space, ..self }
    }

    /// How high above the floor eyes are supposed to be where the runtime doesn't know the floor, in
    /// metres.
    #[must_use]
    pub fn eye_height(self, metres: f32) -> Self {
        Self { eye_height: metres, ..self }
    }

    /// Metres from an eye; what is nearer is not drawn. From 0.001 to 10.
    #[must_use]
    pub fn near(self, metres: f32) -> Self {
        let near = if metres.is_finite() { metres.clamp(0.001, 10.0) } else { 0.05 };
        Self { near, ..self }
    }

    /// Whether the real room is seen where nothing is drawn, on headsets that can: give the eyes a
    /// transparent `ClearColor`.
    #[must_use]
    pub fn see_through(self, see_through: bool) -> Self {
        Self { see_through, ..self }
    }

    /// Whether simple controllers with rays are drawn where the hands are.
    #[must_use]
    pub fn controller_models(self, models: bool) -> Self {
        Self { models, ..self }
    }

    /// Whether the window shows what the left eye sees.
    #[must_use]
    pub fn mirror(self, mirror: bool) -> Self {
        Self { mirror, ..self }
    }

    /// Whether the app exits when the person closes it from the headset's own menu. Otherwise it goes on
    /// on the desktop, and [`XrRequest::Start`] begins anew.
    #[must_use]
    pub fn quit_with_session(self, quit: bool) -> Self {
        Self { quit_with_session: quit, ..self }
    }

    /// Whether frames wait for pipelines that are being compiled, as the field of the same meaning of the
    /// wrapped `RenderPlugin`.
    #[must_use]
    pub fn synchronous_pipelines(self, synchronous: bool) -> Self {
        Self { synchronous_pipelines: synchronous, ..self }
    }

    /// Bevy's plugins, with a headset if there is one.
    pub fn wrap(self, plugins: impl PluginGroup) -> PluginGroupBuilder {
        let group = plugins.build();
        let reason = match (&self.off, std::env::var(SWITCH)) {
            (Some(reason), _) => Some(reason.clone()),
            (None, Ok(value)) if is_off(&value) => {
                Some(format!("it is switched off by {SWITCH}={value}"))
            }
            _ => None,
        };
        if let Some(reason) = reason {
            return group.add(XrPlugin { settings: self, found: Err(reason) });
        }
        #[cfg(not(target_family = "wasm"))]
        let (group, found) = crate::runtime::wrap(group, &self);
        #[cfg(target_family = "wasm")]
        let found = Err("browsers' headsets are not supported yet".into());
        group.add(XrPlugin { settings: self, found })
    }
}

fn is_off(value: &str) -> bool {
    ["off", "0", "no", "false"].iter().any(|off| value.eq_ignore_ascii_case(off))
}

#[cfg(not(target_family = "wasm"))]
pub(crate) use crate::runtime::Found;
/// What a runtime is: nothing that a browser has.
#[cfg(target_family = "wasm")]
#[derive(Clone, Debug)]
pub(crate) enum Found {}

/// What is there with and without a runtime. [`FarlightXr::wrap`] adds it; add it by itself for a
/// simulated headset that writes [`XrTracking`](crate::XrTracking).
#[derive(Clone, Debug)]
pub struct XrPlugin {
    pub(crate) settings: FarlightXr,
    pub(crate) found: Result<Found, String>,
}

impl Default for XrPlugin {
    fn default() -> Self {
        Self { settings: FarlightXr::default(), found: Err("it is simulated".into()) }
    }
}

impl Plugin for XrPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<XrStatus>()
            .init_resource::<XrFocus>()
            .init_resource::<XrControllers>()
            .add_message::<Haptic>()
            .add_message::<XrRequest>()
            .add_systems(Startup, status::announce)
            .add_systems(First, status::rest_desktop_cameras);
        tracking::build(app);
        swing::build(app);
        show::build(app);
        mirror::build(app, self.settings.mirror);
        screenshot::build(app);
        model::build(app, self.settings.models);
        match &self.found {
            Err(reason) => {
                app.insert_resource(XrStatus::Unavailable(reason.clone()));
            }
            #[cfg(not(target_family = "wasm"))]
            Ok(found) => crate::runtime::build(app, &self.settings, found),
            #[cfg(target_family = "wasm")]
            Ok(found) => match *found {},
        }
    }

    fn finish(&self, app: &mut App) {
        // The shaders are there. Not earlier: the app may add it after this plugin.
        if !app.is_plugin_added::<FarlightCorePlugin>() && app.is_plugin_added::<AssetPlugin>() {
            app.add_plugins(FarlightCorePlugin);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_argument_switches_it_off() {
        let by = |arguments: &[&str]| {
            FarlightXr::default().switched_by(arguments.iter().map(|&a| a.to_owned())).off.is_some()
        };
        assert!(by(&["program", "--xr", "off"]));
        assert!(by(&["program", "--xr=OFF", "other"]));
        assert!(!by(&["program", "--xr", "on"]));
        assert!(!by(&["program", "--xr"]));
        assert!(!by(&["program", "--xray", "off"]));
    }

    #[test]
    fn senseless_numbers_are_not_taken() {
        let xr = FarlightXr::default().resolution_scale(9.0).near(f32::NAN);
        assert_eq!((xr.resolution_scale, xr.near), (2.0, 0.05));
        assert_eq!(FarlightXr::default().resolution_scale(f32::NAN).resolution_scale, 1.0);
    }
}

//! Headsets, by OpenXR. A headset takes Bevy's renderer over, so the app's plugins are wrapped; where
//! there is no headset, the same program runs on the desktop:
//!
//! ```no_run
//! use bevy::prelude::*;
//! use farlight_xr::{FarlightXr, XrEye};
//!
//! App::new()
//!     .add_plugins(FarlightXr::default().wrap(DefaultPlugins))
//!     // Both eyes are cameras: give them what cameras of the game have.
//!     .add_observer(|eye: On<Add, XrEye>, mut commands: Commands| {
//!         commands.entity(eye.entity).insert(Msaa::Off);
//!     })
//!     .run();
//! ```
//!
//! | item | for |
//! |---|---|
//! | [`FarlightXr`] | the plugins; all settings |
//! | [`XrStatus`], [`XrFocus`], [`XrRequest`] | whether the headset shows the app; to begin and to end that |
//! | [`XrEye`], [`DesktopCamera`] | cameras |
//! | [`XrHead`], [`XrHandPose`], [`XrTracking`] | where head and hands are |
//! | [`XrRig`], [`Recentre`] | where the person's room stands in the world: teleport, turn, scale |
//! | `XrControllers` of `farlight_controls` | what is pressed; bindings make actions of it |
//! | [`Haptic`] | shakes a controller |
//! | [`XrControllerModel`], [`XrRay`] | simple controllers with rays |
//! | [`XrMirror`], [`XrScreenshot`] | what the eyes see, for others |

mod eye;
mod hand;
mod mirror;
mod model;
mod rig;
#[cfg(not(target_family = "wasm"))]
mod runtime;
mod screenshot;
mod show;
mod status;
mod swing;
mod tracking;
mod wrap;

pub use eye::{EyeProjection, Fov, XrEye, eye_camera, eye_projection};
pub use hand::{Haptic, XrHandPose, XrHead};
pub use mirror::XrMirror;
pub use model::{XrControllerModel, XrRay};
pub use rig::{Recentre, XrRig, XrRoot};
pub use screenshot::{XrScreenshot, XrScreenshotSaved};
pub use status::{DesktopCamera, XrFocus, XrRequest, XrStatus};
pub use tracking::{XrHandTracking, XrSystems, XrTracking, XrView};
pub use wrap::{FarlightXr, XrPlugin, XrSpace};

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

mod eye;
mod hand;
mod status;
mod wrap;

pub use eye::{Fov, XrEye, eye_projection};
pub use hand::{Haptic, XrHandPose, XrHead};
pub use status::{Recentre, XrRig, XrStatus};
pub use wrap::FarlightXr;

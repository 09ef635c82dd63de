//! Global illumination for Bevy, solved on another machine: the network backend of
//! [`farlight_gi`].
//!
//! A lighting server (`farlight serve`) prints an invitation; the game needs nothing else:
//!
//! ```no_run
//! use bevy::prelude::*;
//! use farlight_gi::{GiPlugin, GiScene};
//! use farlight_remote::{RemoteBackend, RemoteSettings};
//!
//! let settings = RemoteSettings::from_invite_file("farlight.invite");
//! let gi = GiPlugin::with_backend(RemoteBackend::factory(settings));
//! App::new().add_plugins((DefaultPlugins, gi)).add_systems(Startup, |mut commands: Commands| {
//!     commands.spawn((GiScene, Transform::default(), Visibility::default()));
//! });
//! ```
//!
//! # What happens
//! The scene goes to the server once (meshes and images by their content), then its changes; light
//! comes back and is decoded in a thread of its own. When the connection is lost, the game keeps the
//! light that it has; the thread tries again and again, and what the server still has is not sent
//! a second time. [`GiStatus`](farlight_gi::GiStatus) says how it is going: `state` is
//! [`Disconnected`](farlight_gi::GiState::Disconnected) meanwhile, `link` tells why, how often it
//! was tried, and what was sent and received. A wrong token, a server that isn't the invited one, or
//! one of another version is final: `state` is [`Failed`](farlight_gi::GiState::Failed).
//!
//! Other transports than QUIC (an in-memory link in tests, a browser's WebTransport) come in as a
//! [`Connector`](farlight_wire::Connector).

mod attempts;
mod backend;
mod driver;
#[cfg(not(target_arch = "wasm32"))]
mod invite;
mod light;
mod mailbox;
mod plugin;
mod settings;
#[cfg_attr(target_arch = "wasm32", expect(dead_code, reason = "nobody waits without threads"))]
mod shared;

pub use backend::RemoteBackend;
pub use driver::Driver;
pub use plugin::RemotePlugin;
pub use settings::RemoteSettings;

/// The wire's types that the backend speaks of.
pub use farlight_wire as wire;

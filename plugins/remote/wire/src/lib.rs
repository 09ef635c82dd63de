//! The wire of remote lighting, sans-IO: messages, codecs and session state machines without an
//! engine, a socket or a clock.
//!
//! A game (the client) sends a scene and its changes, a lighting server answers with lightmap
//! texels and probes. This crate decides *what* is sent and when; a [`Link`] moves the bytes.
//! Everything is driven from outside and can run in virtual time:
//!
//! ```text
//! game  --submit--> ClientSession --poll_transmit--> Link ~~~ Link --receive--> ServerSession --take_changes--> solver
//! game  <--event--- ClientSession <---receive------- Link ~~~ Link <--poll_transmit-- ServerSession <--publish-- solver
//! ```
//!
//! # Ideas
//! - **State is synchronized, not a log.** The client keeps which of its objects changed since the
//!   last message and sends their newest state; a slow line skips states, it never queues them.
//!   The server does the same with texels. So both resume after any loss by sending what differs.
//! - **Heavy data goes by content.** Meshes, textures and sky images are blobs named by the BLAKE3
//!   hash of their encoding; the server asks for the ones it doesn't have, once.
//! - **Every answer names the question.** A [`SnapshotId`](farlight_gi_solver::session::SnapshotId)
//!   is a frame of the client; lighting says which snapshot it shows.
//! - **Nothing is believed.** Sizes are checked against [`Limits`] before memory is taken, unknown
//!   messages are skipped, everything else that doesn't fit is a [`WireError`].
//!
//! Time is a [`Duration`](std::time::Duration) since any fixed moment of the caller's steady clock.

mod blob;
mod client;
mod codec;
mod error;
mod invitation;
mod lighting;
mod limits;
mod link;
mod message;
mod ping;
mod server;
pub mod simulated;
mod texels;
mod view;

pub use blob::{Blob, BlobHash};
pub use client::{ClientConfig, ClientEvent, ClientSession, SyncState, Trip};
pub use error::{CloseCode, WireError};
pub use invitation::{Invitation, InvitationError, Token};
pub use lighting::{HalfGrid, HalfTile, LightingMessage, Piece, ServerTimes};
pub use limits::Limits;
pub use link::{
    Channel, Closed, Connector, Link, LinkEvent, LinkStats, Listener, Transmit, TransmitId, Wake,
};
pub use server::{
    BlobStore, ClientHello, SceneSize, ServerConfig, ServerEvent, ServerSession, SessionKey,
    Welcome,
};
pub use view::View;

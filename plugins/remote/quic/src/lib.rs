//! Links of remote lighting over WebTransport (HTTP/3 over QUIC), as browsers speak it too: a
//! [`Connector`](farlight_wire::Connector) for games, a [`Listener`](farlight_wire::Listener) for lighting
//! servers, and who believes whom.
//!
//! ```no_run
//! use std::sync::Arc;
//! use farlight_quic::{Authority, ListenConfig, QuicConnector, QuicListener};
//! use farlight_wire::{Connector, Invitation, Limits, Listener};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // The server. The folder is made on first start and should stay.
//! let authority = Arc::new(Authority::open("/var/lib/farlight")?);
//! let listener = QuicListener::bind(ListenConfig::new("[::]:4433".parse()?, authority.clone()))?;
//! let invitation = Invitation {
//!     host: "light.example.org".into(),
//!     port: listener.local_addr().port(),
//!     token: authority.token(),
//!     authority: authority.fingerprint(),
//! };
//!
//! // The game.
//! let mut connector = QuicConnector::new(&invitation);
//! let link = connector.connect(&Limits::default(), Arc::new(|| println!("call link.poll()")));
//! # Ok(())
//! # }
//! ```
//!
//! # Trust
//! A server has a certificate authority of its own, [`Authority`], that stays in a folder. An invitation
//! carries the SHA-256 of the authority's certificate, and a client believes nothing else ([`Pin`]): no
//! public authority, no host name. What TLS presents is signed by that authority, valid for less than 14
//! days and replaced every 7 ([`Certificates`]), also when the clock jumps. Browsers, which know no pinned
//! authorities, take the SHA-256 of that certificate (`serverCertificateHashes`);
//! [`ListenConfig::hashes`] names a file that always has the present one and the next one. They change when
//! the server is started anew.
//!
//! The access token is not checked here: sessions send it in their first message.
//!
//! # Streams
//! The client opens one bidirectional stream for [`Channel::Control`](farlight_wire::Channel::Control):
//! messages with their length before them (`u32`, little-endian). Every other message has a unidirectional
//! stream of its own, the channel's number and then the message, so what is lost delays only the message
//! that it is of, and giving up a message is resetting its stream. Control goes before Latest, and Latest
//! before Bulk, older messages before newer ones.
//!
//! A message waits here until there is room on the line, not in QUIC's buffers. So `LinkEvent::Sent` means
//! that it is about to leave, and whoever waits for it sends what is newest then.
//!
//! # Bad lines
//! The congestion control is made for this use (module `congestion`): a few losses are noise, a queue or many
//! losses are congestion, and silence lets a few more packets go instead of fewer. With 100 ms round trip
//! and 5 % loss the first message comes within 0.7 s after outages of up to 5.6 s, and 20 KB of new light
//! within 1 s, also when the line is full, if sessions ping every 200 ms (`recovery_times` in the tests).
//! A server that was killed and started again says so to clients of the one before
//! (stateless reset), so they needn't wait for a timeout.
//!
//! # Bounds
//! What the other side may take of memory is bounded and counted: unfinished messages, those that the
//! session has not fetched (8 MiB, or four messages), 4 MiB in QUIC's receive window, 64 streams. Beyond that
//! it has to wait. A message over its [limit](farlight_wire::Limits) ends the connection before it is in
//! memory. Handshakes at once, connections at once and connections that nobody accepts are bounded.
//!
//! # Threads
//! All links of a process share one thread, which ends with the last of them. Dropping a link gives the
//! connection up.

mod authority;
mod congestion;
mod connect;
mod end;
mod files;
mod incoming;
mod listen;
mod network;
mod outgoing;
mod pin;
mod pump;
mod rotation;
mod shared;
mod transport;

pub use authority::{Authority, AuthorityError, Leaf, SERVER_NAME};
pub use connect::QuicConnector;
pub use listen::{ListenConfig, ListenError, QuicListener};
pub use pin::{Pin, PinError};
pub use rotation::{Certificates, Clock};

//! The lighting server as a library: it solves whatever scenes its clients send and streams their
//! light. No engine, and no network of its own: clients come in over any
//! [`Listener`](farlight_wire::Listener).
//!
//! ```text
//! Listener --link--> door: greeting, token --> session: driver <--messages--> ServerSession
//!                                                          \--> solver <--changes, light--^
//! ```
//!
//! - [`Server`] runs it all in threads; [`SteppedServer`] is the same without threads and clock.
//! - [`ServerSettings`] bounds what a client gets: sessions, texels, memory, time.
//! - Sessions don't disturb each other: a client that breaks the rules loses its own session, and so
//!   does one whose solver fails. A session whose client loses its connection is kept for a while.

mod bell;
mod door;
mod driver;
mod grant;
mod house;
mod report;
mod server;
mod settings;
mod stepped;
mod worker;

pub use farlight_gi_solver::settings::SettingsError;
pub use report::SessionReport;
pub use server::Server;
pub use settings::ServerSettings;
pub use stepped::SteppedServer;
pub use worker::SolverFactory;

pub use farlight_gi_solver::session::Solve;

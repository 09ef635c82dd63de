//! Links of remote lighting over WebTransport.

mod authority;
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

//! Links of remote lighting over WebTransport.

mod authority;
mod files;
mod pin;
mod rotation;

pub use authority::{Authority, AuthorityError, Leaf, SERVER_NAME};
pub use pin::{Pin, PinError};
pub use rotation::{Certificates, Clock};

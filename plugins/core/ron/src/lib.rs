//! Settings in [RON](https://docs.rs/ron), read for people: an error says in which line and which field
//! something is wrong, and what may have been meant. Knows no engine, no file and no settings of its own.
//!
//! ```
//! #[derive(serde::Deserialize, Debug)]
//! #[serde(deny_unknown_fields)]
//! struct Lamp {
//!     watts: f32,
//! }
//!
//! let text = "Lamp(\n    wats: 60.0,\n)";
//! let error = farlight_ron::parse::<Lamp>(text).unwrap_err();
//! assert_eq!(error.to_string(), "2:5: wats: there is no field \"wats\"; did you mean watts?");
//!
//! // A check of one's own names the field by its path.
//! let text = "Lamps(\n    all: [(watts: -1.0)],\n)";
//! let error = farlight_ron::FileError::of_field(text, "all[0].watts", "must not be negative");
//! assert_eq!(error.to_string(), "2:12: all[0].watts: must not be negative");
//!
//! // Where a field is.
//! assert_eq!(farlight_ron::place_of("Lamps(all: [(watts: -1.0)])", "all[0].watts"), Some((1, 14)));
//! ```

mod error;
mod near;
mod places;

pub use error::{FileError, parse};
pub use near::{meant, nearest};
pub use places::{Place, field_at, place_of};

//! What the scene's file can't say: added lights, and scenarios.
//!
//! [`BakeLights`] is what a user writes down, in RON:
//!
//! ```ron
//! BakeLights(
//!     add: [
//!         (name: "lamp", kind: Point, position: (0.0, 2.2, 0.0), intensity: (80.0, 70.0, 55.0)),
//!         (name: "sun", kind: Directional, direction: (0.3, -0.7, 1.0), angle: 0.27,
//!             intensity: (20000.0, 19000.0, 17000.0)),
//!     ],
//!     scenarios: [
//!         (name: "noon", lights: ["sun"], sky: Constant((4000.0, 5000.0, 7000.0))),
//!         (name: "lamp on", lights: ["lamp"]),
//!     ],
//! )
//! ```

mod check;
mod file;
mod sky;

pub use check::LightsError;
pub use file::{AddedKind, AddedLight, BakeLights, ScenarioSpec, SkySpec};
pub(crate) use sky::{SkySource, read_skies};

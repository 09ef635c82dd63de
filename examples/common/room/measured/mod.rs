//! Runs without a window: what they measure, the pictures, the report, and memory over a long run.
//!
//! While the app runs live, only the recorder between plugin and backend looks at what is exchanged.
//! The references come afterwards, from the solver's own path tracer in this process, whoever solved
//! the live light.

mod compare;
#[path = "../../headless.rs"]
#[expect(dead_code, reason = "shared with the tests, which use more of it")]
mod headless;
mod live;
mod measure;
mod network;
mod record;
mod reference;
mod report;
mod run;
mod soak;
mod stages;
mod stats;

use super::{args, build, motion, program::assets, scene};

pub use run::run;
pub use soak::{Counting, soak};

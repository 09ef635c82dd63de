//! What the integration tests share: apps without a window, pictures compared by FLIP or with formulas.
#![allow(dead_code, unreachable_pub, reason = "every test uses its own part")]

pub mod ball;
pub mod cornell;
pub mod example;
pub mod flip;
pub mod front;
#[path = "../../examples/common/headless.rs"]
pub mod headless;
pub mod integral;
pub mod linear;
pub mod shading;

use std::path::{Path, PathBuf};

/// The repository's `assets` folder.
pub fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets")
}

/// Where tests may leave pictures and reports for a person to look at.
pub fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

//! The WGSL modules of Farlight, embedded in the program.
//!
//! A module's path is `shaders/<plugin>/<concept>.wgsl`, its import path
//! `farlight::<plugin>::<concept>`; the same names stand in `plugins/<plugin>/src`. A *pure* module
//! imports nothing of the engine: tests translate it for every graphics interface, and it runs in
//! compute shaders without an engine (feature `compose`).

#[cfg(feature = "compose")]
mod compose;

#[cfg(feature = "compose")]
pub use compose::{ComposeError, Definition, compose, compose_source};
/// The version of what [`compose`] gives.
#[cfg(feature = "compose")]
pub use naga;

/// One file.
#[derive(Clone, Copy, Debug)]
pub struct Module {
    /// Path below this crate's folder, `btf/layout.wgsl`.
    pub path: &'static str,
    /// Its text.
    pub source: &'static str,
    /// Whether it imports nothing of the engine.
    pub pure: bool,
}

macro_rules! modules {
    ($($kind:ident $path:literal),* $(,)?) => {
        [$(Module {
            path: $path,
            source: include_str!($path),
            pure: modules!(@ $kind),
        }),*]
    };
    (@ pure) => { true };
    (@ engine) => { false };
}

/// Every module; one stands after those that it imports.
pub const MODULES: &[Module] = &modules![
    pure "math.wgsl",
    pure "baked/blend.wgsl",
    pure "btf/layout.wgsl",
    pure "btf/tables.wgsl",
    pure "btf/angles.wgsl",
    pure "btf/colour.wgsl",
    pure "btf/evaluate.wgsl",
    pure "btf/queries.wgsl",
    pure "btf/evaluate_points.wgsl",
    pure "btf/evaluate_lights.wgsl",
    pure "ibl/accumulate.wgsl",
    pure "ibl/dots.wgsl",
    pure "ibl/present.wgsl",
    pure "panel/quad.wgsl",
    pure "xr/show.wgsl",
    engine "lighting/surface.wgsl",
    engine "lighting/lights.wgsl",
    engine "lighting/shadow_maps.wgsl",
    engine "lighting/standard.wgsl",
    engine "lighting/frame.wgsl",
    engine "lighting/indirect.wgsl",
    engine "btf/bindings.wgsl",
    engine "btf/taps.wgsl",
    engine "btf/material.wgsl",
];

//! `farlight bake --out` as a user runs it: what lies in the folder, whatever happens on the way.

mod agreement;
mod errors;
mod folder;
mod incremental;
#[cfg(unix)]
mod interrupted;
#[path = "../support/mod.rs"]
mod support;
mod watched;

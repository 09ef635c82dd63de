//! Indirect light and environment light in one scene: the environment is counted once, and what one
//! plugin makes does not keep the other busy.

mod counted_once;
#[path = "../ibl/stage.rs"]
#[expect(dead_code, reason = "the stage has more than this test uses")]
mod stage;
#[path = "../support/mod.rs"]
mod support;
mod terrace;

//! What runs a solver sees of it, and of its failure.

use std::any::Any;

use super::{LightingUpdate, Session, SessionChange, SnapshotId};

/// What solves light: a [`Session`], or a stand-in.
pub trait Solve: Send + 'static {
    /// Takes changes over.
    fn apply(&mut self, snapshot: SnapshotId, changes: Vec<SessionChange>);
    /// One bounded piece of work.
    fn step(&mut self) -> Option<LightingUpdate>;
    /// Whether [`step`](Self::step) has nothing to do until something changes.
    fn is_idle(&self) -> bool;
}

impl Solve for Session {
    fn apply(&mut self, snapshot: SnapshotId, changes: Vec<SessionChange>) {
        Self::apply(self, snapshot, changes);
    }

    fn step(&mut self) -> Option<LightingUpdate> {
        Self::step(self)
    }

    fn is_idle(&self) -> bool {
        Self::is_idle(self)
    }
}

/// What a panic that was caught says.
#[must_use]
pub fn panic_message(panic: &(dyn Any + Send)) -> &str {
    panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("a panic without a message")
}

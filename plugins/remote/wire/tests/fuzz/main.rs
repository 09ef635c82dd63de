//! Every decoder against damaged, random and lying input: no panic, memory within bounds, and what
//! is accepted stays the same when it is sent on.
//!
//! A brief run of every target is part of the tests; `cargo xtask fuzz` runs longer. The messages
//! that are not public have their targets beside them, in `src/message/fuzz.rs`.

mod memory;
mod mutate;
mod sessions;
mod values;

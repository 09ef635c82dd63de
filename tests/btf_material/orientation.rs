//! The right way round.

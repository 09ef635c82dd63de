//! Farlight.

//! Files, buffers and devices.

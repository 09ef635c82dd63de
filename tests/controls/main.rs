//! Input actions: what devices say acts in the same frame, on every device.

mod desk;
mod hand;
mod in_hand;
mod player;

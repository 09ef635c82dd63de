//! Input actions: what devices say acts in the same frame, on every device.

mod desk;
mod files;
mod finger;
mod hand;
mod in_hand;
mod pads;
mod player;
mod replay;

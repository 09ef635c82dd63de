//! A bright room, a dark room and a doorway between them. The lamp in the bright room moves, and the
//! dark room follows: its light is indirect, solved in a background thread and streamed into a
//! lightmap. The ball that passes through the doorway is lit by probes.
//!
//! `cargo run --example local_room` opens a window. Keys: I indirect light on and off, L lightmap
//! alone, Space stops the lamp, B stops the ball, + and - change the lamp's speed, mouse drag or
//! arrow keys turn the camera, the wheel comes closer, H hides the text.
//!
//! `--headless --out DIR` measures and writes pictures without a window, `--soak SECONDS` watches
//! memory; `--help` says more. What is in the room is in `examples/common/room`.

#[path = "../common/room/mod.rs"]
mod room;

use std::{process::ExitCode, sync::Arc};

use farlight::gi::{GiSettings, ThreadBackend};

#[global_allocator]
static ALLOCATOR: room::Counting = room::Counting;

fn main() -> ExitCode {
    room::Program {
        name: "local_room",
        title: "Farlight: local room",
        about: "Direct light is Bevy's own. Indirect light is solved in a background thread and streamed into a\n\
                lightmap (the rooms) and probes (the moving ball).",
        takes_server: false,
        light: |_| {
            Ok(Arc::new(|settings: &GiSettings| Box::new(ThreadBackend::new(settings.session()))))
        },
    }
    .run()
}

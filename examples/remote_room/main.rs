//! The same room as `local_room`, lit from another machine: a bright room, a dark room, a doorway
//! between them, and a lamp that moves. The scene goes to a lighting server; lightmap and probes come
//! back. The game draws direct light, and does not solve anything.
//!
//! Start a server, here or elsewhere, and give its invitation to the game:
//!
//! ```text
//! cargo run -p farlight_cli -- serve --invite-file light.invite
//! cargo run --example remote_room -- --server-file light.invite
//! ```
//!
//! `cargo xtask demo` does both. Keys are on screen: I indirect light on and off, L lightmap alone,
//! Space stops the lamp, B stops the ball, + and - change the lamp's speed, mouse drag or arrow keys
//! turn the camera, the wheel comes closer, H hides the text. Stop the server and start it again: the
//! room keeps its light, and goes on when the server is back.
//!
//! `--headless --out DIR` measures and writes pictures without a window, `--soak SECONDS` watches
//! memory; `--help` says more. What is in the room is in `examples/common/room`; only the
//! measurement there knows a solver, for the references that it compares with afterwards.

#[path = "../common/room/mod.rs"]
mod room;

use std::{process::ExitCode, sync::Arc};

use farlight::{
    gi::BackendFactory,
    remote::{RemoteBackend, RemoteSettings},
};
use room::args::{Args, Server};

#[global_allocator]
static ALLOCATOR: room::Counting = room::Counting;

fn main() -> ExitCode {
    room::Program {
        name: "remote_room",
        title: "Farlight: remote room",
        about: "Direct light is Bevy's own. Indirect light is solved by a lighting server and streamed into a\n\
                lightmap (the rooms) and probes (the moving ball).",
        takes_server: true,
        light,
    }
    .run()
}

fn light(args: &Args) -> Result<BackendFactory, String> {
    let settings = match &args.server {
        Some(Server::Invitation(text)) => {
            RemoteSettings::from_invitation(text).map_err(|e| format!("--server: {e}"))?
        }
        Some(Server::File(path)) => RemoteSettings::from_invite_file(path),
        None => return Err("no server".into()),
    };
    Ok(Arc::new(RemoteBackend::factory(settings.with_name("remote_room"))))
}

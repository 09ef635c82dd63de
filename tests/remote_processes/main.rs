//! Two real processes over loopback: `farlight serve`, and the network backend of a game.

#![allow(unreachable_pub, reason = "the modules read like a library's")]

mod game;
mod room;
mod server;

use std::{path::PathBuf, time::Instant};

use game::{Game, mean_of_one_candela};
use room::{lamp, room};
use server::ServerProcess;

/// An empty folder for a server.
fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("remote_processes").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

#[test]
fn light_of_another_process_is_that_of_this_one() {
    let expected = mean_of_one_candela();
    let server = ServerProcess::start(&folder("light"), 0);
    let mut game = Game::join(&server.invitation());
    game.submit(room(1.0));
    game.wait_for_light(expected, "the first light");
    for intensity in [3.0, 0.5] {
        game.submit(vec![lamp(intensity)]);
        game.wait_for_light(expected * intensity, "light after a change");
    }
    assert_eq!(game.reconnects(), 0);
}

#[test]
fn a_killed_server_is_replaced_twenty_times() {
    let expected = mean_of_one_candela();
    let folder = folder("killed");
    let mut server = ServerProcess::start(&folder, 0);
    let invitation = server.invitation();
    let port = invitation.split(['/', ':']).nth(4).and_then(|port| port.parse().ok()).unwrap();
    let mut game = Game::join(&invitation);
    game.submit(room(1.0));
    game.wait_for_light(expected, "the first light");
    for round in 1..=20_u32 {
        if round % 2 == 0 {
            // This one dies at work.
            game.submit(vec![lamp(0.1)]);
        }
        server.kill();
        let killed = Instant::now();
        // A change that the dead server can't have seen.
        let intensity = 1.0 + (round % 4) as f32;
        game.submit(vec![lamp(intensity)]);
        server = ServerProcess::start(&folder, port);
        assert_eq!(server.invitation(), invitation, "it keeps its identity");
        game.wait_for_light(expected * intensity, &format!("server {round}"));
        println!("server {round}: right light {:.0?} after the kill", killed.elapsed());
        assert!(game.reconnects() >= u64::from(round));
    }
}

#[test]
fn wrong_secrets_are_refused_with_words_and_others_go_on() {
    let expected = mean_of_one_candela();
    let mut server = ServerProcess::start(&folder("secrets"), 0);
    let invitation = server.invitation();
    let mut honest = Game::join(&invitation);
    honest.submit(room(1.0));
    honest.wait_for_light(expected, "light before the others come");

    let (place, secrets) = invitation.split_once('#').unwrap();
    let (token, authority) = secrets.split_once('.').unwrap();
    let other = |hex: &str| hex.replace(|c: char| c != '0', "0").replacen('0', "1", 1);

    let mut stranger = Game::join(&format!("{place}#{}.{authority}", other(token)));
    stranger.submit(room(1.0));
    let reason = stranger.wait_for_failure();
    assert!(reason.contains("token"), "{reason}");
    let mut misled = Game::join(&format!("{place}#{token}.{}", other(authority)));
    misled.submit(room(1.0));
    let reason = misled.wait_for_failure();
    assert!(reason.contains("authority"), "{reason}");

    assert!(server.is_running());
    assert!(server.log().contains("token"), "the server says it too:\n{}", server.log());
    honest.submit(vec![lamp(2.0)]);
    honest.wait_for_light(expected * 2.0, "light after the others came");
    assert_eq!(honest.reconnects(), 0);
}

//! The plugin in a game, and a server with its threads, over the simulated network in real time.

use std::time::{Duration, Instant};

use bevy::{
    asset::RenderAssetUsages,
    pbr::Lightmap,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
    window::{PrimaryWindow, WindowResolution},
};
use farlight::{
    gi::{ExtractedScene, GiLightmaps},
    prelude::*,
};
use farlight_server::Server;
use farlight_wire::{
    Channel,
    simulated::{LinkConditions, Network},
};

use crate::{
    clock::{Clock, TOKEN},
    game::Game,
    stage::MS,
};

/// Mean of all texels of the game's lightmaps.
fn brightness(game: &Game) -> f32 {
    let lightmaps = game.app.world().resource::<GiLightmaps>();
    let mut sum = 0.0;
    for (_, placement) in lightmaps.placements() {
        let rect = placement.rect;
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                sum += lightmaps.texel(placement.page, x, y).unwrap().element_sum();
            }
        }
    }
    sum
}

fn lightmaps(game: &Game) -> usize {
    let world = game.app.world();
    game.walls.iter().filter(|wall| world.get::<Lightmap>(**wall).is_some()).count()
}

fn link(game: &Game) -> &LinkStatus {
    game.status().link.as_ref().expect("a backend on another machine")
}

/// A game whose light comes over a network, and the server.
fn connected(network: &Network) -> (Clock, Server, Game) {
    let clock = Clock::new(network);
    let server = clock.serve();
    let connector = network.connector();
    let game = Game::new(GiPlugin::with_backend(move |gi| {
        let (connector, remote) = (Box::new(connector.clone()), RemoteSettings::default());
        Box::new(RemoteBackend::new(connector, TOKEN, &remote, gi.session()))
    }));
    (clock, server, game)
}

#[test]
fn a_game_keeps_its_light_while_the_server_is_away() {
    let network = Network::new(1);
    network.set_conditions(LinkConditions { delay: 2 * MS, ..Default::default() });
    let clock = Clock::new(&network);
    let server = clock.serve();
    let connector = network.connector();
    let remote = RemoteSettings::default().with_name("a test");
    let mut game = Game::new(GiPlugin::with_backend(move |gi| {
        let connector = Box::new(connector.clone());
        Box::new(RemoteBackend::new(connector, TOKEN, &remote, gi.session()))
    }));

    game.settle();
    assert_eq!(lightmaps(&game), 6);
    let first = brightness(&game);
    assert!(first > 0.0);
    let shown = link(&game);
    assert_eq!(shown.state, LinkState::Connected);
    assert!(shown.sent_bytes > 0 && shown.received_bytes > shown.update_bytes, "{shown:?}");
    assert!(shown.updates > 0 && shown.bytes_per_update().unwrap() > 0.0, "{shown:?}");
    assert_eq!((shown.snapshot_lag, shown.unsent_blob_bytes, shown.reconnects), (0, 0, 0));
    assert_eq!(server.sessions().len(), 1);
    let timings = &game.status().timings;
    for (stage, window) in [
        ("send", &timings.send),
        ("solve", &timings.solve),
        ("encode", &timings.encode),
        ("transfer", &timings.transfer),
        ("decode", &timings.decode),
    ] {
        assert!(!window.is_empty(), "{stage}");
    }
    // The network's clock ticks once a millisecond, or more rarely on a busy machine, so little can be
    // said about how long it should be.
    assert!(timings.transfer.stats().max > Duration::ZERO, "two delays of 2 ms");

    server.stop();
    game.until("no server", |game| matches!(game.status().state, GiState::Disconnected { .. }));
    let LinkState::Reconnecting { why, .. } = &link(&game).state else {
        panic!("{:?}", link(&game))
    };
    assert!(!why.is_empty());
    game.move_lamp(Vec3::new(3.0, 1.0, 1.0));
    for _ in 0..20 {
        game.app.update();
        std::thread::sleep(MS);
    }
    assert_eq!(lightmaps(&game), 6);
    assert_eq!(brightness(&game), first, "the light stays");

    let server = clock.serve();
    game.settle();
    assert_eq!(link(&game).state, LinkState::Connected);
    assert_eq!(link(&game).reconnects, 1);
    assert_ne!(brightness(&game), first, "the lamp was moved");
    assert_eq!(lightmaps(&game), 6);

    // The end of the game is a goodbye: the server forgets it at once.
    drop(game);
    let patience = Instant::now() + Duration::from_secs(20);
    while !server.sessions().is_empty() {
        assert!(Instant::now() < patience, "{server:?}");
        std::thread::sleep(MS);
    }
}

#[test]
fn what_is_wrong_with_an_invitation_is_a_state() {
    let settings = RemoteSettings::default();
    let mut game = Game::new(GiPlugin::with_backend(RemoteBackend::factory(settings)));
    game.until("a failure", |game| matches!(game.status().state, GiState::Failed { .. }));
    let GiState::Failed { reason } = &game.status().state else { unreachable!() };
    assert!(reason.contains("invite"), "{reason}");

    let file = std::env::temp_dir().join("farlight-no-such-invitation");
    let settings = RemoteSettings::from_invite_file(&file);
    let mut game = Game::new(GiPlugin::with_backend(RemoteBackend::factory(settings)));
    game.until("waiting", |game| matches!(game.status().state, GiState::Disconnected { .. }));
    let GiState::Disconnected { reason } = &game.status().state else { unreachable!() };
    assert!(reason.contains("farlight-no-such-invitation"), "{reason}");
}

#[test]
fn a_new_window_size_brings_all_light_again() {
    let network = Network::new(1);
    let (_clock, server, mut game) = connected(&network);
    let resolution = WindowResolution::new(320, 180);
    let window =
        game.app.world_mut().spawn((Window { resolution, ..default() }, PrimaryWindow)).id();
    game.settle();
    let rest = |game: &mut Game| {
        let end = Instant::now() + 500 * MS;
        game.until("half a second", |_| Instant::now() > end);
        game.status().updates
    };
    rest(&mut game);
    let (before, blobs) = (rest(&mut game), network.counters().to_server(Channel::Bulk));
    assert_eq!(rest(&mut game), before, "the scene is still");

    game.app.world_mut().get_mut::<Window>(window).unwrap().resolution.set(640.0, 360.0);
    game.until("light", |game| game.status().updates > before);
    game.settle();
    assert_eq!(network.counters().to_server(Channel::Bulk), blobs, "only light is sent");
    drop((game, server));
}

#[test]
fn derived_lights_that_never_rest_send_nothing() {
    let network = Network::new(1);
    let (_clock, server, mut game) = connected(&network);
    let visible = (Visibility::Visible, InheritedVisibility::VISIBLE);
    let lights = [(); 5].map(|()| {
        game.app.world_mut().spawn((DirectionalLight::default(), DerivedLight, visible)).id()
    });
    let mut frames = 0.0_f32;
    let mut dance = |game: &mut Game, time: Duration| {
        let end = Instant::now() + time;
        while Instant::now() < end {
            frames += 1.0;
            for light in lights {
                let world = game.app.world_mut();
                world.get_mut::<DirectionalLight>(light).unwrap().illuminance = frames;
                world.get_mut::<Transform>(light).unwrap().rotate_y(0.1);
            }
            game.app.update();
            std::thread::sleep(MS);
        }
    };
    game.settle();
    dance(&mut game, 500 * MS);
    let told = |game: &Game| (game.status().submitted, game.status().updates);
    let counts = || {
        let counters = network.counters();
        let both = |channel| (counters.to_server(channel), counters.to_client(channel));
        (both(Channel::Bulk), both(Channel::Latest))
    };
    let pings = || network.counters().to_server(Channel::Control).messages;
    let (before, sent, control) = (told(&game), counts(), pings());
    let start = Instant::now();
    dance(&mut game, Duration::from_secs(1));
    assert_eq!((told(&game), counts()), (before, sent));
    // One in two seconds, and what belongs to the beginning and the end.
    let most = 3 + start.elapsed().as_secs() / 2;
    assert!(pings() - control <= most, "{} messages", pings() - control);
    drop((game, server));
}

#[test]
fn a_sky_that_turns_sends_no_image_again() {
    let network = Network::new(1);
    let (_clock, server, mut game) = connected(&network);
    let (width, height) = (64, 32);
    let texel = |i: u32| [(i % 7) as f32, (i % 13) as f32, (i % 29) as f32, 1.0];
    let image = Image::new(
        Extent3d { width, height, depth_or_array_layers: 1 },
        TextureDimension::D2,
        (0..width * height).flat_map(texel).flat_map(f32::to_ne_bytes).collect(),
        TextureFormat::Rgba32Float,
        RenderAssetUsages::MAIN_WORLD,
    );
    let image = game.app.world_mut().resource_mut::<Assets<Image>>().add(image);
    let turn = |game: &mut Game, turn: f32, direct| {
        let (image, rotation) = (image.clone(), Quat::from_rotation_y(turn));
        let sky = SkyRadiance::Equirect { image, rotation, brightness: 1.0 + turn };
        let mut source = game.app.world_mut().resource_mut::<SkySource>();
        SkySource::claim(&mut source, "a test", sky, direct).unwrap();
    };
    // The floor alone, so that the sky is seen.
    for wall in game.walls.split_off(1) {
        game.app.world_mut().despawn(wall);
    }
    turn(&mut game, 0.0, DirectSky::Solved);
    game.until("the sky", |game| {
        !game.app.world().resource::<ExtractedScene>().scene.sky.is_black()
    });
    game.settle();
    let whole = brightness(&game);
    let bulk = || network.counters().to_server(Channel::Bulk);
    let (sent, snapshot) = (bulk(), game.status().submitted);
    turn(&mut game, 0.5, DirectSky::Solved);
    game.settle();
    assert!(game.status().submitted > snapshot && brightness(&game) > 1.1 * whole);
    turn(&mut game, 0.5, DirectSky::ByLights);
    game.settle();
    // One plane: nothing comes back from anywhere, but from the lamp nothing ever did.
    assert_eq!(brightness(&game), 0.0);
    assert_eq!(bulk(), sent);
    drop((game, server));
}

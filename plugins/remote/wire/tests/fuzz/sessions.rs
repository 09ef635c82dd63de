//! Fuzz targets of the sessions: a conversation that was fair so far, then messages that are not.

use std::{sync::Arc, time::Duration};

use farlight_gi_solver::{
    SceneChange,
    atlas::{PageId, TexelRect},
    scene::{
        DirectSky, Instance, InstanceId, Light, LightId, LightKind, Material, MaterialId, Mesh,
        MeshId, Sky, TextureId,
    },
    session::{
        GridId, GridUpdate, LightingUpdate, Placement, ProbeGrid, Quality, Session, SessionChange,
        SessionSettings, SnapshotId, Tile,
    },
    sh::ShRgb,
};
use farlight_wire::{
    Blob, BlobStore, Channel, ClientConfig, ClientHello, ClientSession, Limits, ServerConfig,
    ServerSession, Token, View,
};
use glam::{Affine3A, Quat, UVec3, Vec3};

use crate::{
    memory, mutate,
    mutate::Random,
    values::{mesh, sky, texture},
};

/// Small, so that it shows when they are not kept.
fn limits() -> Limits {
    Limits {
        blob_bytes: 1 << 20,
        session_blob_bytes: 2 << 20,
        objects: 1000,
        texels: 1 << 16,
        probes: 1 << 12,
        ..Limits::default()
    }
}

/// Memory that a message of any size may take: a blob with its pieces and buffers, light with its
/// learned probabilities, a map that grows.
const MEMORY: usize = 6 << 20;
/// And for every byte of it.
const MEMORY_PER_BYTE: usize = 1024;

fn settings() -> SessionSettings {
    SessionSettings { page_size: 64, max_pages: 2, ..Default::default() }
}

fn client() -> ClientSession {
    ClientSession::new(ClientConfig {
        name: "fuzz".into(),
        token: Token([1; 16]),
        settings: settings(),
        limits: limits(),
    })
}

fn server() -> ServerSession {
    ServerSession::new(Token([9; 16]), settings(), ServerConfig { limits: limits() })
}

/// A scene with objects of every kind.
fn scene() -> Vec<SessionChange> {
    let (Blob::Mesh(mesh), Blob::Texture(texture), Blob::Sky(image)) =
        (mesh(3), texture(9, 5), sky())
    else {
        unreachable!()
    };
    let material =
        Material { base_color_texture: Some(TextureId(1)), metallic: 0.5, ..Default::default() };
    let instance = Instance {
        mesh: MeshId(1),
        material: MaterialId(1),
        transform: Affine3A::from_translation(Vec3::ONE),
    };
    let light = |kind| Light {
        kind,
        position: Vec3::Y,
        direction: Vec3::NEG_Y,
        intensity: Vec3::splat(30.0),
        range: f32::INFINITY,
    };
    let spot = LightKind::Spot { inner_angle: 0.2, outer_angle: 0.5 };
    let sky = Sky::Image { image, rotation: Quat::IDENTITY, scale: 2.0 };
    let grid = ProbeGrid { transform: Affine3A::IDENTITY, resolution: UVec3::new(3, 2, 2) };
    let scene = [
        SceneChange::SetMesh(MeshId(1), mesh.clone()),
        SceneChange::SetMesh(MeshId(2), mesh),
        SceneChange::SetTexture(TextureId(1), texture),
        SceneChange::SetMaterial(MaterialId(1), material),
        SceneChange::SetInstance(InstanceId(1), instance),
        SceneChange::SetLight(LightId(1), light(LightKind::Point)),
        SceneChange::SetLight(LightId(2), light(spot)),
        SceneChange::SetSky(sky),
        SceneChange::SetDirectSky(DirectSky::LeftOut),
    ];
    let mut changes: Vec<SessionChange> = scene.into_iter().map(SessionChange::Scene).collect();
    changes.push(SessionChange::AddReceiver(InstanceId(1)));
    changes.push(SessionChange::SetGrid(GridId(1), grid));
    changes
}

/// Light as a solver would publish it.
fn update(snapshot: u64) -> LightingUpdate {
    let rect = TexelRect { x: 0, y: 0, width: 16, height: 8 };
    let probe = ShRgb(std::array::from_fn(|i| Vec3::splat(1.0 / (1.0 + i as f32))));
    let value = |i: u64| Vec3::new(1.0, 0.8, 0.6) * (1.0 + (i * (snapshot % 100)) as f32 * 0.01);
    LightingUpdate {
        snapshot: SnapshotId(snapshot),
        placements: vec![Placement { instance: InstanceId(1), page: PageId(0), rect }],
        refused: vec![(InstanceId(2), Arc::from("no UVs"))],
        tiles: vec![Tile { page: PageId(0), rect, texels: (0..128).map(value).collect() }],
        grids: vec![GridUpdate {
            grid: GridId(1),
            resolution: UVec3::new(3, 2, 2),
            probes: vec![probe; 12],
        }],
        quality: Quality { relative_error: 0.03, rays_per_texel: 32, converged: snapshot > 2 },
    }
}

/// Messages as they arrive.
type Messages = Vec<(Channel, Vec<u8>)>;

/// A fair conversation: what the client sent after its greeting, and what the server sent.
fn conversation() -> (Messages, Messages) {
    let (mut client, mut server, store) = (client(), server(), BlobStore::new(1 << 20));
    let (mut from_client, mut from_server) = (Vec::new(), Vec::new());
    client.submit(Duration::ZERO, SnapshotId(1), scene());
    client.connected(Duration::ZERO);
    client.poll_transmit(Duration::ZERO).expect("a greeting");
    server.attach(Duration::ZERO, false);
    for round in 0..60_u64 {
        let now = Duration::from_millis(50 * round);
        match round {
            10 => client.set_view(View {
                id: 1,
                predicted: vec![Default::default()],
                ..View::default()
            }),
            20 => client.resync(),
            25 => {
                let gone = [
                    SessionChange::RemoveReceiver(InstanceId(1)),
                    SessionChange::Scene(SceneChange::RemoveInstance(InstanceId(1))),
                    SessionChange::Scene(SceneChange::RemoveMesh(MeshId(2))),
                    SessionChange::Scene(SceneChange::RemoveTexture(TextureId(1))),
                    SessionChange::RemoveGrid(GridId(1)),
                    SessionChange::Scene(SceneChange::SetSky(Sky::Constant(Vec3::ONE))),
                    SessionChange::Scene(SceneChange::SetDirectSky(DirectSky::Included)),
                ];
                client.submit(now, SnapshotId(2), gone.into());
            }
            30 => server.notice("hello"),
            _ => {}
        }
        while let Some(transmit) = client.poll_transmit(now) {
            client.sent(now, transmit.id);
            server.receive(now, transmit.channel, &transmit.message, &store).expect("fair");
            from_client.push((transmit.channel, transmit.message));
        }
        if let Some((snapshot, _)) = server.take_changes() {
            server.publish(now, &update(snapshot.0), Duration::from_millis(3));
        }
        while let Some(transmit) = server.poll_transmit(now) {
            client.receive(now, transmit.channel, &transmit.message).expect("fair");
            from_server.push((transmit.channel, transmit.message));
        }
    }
    let kinds = |messages: &Messages, channel| messages.iter().any(|m| m.0 == channel);
    assert!(kinds(&from_client, Channel::Bulk) && kinds(&from_server, Channel::Latest));
    (from_client, from_server)
}

/// Greetings of clients, fresh and resuming.
pub(crate) fn greetings() -> Vec<Vec<u8>> {
    let mut client = client();
    client.connected(Duration::ZERO);
    let fresh = client.poll_transmit(Duration::ZERO).expect("a greeting").message;
    let mut server = server();
    server.attach(Duration::ZERO, false);
    let welcome = server.poll_transmit(Duration::ZERO).expect("a welcome");
    client.receive(Duration::ZERO, welcome.channel, &welcome.message).expect("fair");
    client.disconnected();
    client.connected(Duration::ZERO);
    let resuming = client.poll_transmit(Duration::ZERO).expect("a greeting").message;
    let limits = limits();
    let hello = ClientHello::read(Channel::Control, &resuming, &limits).expect("fair");
    assert_eq!(hello.resume, Some(server.key()));
    vec![fresh, resuming]
}

/// Messages with their channel's tag in front, so that it is changed too.
fn corpus(messages: &Messages) -> Vec<Vec<u8>> {
    let tagged = |(channel, message): &(Channel, Vec<u8>)| {
        let mut bytes = vec![channel.tag()];
        bytes.extend_from_slice(message);
        bytes
    };
    messages.iter().map(tagged).collect()
}

/// Fair messages up to some point, the unfair one, then some of the rest, now and then twice, late
/// or not at all.
fn script(random: &mut Random, fair: &Messages, input: &[u8]) -> Messages {
    let mut messages = fair.clone();
    messages.truncate(random.below(fair.len() + 1));
    if let Some((tag, message)) = input.split_first() {
        let channel = Channel::from_tag(*tag).unwrap_or(Channel::Control);
        messages.push((channel, message.to_vec()));
    }
    messages.extend(fair.iter().skip(random.below(fair.len())).cloned());
    if random.once_in(3) {
        for _ in 0..random.below(4) {
            let (a, b) = (random.below(messages.len()), random.below(messages.len()));
            match random.below(3) {
                0 => messages.swap(a, b),
                1 => drop(messages.remove(a)),
                _ => messages.push(messages[a].clone()),
            }
            if messages.is_empty() {
                break;
            }
        }
    }
    messages
}

fn check_memory(message: &[u8], peak: usize) {
    let most = MEMORY + MEMORY_PER_BYTE * message.len();
    assert!(peak <= most, "{peak} bytes for {}", message.len());
}

#[test]
fn fuzz_server_session() {
    let (fair, _) = conversation();
    mutate::fuzz("server_session", 1_500, corpus(&fair), |random, input| {
        let (mut server, store) = (server(), BlobStore::new(1 << 20));
        server.attach(Duration::ZERO, random.once_in(2));
        let mut accepted = true;
        for (i, (channel, message)) in script(random, &fair, input).into_iter().enumerate() {
            let now = Duration::from_millis(30 * i as u64);
            let receive = || server.receive(now, channel, &message, &store);
            let (result, peak) = memory::peak(receive);
            check_memory(&message, peak);
            if random.once_in(3)
                && let Some((snapshot, _)) = server.take_changes()
            {
                server.publish(now, &update(snapshot.0), Duration::ZERO);
            }
            while server.poll_transmit(now).is_some() {}
            while server.poll_cancel().is_some() {}
            while server.poll_event().is_some() {}
            let size = server.scene_size();
            if let Err(error) = result {
                // It says why, and the session can be let go of.
                assert!(!error.to_string().is_empty());
                accepted = false;
                break;
            }
            assert!(size.objects <= limits().objects, "{size:?}");
            assert!(size.blob_bytes <= limits().session_blob_bytes, "{size:?}");
            if random.once_in(50) {
                server.detach();
                server.attach(now, true);
            }
        }
        server.detach();
        accepted
    });
}

#[test]
fn fuzz_client_session() {
    let (_, fair) = conversation();
    let changes = scene();
    mutate::fuzz("client_session", 1_500, corpus(&fair), |random, input| {
        let mut client = client();
        client.submit(Duration::ZERO, SnapshotId(1), changes.clone());
        client.connected(Duration::ZERO);
        let mut accepted = true;
        for (i, (channel, message)) in script(random, &fair, input).into_iter().enumerate() {
            let now = Duration::from_millis(30 * i as u64);
            let (result, peak) = memory::peak(|| client.receive(now, channel, &message));
            check_memory(&message, peak);
            let mut polls = 0;
            while let Some(transmit) = client.poll_transmit(now) {
                client.sent(now, transmit.id);
                polls += 1;
                assert!(polls < 3000, "it never falls silent");
            }
            while client.poll_event().is_some() {}
            let _ = client.state();
            if let Err(error) = result {
                assert!(!error.to_string().is_empty());
                accepted = false;
                break;
            }
            if random.once_in(50) {
                client.disconnected();
                client.connected(now);
            }
        }
        client.disconnected();
        accepted
    });
}

/// What a server session lets through must not stop a solver, however odd it is, and the light that
/// comes of it can be encoded.
#[test]
fn fuzz_solver() {
    let (fair, _) = conversation();
    let settings = small_solver();
    let mut tiles = 0;
    mutate::fuzz("solver", 60, corpus(&fair), |random, input| {
        let (mut server, store) = (server(), BlobStore::new(1 << 20));
        let mut solver = Session::new(settings.clone());
        server.attach(Duration::ZERO, false);
        for (i, (channel, message)) in script(random, &fair, input).into_iter().enumerate() {
            let now = Duration::from_millis(30 * i as u64);
            if server.receive(now, channel, &message, &store).is_err() {
                return false;
            }
            if let Some((snapshot, changes)) = server.take_changes() {
                solver.apply(snapshot, changes);
                for _ in 0..20 {
                    if let Some(update) = solver.step() {
                        tiles += update.tiles.len();
                        server.publish(now, &update, Duration::ZERO);
                    }
                }
            }
            while server.poll_transmit(now).is_some() {}
        }
        true
    });
    assert!(tiles > 0, "nothing was lit");
}

/// Meshes and images with odd numbers, as far as a client sends them, must not stop a solver.
#[test]
fn fuzz_odd_scene() {
    const ODD: [f32; 8] = [0.0, -0.0, 1e-40, 1e-20, 1e9, 1e20, 3e38, -3e38];
    let settings = small_solver();
    // A patch is an attribute, a vertex and a number.
    let patch = |what: u8, vertex: u8, number: f32| {
        let mut bytes = vec![what, vertex];
        bytes.extend_from_slice(&number.to_le_bytes());
        bytes
    };
    let mut corpus: Vec<Vec<u8>> = vec![Vec::new()];
    for (i, number) in ODD.into_iter().enumerate() {
        corpus.extend((0..4).map(|what| patch(what, 3 * i as u8, number)));
    }
    corpus.push(corpus.concat());
    let mut tiles = 0;
    mutate::fuzz("odd_scene", 60, corpus, |_, input| {
        let mut changes = scene();
        for change in &mut changes {
            match change {
                SessionChange::Scene(SceneChange::SetMesh(_, mesh)) => {
                    patch_mesh(Arc::make_mut(mesh), input);
                }
                SessionChange::Scene(SceneChange::SetSky(Sky::Image { image, .. })) => {
                    let texels = &mut Arc::make_mut(image).texels;
                    for patch in input.chunks_exact(6).filter(|patch| patch[0] & 4 != 0) {
                        let texel = usize::from(patch[1]) % texels.len();
                        texels[texel].x = number(patch);
                    }
                }
                _ => {}
            }
        }
        let (mut client, mut server, store) = (client(), server(), BlobStore::new(1 << 20));
        let mut solver = Session::new(settings.clone());
        client.submit(Duration::ZERO, SnapshotId(1), changes);
        client.connected(Duration::ZERO);
        client.poll_transmit(Duration::ZERO).expect("a greeting");
        server.attach(Duration::ZERO, false);
        for _ in 0..4 {
            while let Some(transmit) = client.poll_transmit(Duration::ZERO) {
                client.sent(Duration::ZERO, transmit.id);
                let receive =
                    server.receive(Duration::ZERO, transmit.channel, &transmit.message, &store);
                receive.expect("a client sends nothing that a server refuses");
            }
            if let Some((snapshot, changes)) = server.take_changes() {
                solver.apply(snapshot, changes);
            }
            while let Some(transmit) = server.poll_transmit(Duration::ZERO) {
                let receive = client.receive(Duration::ZERO, transmit.channel, &transmit.message);
                receive.expect("a server sends nothing that a client refuses");
            }
            for _ in 0..20 {
                if let Some(update) = solver.step() {
                    tiles += update.tiles.len();
                    server.publish(Duration::ZERO, &update, Duration::ZERO);
                }
            }
        }
        true
    });
    assert!(tiles > 0, "nothing was lit");
}

fn number(patch: &[u8]) -> f32 {
    f32::from_le_bytes([patch[2], patch[3], patch[4], patch[5]])
}

fn patch_mesh(mesh: &mut Mesh, input: &[u8]) {
    for patch in input.chunks_exact(6) {
        let vertex = usize::from(patch[1]) % mesh.positions.len();
        match patch[0] % 4 {
            0 => mesh.positions[vertex].y = number(patch),
            1 => mesh.normals[vertex].x = number(patch),
            2 => mesh.uv0[vertex].y = number(patch),
            _ => mesh.uv1[vertex].x = number(patch),
        }
    }
}

fn small_solver() -> SessionSettings {
    SessionSettings {
        page_size: 32,
        max_pages: 1,
        rays_per_texel: 64,
        rays_per_probe: 64,
        converged_paths: 64,
        threads: 1,
        ..Default::default()
    }
}

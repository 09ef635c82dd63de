//! Both sides of a session, without a network: what one has the other gets, whatever happens.

mod pair;

use std::sync::Arc;

use farlight_gi_solver::{
    Scene, SceneChange,
    sampling::Rng,
    scene::{
        DirectSky, Instance, InstanceId, Light, LightId, LightKind, Material, MaterialId, Mesh,
        MeshId, Sky, SkyImage, Texture, TextureId,
    },
    session::{LightingUpdate, Quality, SessionChange, SnapshotId},
};
use farlight_wire::{Channel, HalfGrid, HalfTile};
use glam::{Affine3A, Quat, Vec3, Vec4};

use pair::{EDGE, Pair, grid, update};

fn mesh(seed: u32) -> Arc<Mesh> {
    let positions = (0..100 + seed).map(|i| Vec3::new(i as f32, seed as f32, 0.5)).collect();
    let triangles = (0..98 + seed).map(|i| [i, i + 1, i + 2]).collect();
    Arc::new(Mesh { positions, triangles, ..Default::default() })
}

fn set_mesh(id: u64, seed: u32) -> SessionChange {
    SessionChange::Scene(SceneChange::SetMesh(MeshId(id), mesh(seed)))
}

fn set_instance(id: u64, mesh: u64, x: f32) -> SessionChange {
    let transform = Affine3A::from_translation(Vec3::new(x, 0.0, 0.0));
    let instance = Instance { mesh: MeshId(mesh), material: MaterialId(1), transform };
    SessionChange::Scene(SceneChange::SetInstance(InstanceId(id), instance))
}

fn set_light(id: u64, intensity: f32) -> SessionChange {
    let light = Light {
        kind: LightKind::Point,
        position: Vec3::Y,
        direction: Vec3::NEG_Y,
        intensity: Vec3::splat(intensity),
        range: f32::INFINITY,
    };
    SessionChange::Scene(SceneChange::SetLight(LightId(id), light))
}

/// Whether two scenes are equal, meshes and images by content.
fn assert_same(solver: &Scene, game: &Scene) {
    assert_eq!(solver.instances, game.instances);
    assert_eq!(solver.lights, game.lights);
    assert_eq!(solver.materials, game.materials);
    assert_eq!(solver.meshes, game.meshes);
    assert_eq!(solver.textures, game.textures);
    assert_eq!((&solver.sky, solver.direct_sky), (&game.sky, game.direct_sky));
}

#[test]
fn a_scene_arrives_whole() {
    let mut pair = Pair::new();
    let texture =
        Arc::new(Texture { width: 2, height: 1, texels: vec![[1, 2, 3, 4]; 2], srgb: true });
    let image = Arc::new(SkyImage { width: 2, height: 1, texels: vec![Vec3::ONE, Vec3::X] });
    let material = Material { base_color_texture: Some(TextureId(1)), ..Default::default() };
    let changes = vec![
        SessionChange::Scene(SceneChange::SetTexture(TextureId(1), texture)),
        SessionChange::Scene(SceneChange::SetMaterial(MaterialId(1), material)),
        set_mesh(1, 0),
        set_instance(1, 1, 2.0),
        SessionChange::AddReceiver(InstanceId(1)),
        set_light(1, 5.0),
        SessionChange::Scene(SceneChange::SetSky(Sky::Image {
            image,
            rotation: Quat::IDENTITY,
            scale: 2.0,
        })),
        SessionChange::Scene(SceneChange::SetDirectSky(DirectSky::LeftOut)),
    ];
    let mut game = Scene::default();
    for change in &changes {
        if let SessionChange::Scene(change) = change {
            game.apply(change.clone());
        }
    }
    pair.client.submit(pair.now, SnapshotId(1), changes);
    pair.connect(true);
    pair.settle();
    assert_same(&pair.solver, &game);
    assert!(matches!(pair.receivers[..], [SessionChange::AddReceiver(InstanceId(1))]));
    let state = pair.client.state();
    assert!(state.in_sync && state.acknowledged == SnapshotId(1), "{state:?}");
}

/// What the server has is not sent again: no blob ever, no object after a resumption.
#[test]
fn only_differences_are_sent() {
    let mut pair = Pair::new();
    pair.client.submit(
        pair.now,
        SnapshotId(1),
        vec![set_mesh(1, 0), set_instance(1, 1, 0.0), set_light(1, 1.0)],
    );
    pair.connect(true);
    pair.settle();
    assert!(pair.sent[Channel::Bulk.tag() as usize - 1] > 0);

    // The same mesh under another name, while the line is cut.
    pair.cut();
    pair.client.submit(pair.now, SnapshotId(2), vec![set_mesh(2, 0), set_light(1, 2.0)]);
    pair.sent = [0; 3];
    pair.connect(true);
    pair.settle();
    assert_eq!(pair.sent[Channel::Bulk.tag() as usize - 1], 0, "the server has the content");
    assert!(pair.sent[0] < 300, "{:?}", pair.sent);
    assert_eq!(pair.solver.lights[&LightId(1)].intensity.x, 2.0);
    assert_eq!(pair.solver.meshes.len(), 2);

    // A server that knows nothing gets everything.
    pair.connect(false);
    pair.settle();
    assert_eq!(pair.solver.meshes.len(), 2);
    assert_eq!(pair.solver.instances.len(), 1);
    assert!(pair.sent[Channel::Bulk.tag() as usize - 1] > 0);
}

/// A sky that turns or grows brighter, and who shows its direct part, are a few bytes; the image is
/// there already.
#[test]
fn an_image_of_the_sky_is_sent_once() {
    let mut pair = Pair::new();
    let texels = (0..64 * 32).map(|i| Vec3::splat(i as f32)).collect();
    let image = Arc::new(SkyImage { width: 64, height: 32, texels });
    let sky = |turn: f32, scale: f32| {
        let (image, rotation) = (image.clone(), Quat::from_rotation_y(turn));
        SessionChange::Scene(SceneChange::SetSky(Sky::Image { image, rotation, scale }))
    };
    pair.client.submit(pair.now, SnapshotId(1), vec![sky(0.0, 1.0)]);
    pair.connect(true);
    pair.settle();
    assert!(pair.sent[Channel::Bulk.tag() as usize - 1] > 100);
    let direct = SessionChange::Scene(SceneChange::SetDirectSky(DirectSky::LeftOut));
    for (snapshot, change) in (2..).zip([sky(0.5, 1.0), sky(0.5, 3.0), direct]) {
        pair.sent = [0; 3];
        pair.client.submit(pair.now, SnapshotId(snapshot), vec![change.clone()]);
        pair.settle();
        assert_eq!(pair.sent[Channel::Bulk.tag() as usize - 1], 0, "{change:?}");
        assert!(pair.sent[0] < 120, "{change:?}: {:?}", pair.sent);
        assert_eq!(pair.solver.direct_sky == DirectSky::LeftOut, snapshot == 4);
    }
    let Sky::Image { rotation, scale, .. } = &pair.solver.sky else { panic!("it is an image") };
    assert_eq!((*rotation, *scale), (Quat::from_rotation_y(0.5), 3.0));
}

/// An instance waits for its triangles; light doesn't.
#[test]
fn what_needs_a_blob_waits_and_the_rest_goes_on() {
    let mut pair = Pair::new();
    pair.connect(true);
    pair.settle();
    pair.client.submit(
        pair.now,
        SnapshotId(1),
        vec![
            set_mesh(1, 0),
            set_instance(1, 1, 0.0),
            SessionChange::AddReceiver(InstanceId(1)),
            set_light(1, 1.0),
        ],
    );
    pair.collect();
    while let Some(i) = pair.to_server.iter().position(|t| t.channel == Channel::Control) {
        pair.deliver_to_server(i);
    }
    assert_eq!(pair.solver.lights.len(), 1);
    assert!(pair.solver.instances.is_empty() && pair.receivers.is_empty());
    pair.settle();
    assert_eq!(pair.solver.instances.len(), 1);
    assert_eq!(pair.receivers.len(), 1);
}

/// Random scenes, lost connections, new servers, blobs in any order: in the end both are equal.
#[test]
fn scenes_are_equal_in_the_end() {
    for seed in 0..40 {
        let mut rng = Rng::new(seed, 0);
        let mut pair = Pair::new();
        let mut game = Scene::default();
        let mut snapshot = 0;
        let mut connected = false;
        for _ in 0..200 {
            pair.pass(20);
            let mut pick = |n: u32| (rng.next_f32() * n as f32) as u32;
            match pick(10) {
                0..4 => {
                    let mut changes = Vec::new();
                    for _ in 0..1 + pick(4) {
                        let id = u64::from(pick(4));
                        let change = match pick(9) {
                            0 => set_mesh(id, pick(6)),
                            1 => SessionChange::Scene(SceneChange::RemoveMesh(MeshId(id))),
                            2..4 => set_instance(id, u64::from(pick(4)), pick(100) as f32),
                            4 => SessionChange::Scene(SceneChange::RemoveInstance(InstanceId(id))),
                            5 => set_light(id, pick(100) as f32),
                            6 => SessionChange::Scene(SceneChange::RemoveLight(LightId(id))),
                            7 => SessionChange::Scene(SceneChange::SetDirectSky(match pick(2) {
                                0 => DirectSky::Included,
                                _ => DirectSky::LeftOut,
                            })),
                            _ => SessionChange::Scene(SceneChange::SetMaterial(
                                MaterialId(id),
                                Material {
                                    base_color: Vec4::splat(pick(9) as f32 / 8.0),
                                    ..Default::default()
                                },
                            )),
                        };
                        let SessionChange::Scene(change) = change else { continue };
                        game.apply(change.clone());
                        changes.push(SessionChange::Scene(change));
                    }
                    snapshot += 1;
                    pair.client.submit(pair.now, SnapshotId(snapshot), changes);
                }
                4 if pick(4) == 0 => {
                    pair.connect(pick(3) > 0);
                    connected = true;
                }
                5 if pick(6) == 0 => {
                    pair.cut();
                    connected = false;
                }
                _ if connected => {
                    pair.collect();
                    for _ in 0..pick(6) {
                        if let len @ 1.. = pair.to_server.len() as u32
                            && let index = pick(len) as usize
                            && Pair::is_next(&pair.to_server, index)
                        {
                            pair.deliver_to_server(index);
                        }
                        if !pair.to_client.is_empty() {
                            pair.deliver_to_client(0);
                        }
                    }
                }
                _ => {}
            }
        }
        if !connected {
            pair.connect(true);
        }
        pair.settle();
        assert_same(&pair.solver, &game);
        assert!(pair.client.state().in_sync);
    }
}

/// Random light over a line that loses, reorders and breaks: in the end the client shows the newest
/// of every texel.
#[test]
fn light_is_equal_in_the_end() {
    for seed in 0..40 {
        let mut rng = Rng::new(seed, 1);
        let mut pair = Pair::new();
        let mut newest = vec![0.0_f32; (EDGE * EDGE) as usize];
        let mut time = 0.0;
        let mut snapshot = 0;
        pair.connect(true);
        pair.settle();
        for _ in 0..300 {
            pair.pass(30);
            let mut pick = |n: u32| (rng.next_f32() * n as f32) as u32;
            match pick(10) {
                0..4 => {
                    snapshot += 1;
                    pair.client.submit(pair.now, SnapshotId(snapshot), Vec::new());
                    let tiles: Vec<(u32, u32, f32)> = (0..pick(5))
                        .map(|_| (pick(EDGE / 8), pick(EDGE / 8), pick(1000) as f32))
                        .collect();
                    for &(column, row, value) in &tiles {
                        for i in 0..64 {
                            let (x, y) = (column * 8 + i % 8, row * 8 + i / 8);
                            newest[(y * EDGE + x) as usize] = value;
                        }
                    }
                    let mut update = update(snapshot, &tiles);
                    if pick(2) == 0 {
                        time = 1.0 + pick(100) as f32 * 0.1;
                        update.grids.push(grid(time));
                    }
                    pair.server.publish(pair.now, &update, pair.now);
                }
                4 if pick(8) == 0 => pair.connect(true),
                5 if pick(8) == 0 => pair.client.resync(),
                _ => {
                    pair.collect();
                    for _ in 0..pick(6) {
                        if let len @ 1.. = pair.to_client.len() as u32
                            && let index = pick(len) as usize
                            && Pair::is_next(&pair.to_client, index)
                        {
                            pair.deliver_to_client(index);
                        }
                        if !pair.to_server.is_empty() {
                            pair.deliver_to_server(0);
                        }
                    }
                }
            }
        }
        pair.settle();
        let expected: Vec<[u16; 3]> = newest
            .chunks(8)
            .flat_map(|texels| {
                // As the wire rounds them.
                let mut message = farlight_wire::LightingMessage::default();
                let tile = farlight_gi_solver::session::Tile {
                    page: Default::default(),
                    rect: farlight_gi_solver::atlas::TexelRect { x: 0, y: 0, width: 8, height: 1 },
                    texels: texels.iter().map(|v| Vec3::splat(*v)).collect(),
                };
                message.tiles.push(HalfTile::new(&tile));
                let bytes = message.encode();
                let limits = farlight_wire::Limits::default();
                let message = farlight_wire::LightingMessage::decode(&bytes, &limits).unwrap();
                message.tiles.into_iter().next().unwrap().texels
            })
            .collect();
        assert_eq!(pair.texels, expected, "seed {seed}");
        let grids = vec![HalfGrid::new(&grid(time))];
        let message = farlight_wire::LightingMessage { grids, ..Default::default() };
        assert_eq!(pair.probes, message.rounded().grids[0].probes, "seed {seed}");
        assert_eq!(pair.shown, SnapshotId(snapshot));
    }
}

/// After convergence there are only keep-alives, and few.
#[test]
fn a_still_scene_is_silent() {
    let mut pair = Pair::new();
    pair.connect(true);
    pair.client.submit(pair.now, SnapshotId(1), vec![set_light(1, 1.0)]);
    pair.settle();
    let converged = Quality { converged: true, ..Default::default() };
    let update = LightingUpdate { quality: converged, ..update(1, &[(0, 0, 1.0)]) };
    pair.server.publish(pair.now, &update, pair.now);
    pair.settle();
    assert!(pair.client.is_converged());
    pair.messages = 0;
    pair.sent = [0; 3];
    for _ in 0..6000 {
        pair.pass(10);
        pair.settle();
    }
    assert!((20..=62).contains(&pair.messages), "{} messages in a minute", pair.messages);
    assert!(pair.sent.iter().sum::<usize>() < 400, "{:?} bytes", pair.sent);
    // The same light once more is no news.
    pair.server.publish(pair.now, &update, pair.now);
    pair.messages = 0;
    pair.settle();
    assert_eq!(pair.messages, 0);
}

/// A snapshot counts as shown when the last of its texels is on its way, not with the first.
#[test]
fn a_snapshot_that_needs_several_messages_is_named_by_the_last() {
    let mut pair = Pair::new();
    pair.connect(true);
    pair.client.submit(pair.now, SnapshotId(5), Vec::new());
    pair.settle();
    let all: Vec<(u32, u32, f32)> =
        (0..EDGE / 8).flat_map(|y| (0..EDGE / 8).map(move |x| (x, y, 1.0))).collect();
    let tiles = |n: usize| all.iter().cycle().take(n).copied().collect::<Vec<_>>();
    pair.server.publish(pair.now, &update(5, &tiles(64)), pair.now);
    pair.collect();
    let mut messages = 0;
    while !pair.to_client.is_empty() {
        messages += 1;
        pair.deliver_to_client(0);
        let complete = pair.texels.iter().all(|t| t[0] != 0);
        assert_eq!(pair.shown == SnapshotId(5), complete);
        pair.collect();
    }
    assert!(messages >= 1);
}

/// One NaN in an asset must not end the connection: what no server takes is not there for it.
#[test]
fn what_no_server_takes_is_left_out() {
    let mut pair = Pair::new();
    pair.connect(true);
    let scene = SessionChange::Scene;
    let mut broken = Mesh::clone(&mesh(1));
    broken.normals = vec![Vec3::NAN; broken.positions.len()];
    let material = Material { metallic: f32::NAN, ..Default::default() };
    let image = Arc::new(SkyImage { width: 1, height: 1, texels: vec![Vec3::ONE] });
    let sky = Sky::Image { image, rotation: Quat::IDENTITY, scale: f32::INFINITY };
    let texture = Texture { width: 5, height: 5, texels: vec![[0; 4]; 3], srgb: true };
    let changes = vec![
        set_mesh(1, 0),
        set_mesh(2, 2),
        scene(SceneChange::SetMaterial(MaterialId(1), Material::default())),
        set_light(1, 1.0),
    ];
    pair.client.submit(pair.now, SnapshotId(1), changes);
    pair.settle();
    let changes = vec![
        scene(SceneChange::SetMesh(MeshId(2), Arc::new(broken))),
        scene(SceneChange::SetMaterial(MaterialId(1), material)),
        scene(SceneChange::SetTexture(TextureId(1), Arc::new(texture))),
        scene(SceneChange::SetSky(sky)),
        set_instance(1, 1, f32::INFINITY),
        set_instance(2, 2, 1.0),
        set_light(2, 2.0),
    ];
    pair.client.submit(pair.now, SnapshotId(2), changes);
    pair.settle();
    assert!(pair.client.state().in_sync);
    assert_eq!(pair.solver.meshes.keys().copied().collect::<Vec<_>>(), [MeshId(1)]);
    assert_eq!(pair.solver.instances.keys().copied().collect::<Vec<_>>(), [InstanceId(2)]);
    assert!(pair.solver.materials.is_empty() && pair.solver.textures.is_empty());
    assert_eq!((pair.solver.lights.len(), &pair.solver.sky), (2, &Sky::default()));
}

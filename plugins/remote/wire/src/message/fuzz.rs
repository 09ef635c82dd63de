//! Fuzz targets of the messages; the harness is the one of `tests/fuzz`.

#[path = "../../tests/fuzz/mutate.rs"]
mod mutate;

use farlight_gi_solver::{
    scene::{
        AlphaMode, DirectSky, Instance, InstanceId, Light, LightId, LightKind, Material,
        MaterialId, MeshId, TextureId,
    },
    session::{GridId, ProbeGrid, SessionSettings, SnapshotId},
};
use glam::{Affine3A, Quat, UVec3, Vec3};

use super::{Chunk, ClientMessage, Object, ObjectKey, ServerMessage, SkyObject, SnapshotPart};
use crate::{BlobHash, Channel, ClientHello, Limits, Token, View, Welcome};

fn snapshot() -> SnapshotPart {
    let material = Material {
        base_color_texture: Some(TextureId(300)),
        alpha_mode: AlphaMode::Mask(0.5),
        ..Default::default()
    };
    let instance = Instance {
        mesh: MeshId(1),
        material: MaterialId(2),
        transform: Affine3A::from_translation(Vec3::ONE),
    };
    let light = Light {
        kind: LightKind::Spot { inner_angle: 0.1, outer_angle: 0.2 },
        position: Vec3::X,
        direction: Vec3::NEG_Y,
        intensity: Vec3::ONE,
        range: f32::INFINITY,
    };
    let image = SkyObject::Image { image: BlobHash([3; 32]), rotation: Quat::IDENTITY, scale: 1.0 };
    let grid = ProbeGrid { transform: Affine3A::IDENTITY, resolution: UVec3::new(2, 3, 4) };
    let changes = vec![
        (ObjectKey::Texture(TextureId(300)), Some(Object::Texture(BlobHash([1; 32])))),
        (ObjectKey::Mesh(MeshId(1)), Some(Object::Mesh(BlobHash([2; 32])))),
        (ObjectKey::Material(MaterialId(2)), Some(Object::Material(material))),
        (ObjectKey::Instance(InstanceId(3)), Some(Object::Instance(instance))),
        (ObjectKey::Receiver(InstanceId(3)), Some(Object::Receiver)),
        (ObjectKey::Light(LightId(4)), Some(Object::Light(light))),
        (ObjectKey::Sky, Some(Object::Sky(image))),
        (ObjectKey::Sky, Some(Object::Sky(SkyObject::Constant(Vec3::ONE)))),
        (ObjectKey::DirectSky, Some(Object::DirectSky(DirectSky::LeftOut))),
        (ObjectKey::DirectSky, Some(Object::DirectSky(DirectSky::Included))),
        (ObjectKey::Grid(GridId(5)), Some(Object::Grid(grid))),
        (ObjectKey::Grid(GridId(6)), None),
    ];
    SnapshotPart { snapshot: SnapshotId(7), last: true, changes }
}

#[test]
fn fuzz_client_message() {
    let hash = BlobHash([5; 32]);
    let view = View { predicted: vec![(1, Vec3::X, Quat::IDENTITY); 2], ..View::default() };
    let corpus = [
        ClientMessage::Snapshot(snapshot()),
        ClientMessage::Chunk(Chunk { hash, total: 100, offset: 0, data: vec![9; 100] }),
        ClientMessage::Gone(hash),
        ClientMessage::Acks(vec![1, 2, 300, u64::MAX]),
        ClientMessage::Resync,
        ClientMessage::View(view),
        ClientMessage::Ping(1),
        ClientMessage::Pong(u64::MAX),
    ];
    let corpus = corpus.map(|message| message.encode()).into();
    mutate::fuzz("client_message", 20_000, corpus, |_, input| {
        let mut accepted = false;
        for channel in Channel::ALL {
            if let Ok(Some(message)) = ClientMessage::decode(channel, input) {
                assert_eq!(message.channel(), channel);
                assert_eq!(ClientMessage::decode(channel, &message.encode()), Ok(Some(message)));
                accepted = true;
            }
        }
        accepted
    });
}

#[test]
fn fuzz_server_message() {
    let corpus = [
        ServerMessage::Acknowledged(SnapshotId(3)),
        ServerMessage::Wanted(vec![(BlobHash([1; 32]), 0), (BlobHash([2; 32]), 1 << 20)]),
        ServerMessage::Notice("something that people should know".into()),
        ServerMessage::Ping(1),
        ServerMessage::Pong(2),
    ];
    let corpus = corpus.map(|message| message.encode()).into();
    mutate::fuzz("server_message", 20_000, corpus, |_, input| {
        let Ok(Some(message)) = ServerMessage::decode(input) else { return false };
        assert_eq!(ServerMessage::decode(&message.encode()), Ok(Some(message)));
        true
    });
}

#[test]
fn fuzz_hello_and_welcome() {
    let settings = SessionSettings { page_size: 128, ..Default::default() };
    let hello = ClientHello {
        name: "a game with ünicode".into(),
        token: Token([1; 16]),
        resume: Some(Token([2; 16])),
        settings: settings.clone(),
    };
    let welcome = Welcome { key: Token([3; 16]), resumed: true, snapshot: SnapshotId(4), settings };
    let limits = Limits::default();
    let corpus = vec![hello.encode(), welcome.encode()];
    mutate::fuzz("hello_and_welcome", 20_000, corpus, |_, input| {
        let read = |bytes: &[u8]| ClientHello::read(Channel::Control, bytes, &limits);
        if let Ok(hello) = read(input) {
            assert_eq!(read(&hello.encode()), Ok(hello));
            return true;
        }
        let Ok(welcome) = Welcome::read(input) else { return false };
        assert_eq!(Welcome::read(&welcome.encode()), Ok(welcome));
        true
    });
}

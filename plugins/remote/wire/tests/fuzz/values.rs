//! Fuzz targets of what stands for itself: blobs, light, invitations, greetings.

use std::sync::Arc;

use farlight_gi_solver::{
    atlas::{PageId, TexelRect},
    scene::{InstanceId, Mesh, SkyImage, Texture},
    session::{GridId, Placement, Quality, SnapshotId},
};
use farlight_wire::{
    Blob, Channel, ClientHello, HalfGrid, HalfTile, Invitation, LightingMessage, Limits, Piece,
};
use glam::{UVec3, Vec2, Vec3};

use crate::{memory, mutate, mutate::Random, sessions};

/// A mesh with all attributes.
pub(crate) fn mesh(n: u32) -> Blob {
    let mut mesh = Mesh::default();
    for y in 0..=n {
        for x in 0..=n {
            let uv = Vec2::new(x as f32, y as f32) / n as f32;
            mesh.positions.push(Vec3::new(uv.x, (uv.x * 9.0).sin(), uv.y));
            mesh.normals.push(Vec3::new(uv.y - 0.5, 1.0, 0.1).normalize());
            mesh.uv0.push(uv * 4.0);
            mesh.uv1.push(uv);
        }
    }
    for y in 0..n {
        for x in 0..n {
            let i = y * (n + 1) + x;
            mesh.triangles.extend([[i, i + n + 1, i + 1], [i + 1, i + n + 1, i + n + 2]]);
        }
    }
    Blob::Mesh(Arc::new(mesh))
}

pub(crate) fn texture(width: u32, height: u32) -> Blob {
    let texels = (0..width * height).map(|i| [i as u8, (i / width) as u8, 7, 255]).collect();
    Blob::Texture(Arc::new(Texture { width, height, texels, srgb: true }))
}

pub(crate) fn sky() -> Blob {
    let texels = (0..128).map(|i| Vec3::new(0.1, 0.4, 1.0) * i as f32).collect();
    Blob::Sky(Arc::new(SkyImage { width: 16, height: 8, texels }))
}

#[test]
fn fuzz_blob() {
    const LIMIT: usize = 1 << 20;
    /// Buffers for one piece, the compressor's table, and the hash.
    const BUFFERS: usize = 640 << 10;
    // The large texture has two pieces.
    let blobs = [mesh(1), mesh(9), texture(17, 9), texture(1, 1), texture(300, 230), sky()];
    let blobs = blobs.into_iter().chain([
        Blob::Mesh(Arc::default()),
        Blob::Texture(Arc::default()),
        Blob::Sky(Arc::default()),
    ]);
    let corpus = blobs.map(|blob| blob.encode()).collect();
    mutate::fuzz("blob", 20_000, corpus, |_, input| {
        let (result, peak) = memory::peak(|| Blob::decode_any(input, LIMIT));
        // LZ4 makes 255 bytes of one at most.
        let most = LIMIT.min(255 * input.len()) + BUFFERS;
        assert!(peak <= most, "{peak} bytes for {}", input.len());
        let Ok((blob, hash)) = result else { return false };
        assert!(blob.memory() <= LIMIT);
        assert_eq!(blob.check(), Ok(()));
        let again = Blob::decode(&blob.encode(), hash, LIMIT).expect("what was decoded");
        // Equal hashes are equal bits.
        assert_eq!(again.hash(), hash);
        true
    });
}

/// Light of every kind of part.
pub(crate) fn lighting(random: &mut Random, tiles: usize, probes: u32) -> LightingMessage {
    let half = |random: &mut Random| 0x3000 + (random.next() % 0x600) as u16;
    let tiles = (0..tiles).map(|i| {
        let size = 1 + random.below(12) as u32;
        let rect = TexelRect { x: i as u32 * 13, y: 3, width: size, height: 13 - size };
        let texels = (0..rect.area()).map(|_| [half(random), half(random), half(random)]).collect();
        HalfTile { page: PageId(i as u32 % 3), rect, texels }
    });
    let tiles = tiles.collect();
    let probe =
        |random: &mut Random| std::array::from_fn(|_| std::array::from_fn(|_| half(random)));
    let grid = HalfGrid {
        grid: GridId(3),
        resolution: UVec3::new(3, 2, probes.max(1)),
        first: probes.min(2),
        probes: (0..probes).map(|_| probe(random)).collect(),
    };
    let rect = TexelRect { x: 0, y: 0, width: 8, height: 8 };
    LightingMessage {
        sequence: 4,
        snapshot: SnapshotId(2),
        quality: Quality { relative_error: 0.02, rays_per_texel: 64, converged: false },
        placements: vec![Placement { instance: InstanceId(1), page: PageId(0), rect }],
        refused: vec![(InstanceId(2), Arc::from("no second UV set"))],
        tiles,
        grids: vec![grid],
        ..Default::default()
    }
}

#[test]
fn fuzz_lighting() {
    /// Learned probabilities of all channels.
    const MODELS: usize = 256 << 10;
    /// Bytes of texels and probes that a byte may stand for, twice, and the longest list of empty
    /// things that a byte may begin, while it grows.
    const EACH: usize = 1024;
    let limits = Limits { texels: 1 << 16, probes: 1 << 12, objects: 1000, ..Limits::default() };
    let random = &mut Random(5);
    let mut corpus = vec![LightingMessage::default().encode()];
    corpus.extend((0..8).map(|i| lighting(random, i % 4, i as u32 / 2).encode()));
    mutate::fuzz("lighting", 8_000, corpus, |_, input| {
        let (result, peak) = memory::peak(|| LightingMessage::decode(input, &limits));
        let most =
            (EACH * input.len()).min((limits.texels * 6 + limits.probes * 54) * 2 + (1 << 20));
        assert!(peak <= most + MODELS, "{peak} bytes for {}", input.len());
        let Ok(message) = result else { return false };
        assert!(message.tiles.iter().map(|tile| tile.texels.len()).sum::<usize>() <= limits.texels);
        assert!(message.grids.iter().map(|grid| grid.probes.len()).sum::<usize>() <= limits.probes);
        assert_eq!(message.rounded(), message, "sending it on changes nothing");
        assert_eq!(LightingMessage::decode(&message.encode(), &limits).as_ref(), Ok(&message));
        true
    });
}

/// Light that builds on older light, some of which the reader has.
#[test]
fn fuzz_lighting_beside() {
    let limits = Limits { texels: 1 << 16, probes: 1 << 12, objects: 1000, ..Limits::default() };
    let random = &mut Random(6);
    let old: Vec<[u16; 3]> = (0..1 << 16).map(|i| [0x3800 + (i % 900) as u16; 3]).collect();
    let base = |piece| match piece {
        Piece::Tile(_, rect) => old.get(..rect.area()),
        Piece::Probes(..) => None,
    };
    let mut corpus = Vec::new();
    for tiles in 0..6 {
        let mut message = lighting(random, tiles, 1);
        message.sequence = 10 + tiles as u64;
        for tile in &mut message.tiles {
            for (texel, old) in tile.texels.iter_mut().zip(&old) {
                *texel = old.map(|bits| bits + 40 + random.below(20) as u16);
            }
        }
        let (bytes, rounded) = message.encode_beside(|piece| Some((8, base(piece)?)));
        let read = LightingMessage::decode_beside(&bytes, &limits, |piece, _| base(piece));
        assert_eq!(read, Ok(rounded));
        assert_eq!(LightingMessage::decode(&bytes, &limits).is_ok(), tiles == 0);
        corpus.push(bytes);
    }
    mutate::fuzz("lighting_beside", 8_000, corpus, |_, input| {
        // It has what even messages brought.
        let has = |piece, sequence: u64| {
            if sequence.is_multiple_of(2) { base(piece) } else { None }
        };
        let (result, peak) = memory::peak(|| LightingMessage::decode_beside(input, &limits, has));
        let most = (limits.texels * 6 + limits.probes * 54) * 2 + (1 << 20);
        assert!(peak <= most.min(1024 * input.len()) + (512 << 10), "{peak} bytes");
        let Ok(message) = result else { return false };
        for tile in &message.tiles {
            assert!(tile.texels.is_empty() || tile.texels.len() == tile.rect.area());
            assert!(tile.texels.iter().flatten().all(|bits| *bits < 0x7c00), "no radiance");
        }
        true
    });
}

#[test]
fn fuzz_invitation() {
    let secrets = format!("{}.{}", "0f".repeat(16), "a7".repeat(32));
    let hosts = ["localhost:4433", "[::1]:1", "192.168.0.7:65535", "[fe80::1%eth0]:80"];
    let corpus = hosts.map(|host| format!("farlight://{host}/#{secrets}").into_bytes()).into();
    mutate::fuzz("invitation", 20_000, corpus, |_, input| {
        let text = String::from_utf8_lossy(input);
        let (result, peak) = memory::peak(|| text.parse::<Invitation>());
        assert!(peak <= text.len() + 64, "{peak} bytes for {}", text.len());
        let Ok(invitation) = result else { return false };
        assert_eq!(invitation.to_string().parse(), Ok(invitation));
        true
    });
}

#[test]
fn fuzz_greeting() {
    let limits = Limits::default();
    let corpus = sessions::greetings();
    mutate::fuzz("greeting", 20_000, corpus, |_, input| {
        let read = || ClientHello::read(Channel::Control, input, &limits);
        let (result, peak) = memory::peak(read);
        assert!(peak <= 4 * input.len() + 1024, "{peak} bytes for {}", input.len());
        let Ok(hello) = result else { return false };
        assert!(hello.name.chars().count() <= 64 && !hello.name.contains(char::is_control));
        assert!((16..=4096).contains(&hello.settings.page_size));
        true
    });
}

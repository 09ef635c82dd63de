use glam::{Vec2, Vec3};

use super::*;

/// A grid of quads with waves, as an exporter would write it.
fn mesh(n: u32) -> Blob {
    let mut mesh = Mesh::default();
    for y in 0..=n {
        for x in 0..=n {
            let uv = Vec2::new(x as f32, y as f32) / n as f32;
            let height = (uv.x * 9.0).sin() * (uv.y * 7.0).cos();
            mesh.positions.push(Vec3::new(uv.x * 4.0 - 2.0, height, uv.y * 3.0));
            mesh.normals.push(Vec3::new(-height, 1.0, height * 0.3).normalize());
            mesh.uv0.push(uv * 8.0);
            mesh.uv1.push(uv);
        }
    }
    for y in 0..n {
        for x in 0..n {
            let i = y * (n + 1) + x;
            mesh.triangles.push([i, i + n + 1, i + 1]);
            mesh.triangles.push([i + 1, i + n + 1, i + n + 2]);
        }
    }
    Blob::Mesh(Arc::new(mesh))
}

fn texture(width: u32, height: u32) -> Blob {
    let texel = |i: u32| {
        let (x, y) = (i % width, i / width);
        [(x * 3) as u8, (y * 2) as u8, ((x / 8 + y / 8) % 2 * 200) as u8, 255]
    };
    let texels = (0..width * height).map(texel).collect();
    Blob::Texture(Arc::new(Texture { width, height, texels, srgb: true }))
}

fn sky() -> Blob {
    let texels =
        (0..64 * 32).map(|i| Vec3::new(0.3, 0.5, 1.0) * (i as f32).sqrt() * 100.0).collect();
    Blob::Sky(Arc::new(SkyImage { width: 64, height: 32, texels }))
}

fn equal(a: &Blob, b: &Blob) -> bool {
    match (a, b) {
        (Blob::Mesh(a), Blob::Mesh(b)) => a == b,
        (Blob::Texture(a), Blob::Texture(b)) => a == b,
        (Blob::Sky(a), Blob::Sky(b)) => a == b,
        _ => false,
    }
}

fn examples() -> Vec<Blob> {
    // The first and the large texture have several pieces.
    vec![
        mesh(200),
        mesh(1),
        texture(300, 301),
        texture(1, 1),
        sky(),
        Blob::Mesh(Arc::default()),
        Blob::Texture(Arc::default()),
        Blob::Sky(Arc::default()),
    ]
}

#[test]
fn blobs_come_back() {
    for blob in examples() {
        let (hash, bytes) = (blob.hash(), blob.encode());
        let back = Blob::decode(&bytes, hash, blob.memory()).unwrap();
        assert!(equal(&blob, &back));
        assert_eq!(back.hash(), hash);
        if blob.memory() > 1000 {
            let ratio = blob.memory() as f64 / bytes.len() as f64;
            println!("{} bytes, {ratio:.2} times smaller", blob.memory());
            assert!(ratio > 1.3, "{ratio}");
        }
    }
}

#[test]
fn noise_is_not_blown_up() {
    let mut state = 1_u32;
    let mut noise = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 13) as u8
    };
    let texels = (0..512 * 512).map(|_| std::array::from_fn(|_| noise())).collect();
    let blob = Blob::Texture(Arc::new(Texture { width: 512, height: 512, texels, srgb: false }));
    let bytes = blob.encode();
    assert!(bytes.len() <= blob.memory() + 32, "{} of {}", bytes.len(), blob.memory());
    assert!(equal(&blob, &Blob::decode(&bytes, blob.hash(), usize::MAX).unwrap()));
}

#[test]
fn every_bit_counts_in_the_hash() {
    let Blob::Mesh(arc) = mesh(2) else { unreachable!() };
    let name = |mesh: &Mesh| Blob::Mesh(Arc::new(mesh.clone())).hash();
    let original = name(&arc);
    let mut changed = Mesh::clone(&arc);
    changed.positions[3].y = f32::from_bits(changed.positions[3].y.to_bits() ^ 1);
    assert_ne!(name(&changed), original);
    // Moving an array from one attribute to another is a change too.
    let mut moved = Mesh::clone(&arc);
    moved.uv0 = Vec::new();
    let mut other = Mesh::clone(&moved);
    other.uv0 = std::mem::take(&mut other.uv1);
    assert_ne!(name(&moved), name(&other));
    let image = Texture { width: 1, height: 2, texels: vec![[1; 4]; 2], srgb: false };
    let turned = Texture { width: 2, height: 1, ..image.clone() };
    let linear = Texture { srgb: true, ..image.clone() };
    let name = |texture: Texture| Blob::Texture(Arc::new(texture)).hash();
    assert_ne!(name(image.clone()), name(turned));
    assert_ne!(name(image), name(linear));
}

#[test]
fn another_content_is_refused() {
    let bytes = mesh(3).encode();
    let wrong = Blob::decode(&bytes, mesh(4).hash(), usize::MAX);
    assert_eq!(wrong.map(|_| ()), Err(WireError::WrongHash));
}

#[test]
fn sizes_are_checked_before_memory_is_taken() {
    let blob = mesh(4);
    let bytes = blob.encode();
    let error = Blob::decode(&bytes, blob.hash(), blob.memory() - 1).unwrap_err();
    assert!(matches!(error, WireError::TooLarge { .. }), "{error}");
    // More than memory, more than 64 bits, and more than the bytes can hold.
    for count in [1_u64 << 60, u64::MAX, 1 << 30] {
        let mut lie = bytes.clone();
        lie[1..9].copy_from_slice(&count.to_le_bytes());
        let error = Blob::decode(&lie, blob.hash(), usize::MAX).unwrap_err();
        let expected = matches!(error, WireError::TooLarge { .. } | WireError::Invalid { .. });
        assert!(expected, "{error}");
    }
}

#[test]
fn cut_and_lengthened_blobs_are_refused() {
    for blob in [mesh(3), texture(5, 4), sky()] {
        let (bytes, hash) = (blob.encode(), blob.hash());
        for length in 0..bytes.len() {
            assert!(Blob::decode(&bytes[..length], hash, 1 << 20).is_err(), "{length}");
        }
        let mut longer = bytes;
        longer.push(0);
        assert!(Blob::decode(&longer, hash, 1 << 20).is_err());
    }
}

#[test]
fn what_is_not_valid_is_refused() {
    let Blob::Mesh(good) = mesh(2) else { unreachable!() };
    let refused = |blob: Blob| {
        assert!(blob.check().is_err());
        let error = Blob::decode(&blob.encode(), blob.hash(), usize::MAX).unwrap_err();
        assert!(matches!(error, WireError::Invalid { .. } | WireError::TooLarge { .. }), "{error}");
    };
    let broken = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = Mesh::clone(&good);
        change(&mut mesh);
        refused(Blob::Mesh(Arc::new(mesh)));
    };
    broken(&|m| m.positions[0].x = f32::NAN);
    broken(&|m| m.normals[0].x = f32::INFINITY);
    broken(&|m| m.uv0[1].y = f32::NAN);
    broken(&|m| m.uv1[1].y = f32::NEG_INFINITY);
    broken(&|m| m.triangles[0][2] = 9);
    broken(&|m| m.normals.truncate(1));
    broken(&|m| {
        m.triangles.clear();
        m.uv1.truncate(1);
    });
    let texture = |width, height, count| {
        let texels = vec![[0; 4]; count];
        refused(Blob::Texture(Arc::new(Texture { width, height, texels, srgb: false })));
    };
    texture(2, 2, 3);
    texture(0, 0, 1);
    texture(16385, 1, 16385);
    texture(u32::MAX, u32::MAX, 1);
    for value in [-1.0, f32::NAN, f32::INFINITY] {
        let texels = vec![Vec3::new(0.0, value, 1.0)];
        refused(Blob::Sky(Arc::new(SkyImage { width: 1, height: 1, texels })));
    }
}

/// The format is part of the protocol's version: if this fails, raise that. What the compressor
/// makes of it is its own affair, so the encoded bytes are only read.
#[test]
fn golden_bytes() {
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(0.0, 1.0, -2.0)],
        uv1: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let blob = Blob::Mesh(Arc::new(mesh));
    let hex = |bytes: &[u8]| bytes.iter().map(|b| format!("{b:02x}")).collect::<String>();
    assert_eq!(hex(&blob.hash().0), GOLDEN_HASH);
    let bytes: Vec<u8> = (0..GOLDEN_MESH.len())
        .step_by(2)
        .map(|i| u8::from_str_radix(&GOLDEN_MESH[i..i + 2], 16).unwrap())
        .collect();
    assert!(equal(&Blob::decode(&bytes, blob.hash(), 1000).unwrap(), &blob));
}

const GOLDEN_HASH: &str = "904a015e7266579fe35e4e881d0212d16863b10805ffca823d122bb6940b2e64";
const GOLDEN_MESH: &str = "\
    01030000000000000000000000000000000000000000000000030000000000000001000000000000\
    00011512000100428000003f0a00090d00600000000000c0011312000100428000003f0a00700000\
    008000003f00000000000100000002000000";

//! Unwrapping takes seconds; it is kept from one bake to the next.

use farlight_baked_format::Fingerprint;
use farlight_gi_solver::{scene::Mesh, unwrap::Unwrapped};
use glam::{UVec2, Vec2};

/// Changes with whatever changes what comes out of the same input.
const VERSION: u32 = 1;

/// Keeps what was unwrapped.
pub trait UvCache: Sync {
    /// What was put for a key.
    fn get(&self, key: Fingerprint) -> Option<Vec<u8>>;
    /// Keeps bytes for a key; failing silently is fine.
    fn put(&self, key: Fingerprint, bytes: &[u8]);
}

/// Keeps nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoCache;

impl UvCache for NoCache {
    fn get(&self, _key: Fingerprint) -> Option<Vec<u8>> {
        None
    }

    fn put(&self, _key: Fingerprint, _bytes: &[u8]) {}
}

/// The key of a mesh and numbers that matter.
pub(super) fn key(mesh: &Mesh, numbers: &[u32]) -> Fingerprint {
    let mut hasher = blake3::Hasher::new();
    let mut part = |words: &mut dyn Iterator<Item = u32>, count: usize| {
        let mut bytes = Vec::with_capacity(8 + 4 * count);
        bytes.extend((count as u64).to_le_bytes());
        words.for_each(|word| bytes.extend(word.to_le_bytes()));
        hasher.update(&bytes);
    };
    part(&mut [VERSION].iter().chain(numbers).copied(), 1 + numbers.len());
    for vectors in [&mesh.positions, &mesh.normals] {
        let words = vectors.iter().flat_map(|v| v.to_array()).map(f32::to_bits);
        part(&mut { words }, 3 * vectors.len());
    }
    let words = mesh.uv1.iter().flat_map(|v| v.to_array()).map(f32::to_bits);
    part(&mut { words }, 2 * mesh.uv1.len());
    let corners = mesh.triangles.as_flattened();
    part(&mut corners.iter().copied(), corners.len());
    Fingerprint::from(&hasher.finalize())
}

/// What is kept of an unwrapping: vertices, triangles, UVs, charts, size, gutter.
pub(super) fn encode(unwrapped: &Unwrapped) -> Vec<u8> {
    let mut words = vec![
        unwrapped.source.len() as u32,
        unwrapped.triangles.len() as u32,
        unwrapped.size.x,
        unwrapped.size.y,
        unwrapped.gutter.to_bits(),
    ];
    words.extend(&unwrapped.source);
    words.extend(unwrapped.triangles.as_flattened());
    words.extend(unwrapped.uv1.iter().flat_map(|uv| uv.to_array()).map(f32::to_bits));
    words.extend(&unwrapped.charts);
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    // Files of caches get damaged too.
    [&blake3::hash(&bytes).as_bytes()[..8], bytes.as_slice()].concat()
}

/// `None` if the bytes are not what [`encode`] made for a mesh of this size.
pub(super) fn decode(bytes: &[u8], mesh: &Mesh) -> Option<Unwrapped> {
    let (sum, bytes) = bytes.split_at_checked(8)?;
    if blake3::hash(bytes).as_bytes()[..8] != *sum {
        return None;
    }
    let (words, rest) = bytes.as_chunks::<4>();
    let words: Vec<u32> = words.iter().map(|&word| u32::from_le_bytes(word)).collect();
    let &[vertices, triangles, width, height, gutter, ref words @ ..] = words.as_slice() else {
        return None;
    };
    let (vertices, triangles) = (vertices as usize, triangles as usize);
    let length = vertices.checked_mul(3)?.checked_add(triangles.checked_mul(4)?)?;
    if !rest.is_empty() || words.len() != length || triangles != mesh.triangles.len() {
        return None;
    }
    let (source, words) = words.split_at(vertices);
    let (corners, words) = words.split_at(3 * triangles);
    let (uv1, charts) = words.split_at(2 * vertices);
    let fits = source.iter().all(|&i| (i as usize) < mesh.positions.len())
        && corners.iter().all(|&i| (i as usize) < vertices);
    fits.then(|| Unwrapped {
        source: source.to_vec(),
        triangles: corners.as_chunks::<3>().0.to_vec(),
        uv1: uv1.as_chunks::<2>().0.iter().map(|uv| Vec2::from(uv.map(f32::from_bits))).collect(),
        charts: charts.to_vec(),
        made: None,
        gutter: f32::from_bits(gutter),
        size: UVec2::new(width, height),
    })
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn what_is_kept_comes_back_and_damage_does_not() {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            ..Default::default()
        };
        let unwrapped = Unwrapped {
            source: vec![2, 0, 1, 1],
            triangles: vec![[3, 1, 0]],
            uv1: vec![Vec2::new(0.25, -0.0); 4],
            charts: vec![7],
            made: None,
            gutter: 1.5,
            size: UVec2::new(30, 20),
        };
        let bytes = encode(&unwrapped);
        assert_eq!(decode(&bytes, &mesh), Some(unwrapped));
        for i in 0..bytes.len() {
            let mut bad = bytes.clone();
            bad[i] ^= 1;
            assert_eq!(decode(&bad, &mesh), None, "byte {i}");
            assert_eq!(decode(&bytes[..i], &mesh), None, "{i} bytes");
        }
        assert_eq!(decode(&bytes, &Mesh::default()), None);
    }

    #[test]
    fn keys_tell_apart_what_matters() {
        let mut mesh = Mesh { positions: vec![Vec3::X], ..Default::default() };
        let key_of = key(&mesh, &[1]);
        assert_eq!(key_of, key(&mesh, &[1]));
        assert_ne!(key_of, key(&mesh, &[2]));
        mesh.normals = std::mem::take(&mut mesh.positions);
        assert_ne!(key_of, key(&mesh, &[1]));
    }
}

//! Thousands of damaged variants of small valid files: an error or a scene that can be traced, never
//! a panic, never more memory than the limits allow.

use crate::{
    damage::{Random, count, replace, replacement},
    glb::{rich, square, write},
    memory,
};
use farlight_gi_solver::{
    World,
    import::{ImportLimits, ImportOptions, load_scene_from_slice},
    unwrap::{UnwrapOptions, ensure_uv1},
};

/// Reads a variant; on success uses the scene.
fn survive(bytes: &[u8], what: &str) -> bool {
    let limits = ImportLimits {
        file_bytes: 1 << 20,
        json_values: 20_000,
        triangles: 10_000,
        vertices: 100_000,
        texture_texels: 1 << 18,
        depth: 100,
    };
    let options = ImportOptions { limits, ..Default::default() };
    let (result, peak) = memory::peak(|| load_scene_from_slice(bytes, &options));
    assert!(peak < 24 << 20, "{what}: {peak} bytes");
    let Ok(imported) = result else { return false };
    for mesh in imported.scene.meshes.values() {
        mesh.validate().unwrap_or_else(|problem| panic!("{what}: {problem}"));
    }
    for instance in imported.scene.instances.values() {
        assert!(instance.transform.is_finite(), "{what}");
        assert!(imported.scene.meshes.contains_key(&instance.mesh), "{what}");
        assert!(imported.scene.materials.contains_key(&instance.material), "{what}");
    }
    for light in imported.scene.lights.values() {
        assert!(light.intensity.is_finite() && light.range > 0.0, "{what}");
    }
    _ = World::new(&imported.scene);
    true
}

#[test]
fn random_bytes_are_survived() {
    let files = [square().bytes(), rich().bytes()];
    let mut random = Random(1);
    let mut read = 0;
    for i in 0..12_000 {
        let mut bytes = files[i % 2].clone();
        for _ in 0..=random.below(4) {
            // Half of the damage hits the binary chunk: there more of it passes the parser.
            let json = u32::from_le_bytes(files[i % 2][12..16].try_into().unwrap()) as usize;
            let from = if random.below(2) == 0 { 20 + json } else { 0 };
            let at = from + random.below(bytes.len() - from);
            match random.below(4) {
                0 => bytes[at] = random.next() as u8,
                1 => bytes[at] ^= 1 << random.below(8),
                2 => {
                    // A word of a kind that breaks arithmetic.
                    let words =
                        [0, 1, 0x7fff_ffff, 0x8000_0000, u32::MAX, 0x7fc0_0000, 0x7f80_0000];
                    let word = words[random.below(words.len())].to_le_bytes();
                    let at = at / 4 * 4;
                    bytes[at..at + 4].copy_from_slice(&word);
                }
                _ => {
                    let length = random.below(40).min(bytes.len() - at);
                    let from = random.below(bytes.len() - length);
                    bytes.copy_within(from..from + length, at);
                }
            }
        }
        read += u32::from(survive(&bytes, &format!("variant {i}")));
    }
    println!("{read} of 12000 variants were read");
    assert!(read > 500, "damage must not always be so bad that nothing is tested: {read}");
}

#[test]
fn random_json_values_are_survived() {
    let base = rich();
    let mut random = Random(2);
    let mut read = 0;
    for i in 0..12_000 {
        let mut json = base.json.clone();
        for _ in 0..=random.below(2) {
            let count = count(&json);
            let mut target = random.below(count);
            let value = replacement(&mut random);
            replace(&mut json, &mut target, &value);
        }
        let bytes = write(json.to_string().as_bytes(), &base.bin);
        read += u32::from(survive(&bytes, &format!("variant {i}: {json}")));
    }
    println!("{read} of 12000 variants were read");
    assert!(read > 500, "damage must not always be so bad that nothing is tested: {read}");
}

#[test]
fn random_meshes_are_unwrapped_or_refused() {
    let mut random = Random(3);
    for i in 0..300 {
        let vertices = 3 + random.below(30);
        let coordinate = |random: &mut Random| {
            // Few different values, so that points coincide, and some extremes.
            let values = [0.0, 1.0, 2.0, 0.5, -1.0, 1e-20, 1e8, 3.0];
            values[random.below(values.len())]
        };
        let position = |random: &mut Random| {
            glam::Vec3::new(coordinate(random), coordinate(random), coordinate(random))
        };
        let mut mesh = farlight_gi_solver::scene::Mesh {
            positions: (0..vertices).map(|_| position(&mut random)).collect(),
            ..Default::default()
        };
        for _ in 0..1 + random.below(60) {
            mesh.triangles.push([0; 3].map(|_: u32| random.below(vertices) as u32));
        }
        if random.below(2) == 0 {
            mesh.uv1 = mesh.positions.iter().map(|p| p.truncate() * 0.5).collect();
        }
        if let Ok(unwrapped) =
            ensure_uv1(&mesh, &UnwrapOptions { texels: 32, ..Default::default() })
        {
            unwrapped.apply(&mesh).validate().unwrap_or_else(|p| panic!("mesh {i}: {p}"));
            assert_eq!(unwrapped.charts.len(), mesh.triangles.len());
        }
    }
}

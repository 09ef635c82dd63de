//! Triangles for the benchmark.

use std::path::Path;

use glam::{Mat4, Vec3};

/// All triangles of a glTF file's default scene, in world space.
pub(crate) fn load(path: &Path, scale: f32) -> Result<Vec<[Vec3; 3]>, String> {
    let (document, buffers) = parse(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or("the file has no scene")?;
    let mut triangles = Vec::new();
    let mut todo: Vec<_> =
        scene.nodes().map(|n| (n, Mat4::from_scale(Vec3::splat(scale)))).collect();
    while let Some((node, parent)) = todo.pop() {
        let transform = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        todo.extend(node.children().map(|n| (n, transform)));
        for primitive in node.mesh().into_iter().flat_map(|m| m.primitives().collect::<Vec<_>>()) {
            if primitive.mode() != gltf::mesh::Mode::Triangles {
                continue; // real files hold lines, too
            }
            let reader = primitive.reader(|b| buffers.get(b.index()).map(|d| d.as_slice()));
            let Some(positions) = reader.read_positions() else { continue };
            let positions: Vec<Vec3> =
                positions.map(|p| transform.transform_point3(Vec3::from_array(p))).collect();
            let indices: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..positions.len() as u32).collect(),
            };
            for corners in indices.chunks_exact(3) {
                let corner = |i: usize| positions.get(corners[i] as usize).copied();
                if let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) {
                    triangles.push([a, b, c]);
                }
            }
        }
    }
    Ok(triangles)
}

fn parse(path: &Path) -> Result<(gltf::Document, Vec<Vec<u8>>), String> {
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    let gltf = gltf::Gltf::from_slice(&bytes).map_err(|e| e.to_string())?;
    let blob = gltf.blob.ok_or("not a binary glTF file with its own buffer")?;
    Ok((gltf.document, vec![blob]))
}

/// A room of 10 x 3 x 8 m with 200 spheres in it, about 100,000 triangles.
pub(crate) fn generated() -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    let size = Vec3::new(10.0, 3.0, 8.0);
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            grid(20, &mut triangles, |u, v| {
                let mut p = Vec3::ZERO;
                p[axis] = side;
                p[(axis + 1) % 3] = u;
                p[(axis + 2) % 3] = v;
                p * size
            });
        }
    }
    let mut random = crate::rays::Random::new(7);
    for _ in 0..200 {
        let centre = Vec3::new(random.next(), random.next(), random.next()) * size;
        let radius = 0.1 + 0.3 * random.next();
        grid(16, &mut triangles, |u, v| {
            let (polar, azimuth) = (u * std::f32::consts::PI, v * std::f32::consts::TAU);
            let (s, c) = polar.sin_cos();
            centre + radius * Vec3::new(s * azimuth.cos(), c, s * azimuth.sin())
        });
    }
    triangles
}

fn grid(n: usize, out: &mut Vec<[Vec3; 3]>, point: impl Fn(f32, f32) -> Vec3) {
    let at = |i: usize, j: usize| point(i as f32 / n as f32, j as f32 / n as f32);
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            out.extend([[a, b, c], [a, c, d]]);
        }
    }
}

//! Unwrapping of whole meshes: what comes out is a lightmap square without overlaps, with gutters,
//! whose charts do not cross hard edges.

use std::{collections::HashSet, path::Path, time::Duration};

use farlight_gi_solver::{
    import::{ImportOptions, load_scene},
    scene::{Mesh, MeshProblem},
    unwrap::{
        UnwrapError, UnwrapOptions, Unwrapped, UvProblem, check_uv1, coverage, density, ensure_uv1,
        ensure_uv1_with, gutter, make_uv1,
    },
};
use glam::{Vec2, Vec3};

/// A box with shared vertices: only its angles say that its edges are hard.
fn cuboid(size: Vec3) -> Mesh {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * size;
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
        ..Default::default()
    }
}

/// A smooth sphere of `2 n²` quads.
fn sphere(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=n {
        for j in 0..=2 * n {
            let (theta, phi) = (
                std::f32::consts::PI * i as f32 / n as f32,
                std::f32::consts::PI * (j % (2 * n)) as f32 / n as f32,
            );
            // All vertices of a pole are at one place.
            let ring = if i % n == 0 { 0.0 } else { theta.sin() };
            let p = Vec3::new(ring * phi.sin(), theta.cos(), ring * phi.cos());
            mesh.positions.push(p);
            mesh.normals.push(p.normalize());
        }
    }
    let at = |i: u32, j: u32| i * (2 * n + 1) + j;
    for i in 0..n {
        for j in 0..2 * n {
            mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh
}

fn texels(texels: u32) -> UnwrapOptions {
    UnwrapOptions { texels, ..Default::default() }
}

/// Checks what holds for every result, and returns the new mesh.
fn checked(mesh: &Mesh, unwrapped: &Unwrapped) -> Mesh {
    let new = unwrapped.apply(mesh);
    new.validate().unwrap();
    assert_eq!(check_uv1(&new, 1024), Ok(()));
    assert_eq!(new.triangles.len(), mesh.triangles.len());
    for (new_triangle, old) in new.triangles.iter().zip(&mesh.triangles) {
        let from = new_triangle.map(|i| unwrapped.source[i as usize]);
        let place = |t: [u32; 3]| t.map(|i| mesh.positions[i as usize]);
        assert_eq!(place(from), place(*old), "triangles keep their order and corners");
    }
    new
}

/// The smallest distance in texels between corners of a chart and other charts or the border.
fn smallest_gutter(mesh: &Mesh, charts: &[u32], texels: f32) -> (f32, f32) {
    let (mut between, mut border) = (f32::MAX, f32::MAX);
    for (a, chart) in mesh.triangles.iter().zip(charts) {
        for p in a.map(|i| mesh.uv1[i as usize]) {
            let q = p.min(Vec2::ONE - p);
            border = border.min(q.min_element() * texels);
            for (b, other) in mesh.triangles.iter().zip(charts) {
                if chart != other {
                    let corners = b.map(|i| mesh.uv1[i as usize]);
                    between = between.min(distance(p, corners) * texels);
                }
            }
        }
    }
    (between, border)
}

/// Distance of a point from a triangle's edges in the plane.
fn distance(p: Vec2, corners: [Vec2; 3]) -> f32 {
    let edges = [[0, 1], [1, 2], [2, 0]].map(|e| e.map(|i: usize| corners[i]));
    edges.into_iter().fold(f32::MAX, |nearest, [a, b]| {
        let d = b - a;
        let t = ((p - a).dot(d) / d.length_squared().max(1e-20)).clamp(0.0, 1.0);
        nearest.min(p.distance(a + d * t))
    })
}

#[test]
fn a_box_falls_into_six_charts_with_gutters() {
    let mesh = cuboid(Vec3::new(3.0, 2.0, 1.0));
    let unwrapped = ensure_uv1(&mesh, &texels(32)).unwrap();
    assert_eq!(unwrapped.made, Some(UvProblem::Missing));
    assert_eq!(unwrapped.gutter, 2.0);
    let new = checked(&mesh, &unwrapped);
    assert_eq!(unwrapped.charts.iter().collect::<HashSet<_>>().len(), 6);
    let (between, border) = smallest_gutter(&new, &unwrapped.charts, 32.0);
    // Charts are rasterized to whole texels with two empty ones between them, so their corners are
    // nearly that far apart.
    assert!(between >= 1.99, "{between} texels between charts");
    assert!(border >= 0.99, "{border} texels from the border");
}

#[test]
fn a_set_that_can_be_used_is_kept_with_its_vertices() {
    let mesh = cuboid(Vec3::ONE);
    let new = checked(&mesh, &ensure_uv1(&mesh, &texels(32)).unwrap());
    let again = ensure_uv1(&new, &texels(32)).unwrap();
    assert_eq!(again.made, None);
    assert_eq!(again.apply(&new), new);
    assert_eq!(again.charts.iter().max(), Some(&5));
}

#[test]
fn a_set_that_tiles_is_replaced() {
    let mut mesh = cuboid(Vec3::ONE);
    mesh.uv1 = mesh.positions.iter().map(|p| p.truncate() * 4.0).collect();
    let unwrapped = ensure_uv1(&mesh, &texels(32)).unwrap();
    assert!(matches!(unwrapped.made, Some(UvProblem::Outside { .. })));
    checked(&mesh, &unwrapped);
}

#[test]
fn a_smooth_sphere_needs_few_charts() {
    let mesh = sphere(24);
    let unwrapped = ensure_uv1(&mesh, &texels(64)).unwrap();
    checked(&mesh, &unwrapped);
    let charts = unwrapped.charts.iter().collect::<HashSet<_>>().len();
    // The degenerate triangles at the poles are charts of their own.
    assert!((2..=24 * 4 + 40).contains(&charts), "{charts} charts");
}

#[test]
fn more_charts_than_texels_shrink_the_gutters_and_say_so() {
    // A grid of 20 x 20 boxes for a square of 32 texels.
    let mut mesh = Mesh::default();
    for i in 0..400_u32 {
        let offset = Vec3::new((i % 20) as f32, (i / 20) as f32, 0.0) * 2.0;
        let part = cuboid(Vec3::ONE);
        let base = mesh.positions.len() as u32;
        mesh.positions.extend(part.positions.iter().map(|&p| p + offset));
        mesh.triangles.extend(part.triangles.iter().map(|t| t.map(|i| i + base)));
    }
    let unwrapped = ensure_uv1(&mesh, &texels(32)).unwrap();
    checked(&mesh, &unwrapped);
    assert!(unwrapped.gutter < 1.0, "{}", unwrapped.gutter);
}

/// A bent sheet of `n` x `n` quads with a front and a back at the same place.
fn curtain(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let [u, v] = [i, j].map(|k| k as f32 / n as f32);
            mesh.positions.push(Vec3::new(u, v, 0.1 * (9.0 * u).sin()));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            let [b, c, d] = [a + 1, a + n + 2, a + n + 1];
            mesh.triangles.extend([[a, b, c], [a, c, d], [a, c, b], [a, d, c]]);
        }
    }
    mesh
}

#[test]
fn texels_a_metre_are_what_was_asked_for_everywhere() {
    for (mesh, name) in [
        (cuboid(Vec3::new(3.0, 2.0, 1.0)), "box"),
        (sphere(24), "sphere"),
        (curtain(20), "curtain"),
    ] {
        for padding in [2, 6] {
            let options =
                UnwrapOptions { density: Some(40.0), padding, distortion: 1.5, ..texels(1024) };
            let unwrapped = ensure_uv1(&mesh, &options).unwrap();
            let new = checked(&mesh, &unwrapped);
            let size = unwrapped.size;
            let found = density(&new, size);
            let even = |d: f32| (d / 40.0 - 1.0).abs() < 0.1;
            assert!(even(found.p05) && even(found.p50) && even(found.p95), "{name}: {found:?}");
            let apart = gutter(&new, &unwrapped.charts, size, 8.0);
            assert!(apart >= padding as f32 - 0.01, "{name}: {apart} texels between charts");
            assert_eq!(unwrapped.gutter, padding as f32);
            if padding == 2 {
                assert!(coverage(&new) > 0.5, "{name}: {}", coverage(&new));
            }
        }
        // Where that is too much, as many as there may be.
        let options = UnwrapOptions { density: Some(1e6), ..texels(64) };
        let unwrapped = ensure_uv1(&mesh, &options).unwrap();
        assert!((60..=64).contains(&unwrapped.size.max_element()), "{}", unwrapped.size);
        checked(&mesh, &unwrapped);
    }
}

#[test]
fn fronts_and_backs_at_one_place_are_two_charts() {
    let mesh = curtain(20);
    let unwrapped = ensure_uv1(&mesh, &texels(128)).unwrap();
    checked(&mesh, &unwrapped);
    let charts = unwrapped.charts.iter().max().unwrap() + 1;
    assert!((2..=6).contains(&charts), "{charts}");
    for (t, pair) in unwrapped.charts.chunks(4).enumerate() {
        assert!(pair[0] != pair[2] && pair[1] != pair[3], "quad {t}: {pair:?}");
    }
}

#[test]
fn charts_of_a_set_are_packed_anew_as_they_are() {
    let mesh = cuboid(Vec3::new(3.0, 2.0, 1.0));
    let mut uneven = checked(&mesh, &ensure_uv1(&mesh, &texels(64)).unwrap());
    // The first chart gets a tenth of the texels an edge.
    let first: HashSet<u32> = uneven.triangles[..2].as_flattened().iter().copied().collect();
    let anchor = uneven.uv1[uneven.triangles[0][0] as usize];
    for i in first {
        let uv = &mut uneven.uv1[i as usize];
        *uv = anchor + (*uv - anchor) * 0.1;
    }
    let options = UnwrapOptions { density: Some(20.0), ..texels(512) };
    let unwrapped = make_uv1(&uneven, &options, true, &|| true).unwrap();
    let new = checked(&uneven, &unwrapped);
    assert_eq!(unwrapped.charts.iter().max(), Some(&5));
    assert!(density(&new, unwrapped.size).spread() < 1.01);
    assert!(gutter(&new, &unwrapped.charts, unwrapped.size, 4.0) >= 1.99);
}

#[test]
fn the_result_is_the_same_every_time() {
    let mesh = sphere(12);
    assert_eq!(ensure_uv1(&mesh, &texels(64)), ensure_uv1(&mesh, &texels(64)));
}

#[test]
fn what_cannot_be_unwrapped_says_why() {
    let mesh = sphere(12);
    let small = UnwrapOptions { max_triangles: 10, ..texels(64) };
    let error = ensure_uv1(&mesh, &small).unwrap_err();
    assert_eq!(error, UnwrapError::TooManyTriangles { triangles: 576, limit: 10 });
    assert!(error.to_string().contains("split it"), "{error}");

    let slow = UnwrapOptions { max_time: Duration::ZERO, ..texels(64) };
    assert!(matches!(ensure_uv1(&mesh, &slow), Err(UnwrapError::TooSlow { .. })));
    assert_eq!(ensure_uv1_with(&mesh, &texels(64), &|| false), Err(UnwrapError::Cancelled));

    let mut broken = cuboid(Vec3::ONE);
    broken.positions[3].x = f32::NAN;
    let error = ensure_uv1(&broken, &texels(64));
    assert_eq!(error, Err(UnwrapError::Mesh(MeshProblem::NotFinite { vertex: 3 })));
    assert_eq!(ensure_uv1(&Mesh::default(), &texels(64)), Err(MeshProblem::Empty.into()));
    let mut point = cuboid(Vec3::ONE);
    point.positions.fill(Vec3::ONE);
    assert!(matches!(ensure_uv1(&point, &texels(64)), Err(UnwrapError::Failed(_))));
}

#[test]
fn degenerate_and_broken_topology_is_survived() {
    let mut mesh = cuboid(Vec3::new(1e-6, 3e-6, 2e-6));
    // A triangle without area, one on an edge that then has three faces, a repeated one.
    mesh.triangles.extend([[0, 0, 1], [0, 1, 7], [0, 2, 3]]);
    checked(&mesh, &ensure_uv1(&mesh, &texels(64)).unwrap());
}

#[test]
fn the_demo_scene_brings_its_own_sets() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/scenes/doorway.glb");
    let scene = load_scene(&path, &ImportOptions::default()).unwrap().scene;
    for (id, mesh) in &scene.meshes {
        assert_eq!(check_uv1(mesh, 2048), Ok(()), "{id:?}");
    }
}

/// Needs `FARLIGHT_TEST_DATA`.
#[test]
fn a_real_interior_is_unwrapped_without_overlaps() {
    let Some(folder) = std::env::var_os("FARLIGHT_TEST_DATA") else {
        println!("skipped: FARLIGHT_TEST_DATA does not name the folder with the test data");
        return;
    };
    let path = Path::new(&folder).join("scenes/hotel-room.glb");
    let options = ImportOptions { scale: 0.001, ..Default::default() };
    let scene = load_scene(&path, &options).unwrap().scene;
    for (id, mesh) in &scene.meshes {
        let mut mesh = Mesh::clone(mesh);
        // A part of the largest is enough for a test: the whole takes seconds.
        mesh.triangles.truncate(15_000);
        let mesh = &mesh;
        let start = std::time::Instant::now();
        let unwrapped = ensure_uv1(mesh, &texels(256)).unwrap();
        let time = start.elapsed();
        let new = checked(mesh, &unwrapped);
        let spread = density(&new, unwrapped.size).spread();
        assert!(spread < 1.1, "{id:?}: {spread}");
        let apart = gutter(&new, &unwrapped.charts, unwrapped.size, 3.0);
        assert!(apart >= unwrapped.gutter * 0.95, "{id:?}: {apart} of {}", unwrapped.gutter);
        println!(
            "{id:?}: {} triangles, {} charts, gutter {}, {time:?}",
            mesh.triangles.len(),
            unwrapped.charts.iter().max().unwrap() + 1,
            unwrapped.gutter
        );
    }
}

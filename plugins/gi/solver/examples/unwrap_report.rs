//! How good second UV sets are: of the file, or made.
//!
//!     cargo run -p farlight_gi_solver --example unwrap_report -- SCENE.glb [SCALE] [TEXELS]
//!         [density=TEXELS_PER_METRE] [chart_angle=60] [distortion=4] [padding=2] [thorough=1]
//!         [pictures=FOLDER]
//!
//! TEXELS is the longest edge. Without a density each mesh gets as many texels as that allows. Pictures
//! show the charts, each in its colour.

use std::{path::Path, time::Instant};

use farlight_gi_solver::{
    import::{ImportOptions, load_scene},
    scene::Mesh,
    unwrap::{UnwrapOptions, charts, check_uv1, coverage, density, gutter, make_uv1},
};
use glam::{UVec2, Vec2};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: f32| {
        arguments.get(i).map_or(default, |text| text.parse().expect("a number"))
    };
    let Some(path) = arguments.first() else { panic!("which file?") };
    let options = ImportOptions { scale: number(1, 1.0), ..Default::default() };
    let scene = load_scene(Path::new(path), &options).expect("a glTF file").scene;
    let texels = number(2, 1024.0) as u32;
    let option = |name: &str, default: f32| {
        let value = arguments.iter().find_map(|a| a.strip_prefix(name)?.strip_prefix('='));
        value.map_or(default, |text| text.parse().expect("a number"))
    };
    let defaults = UnwrapOptions::default();
    let options = UnwrapOptions {
        texels,
        density: Some(option("density", 1e6)),
        padding: option("padding", 2.0) as u32,
        distortion: option("distortion", defaults.distortion),
        hard_angle: option("hard_angle", defaults.hard_angle.to_degrees()).to_radians(),
        split_angle: option("split_angle", defaults.split_angle.to_degrees()).to_radians(),
        chart_angle: option("chart_angle", defaults.chart_angle.to_degrees()).to_radians(),
        thorough: option("thorough", 0.0) > 0.0,
        ..defaults
    };
    println!(
        "{arguments:?}\nmesh: triangles charts, texels a metre p05 p50 p95, coverage, gutter, size, seconds"
    );
    let (mut meshes, mut in_use, mut rectangles) = (0, 0.0, 0.0);
    for (id, mesh) in &scene.meshes {
        let start = Instant::now();
        let made = match make_uv1(mesh, &options, false, &|| true) {
            Ok(made) => made,
            Err(error) => {
                println!("{}/{}: {error}", id.0 >> 32, id.0 & 0xffff_ffff);
                continue;
            }
        };
        let seconds = start.elapsed().as_secs_f32();
        rectangles += made.size.as_dvec2().element_product();
        in_use += f64::from(coverage(&made.apply(mesh))) * made.size.as_dvec2().element_product();
        meshes += 1;
        if let Some(folder) = arguments.iter().find_map(|a| a.strip_prefix("pictures=")) {
            let name = format!("mesh{}-{}.png", id.0 >> 32, id.0 & 0xffff_ffff);
            draw(&made.apply(mesh), &made.charts, made.size, &Path::new(folder).join(name));
        }
        let own = charts(mesh);
        let made_mesh = made.apply(mesh);
        for (name, mesh, charts, size) in [
            ("file", mesh.as_ref(), &own, UVec2::splat(texels)),
            ("made", &made_mesh, &made.charts, made.size),
        ] {
            if mesh.uv1.is_empty() {
                continue;
            }
            let found = density(mesh, size);
            println!(
                "{}/{} {name}: {} {}, {:.2} {:.2} {:.2}, {:.1} %, {:.3}, {size}, {seconds:.2} {:?}",
                id.0 >> 32,
                id.0 & 0xffff_ffff,
                mesh.triangles.len(),
                charts.iter().max().map_or(0, |c| c + 1),
                found.p05 / found.p50,
                found.p50,
                found.p95 / found.p50,
                coverage(mesh) * 100.0,
                gutter(mesh, charts, size, 4.0),
                check_uv1(mesh, size.max_element()),
            );
        }
    }
    println!(
        "all: {meshes} meshes, {rectangles} texels, {:.1} % covered",
        in_use / rectangles * 100.0
    );
}

/// Draws charts as they lie in their rectangle.
fn draw(mesh: &Mesh, charts: &[u32], size: UVec2, path: &Path) {
    let mut picture = image::RgbImage::new(size.x, size.y);
    for (triangle, chart) in mesh.triangles.iter().zip(charts) {
        let [a, b, c] = triangle.map(|i| mesh.uv1[i as usize] * size.as_vec2());
        let (low, high) = (a.min(b).min(c).as_uvec2(), a.max(b).max(c).as_uvec2().min(size - 1));
        let hue = chart.wrapping_mul(0x9e37_79b9).to_le_bytes();
        let color = [1, 2, 3].map(|k| 64 + hue[k] / 4 * 3);
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                let p = UVec2::new(x, y).as_vec2() + 0.5;
                let side = |p0: Vec2, p1: Vec2| (p1 - p0).perp_dot(p - p0);
                if side(a, b) >= 0.0 && side(b, c) >= 0.0 && side(c, a) >= 0.0 {
                    picture.put_pixel(x, y, image::Rgb(color));
                }
            }
        }
    }
    picture.save(path).expect("a picture");
}

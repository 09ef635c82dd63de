//! The scene of baked lighting: a study with a window to the north, a desk, a sofa and a floor lamp.
//!
//! Coordinates in metres, y up. Materials are double-sided, so that the sun's shadow maps know the walls
//! too; so nothing may reach far through a wall, where it would be lit from outside.

use super::{
    furniture::{ball, bowl, cube, disc, picture, table, vase},
    glb,
    part::{P, Part, Uv, add, distance},
    shapes::{Ends, block, cap, lathe},
    textures,
};

/// Half the room's edges along x and z, and its height.
const HALF: [f64; 2] = [2.5, 2.0];
const HEIGHT: f64 = 2.7;
/// How far walls, floor and ceiling run through each other: enough to hide the cracks between pixels, and
/// too little for a lightmap.
const OVERLAP: f64 = 1.0 / 4096.0;
/// The window in the wall at -z: left, right, sill, lintel.
const WINDOW: [f64; 4] = [-1.4, 1.4, 0.9, 2.25];
/// How deep the window's reveal is.
const REVEAL: f64 = 0.25;
/// Where the floor lamp stands. Its light is at a height of 1.55 m, inside of the shade.
const LAMP: [f64; 2] = [-1.95, 1.35];

/// Materials, in the order of [`materials`].
#[derive(Clone, Copy)]
enum Look {
    Planks,
    White,
    Plaster,
    Clay,
    Oak,
    Palette,
    Pictures,
    Rug,
}

/// The file.
pub(super) fn glb() -> Vec<u8> {
    glb::write("study", &parts(), &materials(), &textures::study())
}

fn materials() -> Vec<glb::Material> {
    let material = |name, image, roughness| {
        let double_sided = true;
        glb::Material { name, color: [1.0; 3], image, roughness, double_sided }
    };
    let plain = |name, color| glb::Material { color, ..material(name, None, 0.85) };
    vec![
        material("planks", Some(0), 0.55),
        plain("white", [0.82, 0.81, 0.79]),
        plain("plaster", [0.74, 0.69, 0.6]),
        plain("clay", [0.55, 0.2, 0.12]),
        material("oak", Some(1), 0.6),
        material("colours", Some(2), 0.6),
        material("pictures", Some(3), 0.6),
        material("rug", Some(4), 0.95),
    ]
}

fn parts() -> Vec<Part> {
    vec![
        floor("floor", Look::Planks, 0.0),
        floor("ceiling", Look::White, HEIGHT),
        walls(),
        west_wall(),
        window(),
        woodwork(),
        sofa(),
        objects(),
        lamp(),
        pictures(),
        rug(),
    ]
}

/// A parallelogram from `origin` along `u` and `v`, facing `u x v`, at a place in the current chart.
fn face(part: &mut Part, origin: P, u: P, v: P, [s, t]: [f64; 2], uv: Uv) {
    let (w, h) = (distance(u, [0.0; 3]), distance(v, [0.0; 3]));
    let corners = [
        (origin, [s, t]),
        (add(origin, u), [s + w, t]),
        (add(add(origin, u), v), [s + w, t + h]),
        (add(origin, v), [s, t + h]),
    ];
    part.face(&corners, uv);
}

fn floor(name: &'static str, look: Look, y: f64) -> Part {
    let mut part = Part::new(name, look as usize);
    part.chart();
    let [x, z] = HALF.map(|half| half + OVERLAP);
    let (along_x, along_z) = ([2.0 * x, 0.0, 0.0], [0.0, 0.0, 2.0 * z]);
    let (u, v) = if y > 0.0 { (along_x, along_z) } else { (along_z, along_x) };
    let uv = if y > 0.0 { Uv::Tile(1.0) } else { Uv::TileAcross(1.28) };
    face(&mut part, [-x, y, -z], u, v, [0.0; 2], uv);
    part
}

/// North with the hole of the window and its reveal, east and south.
fn walls() -> Part {
    let mut part = Part::new("walls", Look::Plaster as usize);
    let uv = Uv::Tile(1.0);
    let [x, z] = HALF;
    let [left, right, sill, lintel] = WINDOW;
    part.chart();
    let top = HEIGHT + OVERLAP;
    let mut piece = |x0: f64, x1: f64, y0: f64, y1: f64| {
        let (u, v) = ([x1 - x0, 0.0, 0.0], [0.0, y1 - y0, 0.0]);
        face(&mut part, [x0, y0, -z], u, v, [x0 + x, y0 + OVERLAP], uv);
    };
    piece(-x - OVERLAP, left, -OVERLAP, top);
    piece(right, x + OVERLAP, -OVERLAP, top);
    piece(left - OVERLAP, right + OVERLAP, -OVERLAP, sill);
    piece(left - OVERLAP, right + OVERLAP, lintel, top);
    let up = [0.0, HEIGHT + 2.0 * OVERLAP, 0.0];
    part.chart();
    let corner = [x, -OVERLAP, -z - OVERLAP];
    face(&mut part, corner, [0.0, 0.0, 2.0 * (z + OVERLAP)], up, [0.0; 2], uv);
    part.chart();
    let corner = [x + OVERLAP, -OVERLAP, z];
    face(&mut part, corner, [-2.0 * (x + OVERLAP), 0.0, 0.0], up, [0.0; 2], uv);
    // Sill, lintel, jambs.
    let (width, height, outer) = (right - left, lintel - sill, -z - REVEAL);
    let across = [width, 0.0, 0.0];
    for (corner, u, v) in [
        ([left, sill, outer], [0.0, 0.0, REVEAL], across),
        ([left, lintel, outer], across, [0.0, 0.0, REVEAL]),
        ([left, sill, -z], [0.0, 0.0, -REVEAL], [0.0, height, 0.0]),
        ([right, sill, outer], [0.0, 0.0, REVEAL], [0.0, height, 0.0]),
    ] {
        part.chart();
        face(&mut part, corner, u, v, [0.0; 2], uv);
    }
    part
}

fn west_wall() -> Part {
    let mut part = Part::new("west_wall", Look::Clay as usize);
    part.chart();
    let [x, z] = HALF;
    let along = [0.0, 0.0, -2.0 * (z + OVERLAP)];
    let corner = [-x, -OVERLAP, z + OVERLAP];
    face(&mut part, corner, along, [0.0, HEIGHT + 2.0 * OVERLAP, 0.0], [0.0; 2], Uv::Tile(1.0));
    part
}

/// Frame and bars; the glass is open.
fn window() -> Part {
    let mut part = Part::new("window", Look::White as usize);
    let uv = Uv::Tile(1.0);
    let [left, right, sill, lintel] = WINDOW;
    let (back, front) = (-HALF[1] - 0.17, -HALF[1] - 0.11);
    let edge = 0.05;
    for (x, width) in [(left - 0.005, edge), (-0.025, edge), (right + 0.005 - edge, edge)] {
        let (low, high) = ([x, sill - 0.005, back], [x + width, lintel + 0.005, front]);
        block(&mut part, low, high, 0.006, Ends::None, uv);
    }
    for (y, height) in [(sill - 0.005, edge), (1.78, 0.04), (lintel + 0.005 - edge, edge)] {
        let (low, high) = ([left, y, back + 0.005], [right, y + height, front - 0.005]);
        block(&mut part, low, high, 0.006, Ends::Both, uv);
    }
    // The board on the sill.
    let low = [left - 0.06, sill - 0.03, -HALF[1] - 0.1];
    let high = [right + 0.06, sill + 0.012, -HALF[1] + 0.07];
    block(&mut part, low, high, 0.01, Ends::Both, uv);
    part
}

/// A desk before the window, a stool, and a sideboard on the east wall.
fn woodwork() -> Part {
    let mut part = Part::new("woodwork", Look::Oak as usize);
    let wood = Uv::Tile(1.0);
    table(&mut part, [-0.95, 0.75], [-1.72, -1.0], 0.74, 0.04, 0.06, wood);
    table(&mut part, [-0.35, 0.05], [-0.85, -0.5], 0.45, 0.04, 0.05, wood);
    block(&mut part, [2.02, 0.1, -0.75], [2.48, 0.78, 0.95], 0.012, Ends::Both, wood);
    for z in [-0.65, 0.79] {
        for x in [2.06, 2.38] {
            block(&mut part, [x, 0.0, z], [x + 0.06, 0.11, z + 0.06], 0.008, Ends::None, wood);
        }
    }
    part
}

/// A sofa along the south wall.
fn sofa() -> Part {
    let mut part = Part::new("sofa", Look::Palette as usize);
    let (linen, slate) = (Uv::Swatch(12), Uv::Swatch(13));
    block(&mut part, [-1.2, 0.06, 1.15], [0.9, 0.30, 1.94], 0.02, Ends::Both, linen);
    for (x0, x1) in [(-1.02, -0.16), (-0.14, 0.72)] {
        block(&mut part, [x0, 0.29, 1.13], [x1, 0.44, 1.7], 0.035, Ends::Top, linen);
    }
    block(&mut part, [-1.18, 0.29, 1.66], [0.88, 0.80, 1.95], 0.05, Ends::Top, linen);
    for x in [-1.22, 0.71] {
        block(&mut part, [x, 0.05, 1.14], [x + 0.21, 0.58, 1.94], 0.04, Ends::Both, linen);
    }
    for x in [-1.14, 0.77] {
        for z in [1.2, 1.82] {
            block(&mut part, [x, 0.0, z], [x + 0.06, 0.07, z + 0.06], 0.008, Ends::None, slate);
        }
    }
    block(&mut part, [-0.95, 0.43, 1.42], [-0.5, 0.72, 1.62], 0.06, Ends::Both, Uv::Swatch(1));
    part
}

/// Coloured things on desk, sideboard and floor.
fn objects() -> Part {
    let mut part = Part::new("objects", Look::Palette as usize);
    let part_ref = &mut part;
    let desk = 0.735;
    cube(part_ref, [-0.88, desk, -1.6], [0.3, 0.04, 0.22], 2);
    cube(part_ref, [-0.86, desk + 0.035, -1.58], [0.25, 0.035, 0.19], 0);
    cube(part_ref, [-0.83, desk + 0.065, -1.57], [0.22, 0.03, 0.17], 4);
    vase(part_ref, [0.55, desk, -1.5], 0.8, 6);
    bowl(part_ref, [0.1, desk, -1.35], 5);
    let board = 0.775;
    cube(part_ref, [2.1, board, -0.6], [0.28, 0.3, 0.3], 3);
    cube(part_ref, [2.12, board, -0.24], [0.22, 0.16, 0.16], 1);
    vase(part_ref, [2.25, board, 0.62], 1.1, 4);
    cube(part_ref, [1.75, 0.0, -1.75], [0.45, 0.4, 0.45], 7);
    // A small tree beside the window.
    let pot = [-2.05, 0.0, -1.5];
    let profile =
        [[0.13, 0.30], [0.17, 0.34], [0.19, 0.34], [0.195, 0.29], [0.17, 0.28], [0.13, 0.0]];
    lathe(part_ref, pot, &profile, 16, Uv::Swatch(4));
    lathe(part_ref, pot, &[[0.02, 0.95], [0.026, 0.28]], 8, Uv::Swatch(13));
    ball(part_ref, [pot[0], 1.12, pot[2]], 0.3, 8);
    disc(part_ref, [pot[0], 0.295, pot[2]], 0.15, 13);
    part
}

/// A floor lamp whose shade is open above and below.
fn lamp() -> Part {
    let mut part = Part::new("lamp", Look::Palette as usize);
    let foot = [LAMP[0], 0.0, LAMP[1]];
    lathe(&mut part, foot, &[[0.03, 0.035], [0.15, 0.02], [0.155, 0.0]], 20, Uv::Swatch(13));
    lathe(&mut part, foot, &[[0.012, 1.45], [0.014, 0.03]], 8, Uv::Swatch(13));
    disc(&mut part, [foot[0], 1.45, foot[2]], 0.012, 13);
    // Outside, and inside from below.
    let shade = [[0.13, 1.74], [0.22, 1.42], [0.215, 1.42], [0.125, 1.74]];
    lathe(&mut part, foot, &shade, 24, Uv::Swatch(10));
    part
}

fn pictures() -> Part {
    let mut part = Part::new("pictures", Look::Pictures as usize);
    picture(&mut part, [-0.55, 1.6, HALF[1]], [0.6, 0.75], -1.0, 1);
    picture(&mut part, [0.35, 1.6, HALF[1]], [0.6, 0.75], -1.0, 2);
    part
}

fn rug() -> Part {
    let mut part = Part::new("rug", Look::Rug as usize);
    let (low, high) = ([-1.2, 0.0, -0.55], [1.3, 0.014, 1.0]);
    cap(&mut part, low, high, 0.018, true, Uv::Image([0.0, 0.0, 1.0, 1.0], [2.5, 1.55]));
    part
}

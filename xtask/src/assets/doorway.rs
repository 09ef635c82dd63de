//! The demo scene: a bright room and a dark room with a narrow doorway between them.
//!
//! Coordinates in metres, y up. The wall between the rooms is 0.2 m thick, round x = 0. Where walls,
//! floors and ceilings meet they run 2 cm through each other, so that no light finds a gap. Surfaces
//! show their front to the inside only: seen from outside, a renderer that culls back faces looks
//! into the rooms.

use super::{
    furniture, glb,
    part::{P, Part, Uv, add, scale},
    shapes::{self, Ends},
    textures,
};

/// Half the thickness of the wall between the rooms.
const WALL: f64 = 0.1;
/// Length of a room along x; along z it reaches from -DEPTH to DEPTH.
const LENGTH: f64 = 5.0;
const DEPTH: f64 = 2.5;
const HEIGHT: f64 = 3.0;
/// How far surfaces run through each other.
const OVERLAP: f64 = 0.02;
/// The clear opening of the doorway.
const DOOR: [f64; 2] = [0.15, 1.05];
const DOOR_HEIGHT: f64 = 2.05;
/// The hole in the wall is larger by this; the frame covers it.
const GAP: f64 = 0.03;

/// Materials, in the order of [`materials`].
#[derive(Clone, Copy)]
pub(super) enum Look {
    Planks,
    Ceiling,
    BrightWalls,
    Tiles,
    DarkWalls,
    Paint,
    Oak,
    Walnut,
    Palette,
    Stone,
    Pictures,
    Rug,
}

/// The file.
pub(super) fn glb() -> Vec<u8> {
    let images = textures::all(&profile_lengths());
    glb::write("doorway", &parts(), &materials(), &images)
}

fn parts() -> Vec<Part> {
    let mut parts = Vec::new();
    let bright = [-WALL - LENGTH, -WALL];
    let dark = [WALL, WALL + LENGTH];
    parts.push(flat("bright_floor", Look::Planks, bright, 0.0, Uv::Tile(1.28)));
    parts.push(flat("bright_ceiling", Look::Ceiling, bright, HEIGHT, Uv::Tile(1.0)));
    parts.push(walls("bright_walls", Look::BrightWalls, bright, 1));
    parts.push(flat("dark_floor", Look::Tiles, dark, 0.0, Uv::Tile(1.2)));
    parts.push(flat("dark_ceiling", Look::Ceiling, dark, HEIGHT, Uv::Tile(1.0)));
    parts.push(walls("dark_walls", Look::DarkWalls, dark, 3));
    parts.push(door_frame());
    let mut oak = furniture::bright_woodwork();
    let low = [-0.135, -0.03, DOOR[0] - 0.02];
    shapes::block(
        &mut oak,
        low,
        [0.135, 0.012, DOOR[1] + 0.02],
        0.008,
        Ends::Top,
        Uv::TileAcross(1.0),
    );
    parts.push(oak);
    parts.push(furniture::bright_objects());
    parts.push(furniture::dark_woodwork());
    parts.push(furniture::dark_objects());
    parts.push(furniture::stone());
    parts.push(furniture::pictures());
    parts.push(furniture::rug());
    parts
}

fn materials() -> Vec<glb::Material> {
    let material = |name, image, roughness| {
        let double_sided = false;
        glb::Material { name, color: [1.0; 3], image, roughness, double_sided }
    };
    vec![
        material("planks", Some(0), 0.55),
        glb::Material { color: [0.8, 0.79, 0.77], ..material("ceiling", None, 0.9) },
        material("bright walls", Some(1), 0.85),
        material("tiles", Some(2), 0.45),
        material("dark walls", Some(3), 0.85),
        glb::Material { color: [0.74, 0.7, 0.62], ..material("paint", None, 0.5) },
        material("oak", Some(4), 0.6),
        material("walnut", Some(5), 0.6),
        material("colours", Some(6), 0.5),
        glb::Material { color: [0.66, 0.64, 0.6], ..material("stone", None, 0.7) },
        material("pictures", Some(7), 0.6),
        material("rug", Some(8), 0.95),
    ]
}

/// A floor (y = 0) or a ceiling.
fn flat(name: &'static str, look: Look, x: [f64; 2], y: f64, uv: Uv) -> Part {
    let mut part = Part::new(name, look as usize);
    part.chart();
    let (x0, x1) = (x[0] - OVERLAP, x[1] + OVERLAP);
    let z = DEPTH + OVERLAP;
    let corner = |x: f64, z: f64| ([x, y, z], [x - x0, z]);
    let mut corners = [corner(x0, z), corner(x1, z), corner(x1, -z), corner(x0, -z)];
    if y > 0.0 {
        corners.reverse();
    }
    part.face(&corners, uv);
    part
}

/// Crown, wall, dado rail, wainscot and skirting as distance from the wall and height.
const PROFILE: [[f64; 2]; 14] = [
    [0.10, HEIGHT + OVERLAP],
    [0.10, 2.955],
    [0.075, 2.93],
    [0.03, 2.885],
    [0.02, 2.86],
    [0.0, 2.86],
    [0.0, DOOR_HEIGHT + GAP],
    [0.0, 0.97],
    [0.025, 0.95],
    [0.025, 0.905],
    [0.0, 0.885],
    [0.0, 0.15],
    [0.015, 0.13],
    [0.015, -OVERLAP],
];

/// Length along the profile at each of its points, as fractions of the whole: rows of the texture.
fn profile_lengths() -> Vec<f64> {
    let mut lengths = vec![0.0];
    for p in PROFILE.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]));
    }
    let whole = lengths[lengths.len() - 1];
    lengths.iter().map(|l| l / whole).collect()
}

/// Four walls, each a chart and a quarter of the texture: north (-z), east (+x), south, west. `door`
/// is the wall with the hole.
fn walls(name: &'static str, look: Look, x: [f64; 2], door: usize) -> Part {
    let mut part = Part::new(name, look as usize);
    let (x0, x1) = (x[0], x[1]);
    // Corner, direction and inward normal; seen from inside the wall runs from left to right.
    let sides: [(P, P, P); 4] = [
        ([x0, 0.0, -DEPTH], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ([x1, 0.0, -DEPTH], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]),
        ([x1, 0.0, DEPTH], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
        ([x0, 0.0, DEPTH], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]),
    ];
    let height = {
        let p = PROFILE.windows(2);
        p.map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum::<f64>()
    };
    for (k, (corner, along, normal)) in sides.into_iter().enumerate() {
        let mut cuts = vec![0.0, LENGTH];
        if k == door {
            // The wall runs along +z on the east side and along -z on the west side.
            let hole = [DOOR[0] - GAP, DOOR[1] + GAP].map(|z| (z - corner[2]) * along[2]);
            cuts.splice(1..1, [hole[0].min(hole[1]), hole[0].max(hole[1])]);
        }
        let last = cuts.len() - 1;
        let (u0, u1) = ((k as f64 + 0.1) / 4.0, (k as f64 + 0.9) / 4.0);
        part.sweep(
            &PROFILE,
            cuts.len(),
            // t runs down from the top, as the rows of the image do.
            Uv::Image([u0, 1.0, u1, 0.0], [LENGTH, height]),
            |j, [out, y]| {
                // Mitred corners.
                let s = match j {
                    0 => out,
                    _ if j == last => LENGTH - out,
                    _ => cuts[j],
                };
                let wall = add(corner, add(scale(along, s), scale(normal, out)));
                [wall[0], y, wall[2]]
            },
            |i, j| !(k == door && j == 1 && PROFILE[i][1] < DOOR_HEIGHT + GAP + 1e-6),
        );
    }
    part
}

/// Casings on both sides and the lining between them: one moulding round the opening.
fn door_frame() -> Part {
    let mut part = Part::new("door_frame", Look::Paint as usize);
    let (face, edge) = (WALL + 0.035, 0.09);
    // Position across the wall, distance from the clear opening.
    let half = [[face, 0.008], [face, edge - 0.012], [face - 0.012, edge], [WALL - 0.01, edge]];
    let mut profile: Vec<_> = half.iter().rev().map(|&[x, off]| [-x, off]).collect();
    profile.push([-face + 0.008, 0.0]);
    profile.push([face - 0.008, 0.0]);
    profile.extend(half);
    part.sweep(
        &profile,
        4,
        Uv::Tile(1.0),
        |j, [x, off]| match j {
            0 => [x, -OVERLAP, DOOR[0] - off],
            1 => [x, DOOR_HEIGHT + off, DOOR[0] - off],
            2 => [x, DOOR_HEIGHT + off, DOOR[1] + off],
            _ => [x, -OVERLAP, DOOR[1] + off],
        },
        |_, _| true,
    );
    part
}

#[cfg(test)]
mod tests {
    use crate::assets::pack;

    #[test]
    fn all_parts_fit_one_lightmap_page() {
        let sizes: Vec<_> =
            super::parts().iter().map(|part| part.lay_out().size.map(|edge| edge + 2)).collect();
        let texels: usize = sizes.iter().map(|[w, h]| w * h).sum();
        println!("{sizes:?}: {texels} of {} texels", 128 * 128);
        assert!(pack::arrange(&sizes, 128).is_some(), "they do not fit 128 x 128 texels");
    }
}

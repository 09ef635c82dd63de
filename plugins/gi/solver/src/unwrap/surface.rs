//! The surface that a triangle list means: which triangles are neighbours, and where charts must end.
//!
//! The unwrapper joins vertices at equal positions, and takes edges of more than two faces, and edges whose
//! vertices are split, for seams. Files have sheets with a front and a back at the same place, parts
//! that touch, and vertices that are split for their textures: none of these is a reason to cut. So
//! vertices are joined here, each sheet by itself.

use std::collections::HashMap;

use glam::Vec3;

use super::{UnwrapOptions, charts::Sets};
use crate::scene::Mesh;

/// Cosine of the angle of faces that lie on each other: front and back of a sheet are no neighbours, even
/// at its border.
const FOLDED: f32 = -0.9999;
/// More faces at one edge are not told apart.
const MOST_FACES: usize = 16;

/// What the unwrapper is given.
pub(super) struct Surface {
    /// Vertices; those that must not be joined have different positions, if only by rounding.
    pub(super) positions: Vec<[f32; 3]>,
    /// Three vertices a triangle, in the mesh's order.
    pub(super) corners: Vec<u32>,
    /// The edges that charts must not cross: sharp ones, and those where smooth shading ends.
    pub(super) seams: Vec<[bool; 3]>,
    /// Into how many pieces seams cut the surface.
    pub(super) pieces: u32,
}

/// A triangle's side.
#[derive(Clone, Copy)]
struct Side {
    triangle: u32,
    k: u8,
    /// Whether it runs from the smaller to the larger vertex.
    forward: bool,
}

impl Surface {
    /// Of a mesh whose positions are given in the unit cube.
    pub(super) fn new(mesh: &Mesh, positions: &[[f32; 3]], options: &UnwrapOptions) -> Self {
        let mut ids = HashMap::with_capacity(positions.len());
        let mut places: Vec<[f32; 3]> = Vec::new();
        let joined: Vec<u32> = positions
            .iter()
            .map(|p| {
                *ids.entry(p.map(f32::to_bits)).or_insert_with(|| {
                    places.push(*p);
                    places.len() as u32 - 1
                })
            })
            .collect();
        let normals: Vec<Vec3> = mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| Vec3::from(positions[i as usize]));
                (b - a).cross(c - a).normalize_or_zero()
            })
            .collect();
        let count = mesh.triangles.len();
        let mut surface = Self {
            positions: places,
            corners: Vec::new(),
            seams: vec![[false; 3]; count],
            pieces: 0,
        };
        let mut pieces = Sets::new(count);
        // Corners of triangles around one vertex of one sheet.
        let mut fans = Sets::new(3 * count);
        let (hard, split) = (options.hard_angle.cos(), options.split_angle.cos());
        for [a, b] in neighbours(mesh, &joined, &normals) {
            let [ta, tb] = [a, b].map(|side| side.triangle as usize);
            let cos = normals[ta].dot(normals[tb]);
            // A face without an area has no angle.
            let flat = normals[ta] == Vec3::ZERO || normals[tb] == Vec3::ZERO;
            let sharp = cos < hard || (cos < split && normals_differ(mesh, a, b));
            if sharp && !flat {
                surface.seams[ta][a.k as usize] = true;
                surface.seams[tb][b.k as usize] = true;
            } else {
                pieces.join(a.triangle, b.triangle);
            }
            let ends = |side: Side| {
                let k = u32::from(side.k);
                [3 * side.triangle + k, 3 * side.triangle + (k + 1) % 3]
            };
            let ([a0, a1], [b0, b1]) = (ends(a), ends(b));
            fans.join(a0, b1);
            fans.join(a1, b0);
        }
        surface.pieces = pieces.count();
        surface.part(mesh, &joined, &mut fans);
        surface
    }

    /// Gives each fan of triangles around a place a vertex of its own.
    fn part(&mut self, mesh: &Mesh, joined: &[u32], fans: &mut Sets) {
        // Of each place: the fan that has it, and how many others came.
        let mut owners: Vec<Option<(u32, u32)>> = vec![None; self.positions.len()];
        let mut others: HashMap<u32, u32> = HashMap::new();
        for (corner, &vertex) in mesh.triangles.as_flattened().iter().enumerate() {
            let place = joined[vertex as usize];
            let fan = fans.root(corner as u32);
            let Some((owner, count)) = &mut owners[place as usize] else {
                owners[place as usize] = Some((fan, 0));
                self.corners.push(place);
                continue;
            };
            if *owner == fan {
                self.corners.push(place);
                continue;
            }
            let vertex = *others.entry(fan).or_insert_with(|| {
                *count += 1;
                // Coordinates are 0..1: the next numbers, far below what matters for a texel.
                let [x, y, z] = self.positions[place as usize];
                self.positions.push([f32::from_bits(x.to_bits() + *count), y, z]);
                self.positions.len() as u32 - 1
            });
            self.corners.push(vertex);
        }
    }
}

/// Pairs of sides that run along one edge in opposite directions. Of more than two, those whose faces go
/// on most straightly belong together, which keeps fronts from backs.
fn neighbours(mesh: &Mesh, joined: &[u32], normals: &[Vec3]) -> Vec<[Side; 2]> {
    let mut sides: Vec<([u32; 2], Side)> = Vec::with_capacity(3 * mesh.triangles.len());
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let [a, b] = [triangle[k], triangle[(k + 1) % 3]].map(|i| joined[i as usize]);
            if a != b {
                let side = Side { triangle: t as u32, k: k as u8, forward: a < b };
                sides.push(([a.min(b), a.max(b)], side));
            }
        }
    }
    sides.sort_by_key(|(edge, side)| (*edge, side.triangle, side.k));
    let cos = |a: Side, b: Side| normals[a.triangle as usize].dot(normals[b.triangle as usize]);
    let mut pairs = Vec::with_capacity(sides.len() / 2);
    for edge in sides.chunk_by(|a, b| a.0 == b.0) {
        match *edge {
            [] | [_] => {}
            [(_, a), (_, b)] => {
                if a.forward != b.forward && cos(a, b) > FOLDED {
                    pairs.push([a, b]);
                }
            }
            _ if edge.len() > MOST_FACES => {}
            _ => {
                let mut found = Vec::new();
                for (i, (_, a)) in edge.iter().enumerate() {
                    for (j, (_, b)) in edge.iter().enumerate().skip(i + 1) {
                        let cos = cos(*a, *b);
                        if a.forward != b.forward && cos > FOLDED {
                            found.push((cos, i, j));
                        }
                    }
                }
                found.sort_by(|a, b| b.0.total_cmp(&a.0));
                let mut taken = [false; MOST_FACES];
                for (_, i, j) in found {
                    if !taken[i] && !taken[j] {
                        (taken[i], taken[j]) = (true, true);
                        pairs.push([edge[i].1, edge[j].1]);
                    }
                }
            }
        }
    }
    pairs
}

/// Whether shading normals at an edge's ends depend on the face. The sides run in opposite directions.
fn normals_differ(mesh: &Mesh, a: Side, b: Side) -> bool {
    if mesh.normals.is_empty() {
        // Then shading is flat.
        return true;
    }
    let ends = |side: Side| {
        let triangle = mesh.triangles[side.triangle as usize];
        let k = side.k as usize;
        [triangle[k], triangle[(k + 1) % 3]]
    };
    let ([a0, a1], [b0, b1]) = (ends(a), ends(b));
    let differ = |i: u32, j: u32| {
        let [n, m] = [i, j].map(|i| mesh.normals[i as usize].normalize_or_zero());
        i != j && n.dot(m) < 0.97
    };
    differ(a0, b1) || differ(a1, b0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Surface {
        let mesh = Mesh {
            positions: positions.iter().map(|&p| p.into()).collect(),
            triangles: triangles.to_vec(),
            ..Default::default()
        };
        Surface::new(&mesh, positions, &UnwrapOptions::default())
    }

    const QUADS: [[f32; 3]; 6] = [
        [0.0, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.5, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ];
    const STRIP: [[u32; 3]; 4] = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];

    #[test]
    fn a_sheet_with_two_sides_is_two_sheets() {
        let back = STRIP.map(|[a, b, c]| [a, c, b]);
        let both = surface(&QUADS, &[STRIP, back].concat());
        assert_eq!(both.pieces, 2);
        assert!(both.seams.as_flattened().iter().all(|seam| !seam));
        // The back has vertices of its own, at nearly the same places.
        assert_eq!(both.positions.len(), 12);
        assert!(both.corners[..12].iter().all(|&i| i < 6));
        assert!(both.corners[12..].iter().all(|&i| i >= 6));
        for (front, back) in both.corners[..12].iter().zip([0, 2, 1, 3, 5, 4, 6, 8, 7, 9, 11, 10]) {
            let [p, q] = [*front, both.corners[12 + back]].map(|i| both.positions[i as usize]);
            assert!(Vec3::from(p).distance(q.into()) < 1e-6 && p != q, "{p:?} {q:?}");
        }
    }

    #[test]
    fn split_vertices_are_one_surface_and_touching_parts_are_not() {
        // Each triangle has vertices of its own.
        let corners = STRIP.as_flattened();
        let places: Vec<[f32; 3]> = corners.iter().map(|&i| QUADS[i as usize]).collect();
        let apart: Vec<[u32; 3]> = (0..4).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let one = surface(&places, &apart);
        assert_eq!((one.pieces, one.positions.len()), (1, 6));
        // Two triangles that meet in a corner.
        let two = surface(&QUADS, &[[0, 1, 3], [1, 2, 5]]);
        assert_eq!((two.pieces, two.positions.len()), (2, 7));
    }

    #[test]
    fn a_wall_on_a_floor_leaves_the_floor_whole() {
        let mut places = QUADS.to_vec();
        places.extend([[0.5, 0.0, 1.0], [0.5, 1.0, 1.0]]);
        let all = surface(&places, &[STRIP.as_slice(), &[[1, 4, 7], [1, 7, 6]]].concat());
        assert_eq!(all.pieces, 2);
        assert!(all.seams[..4].as_flattened().iter().all(|seam| !seam));
    }
}

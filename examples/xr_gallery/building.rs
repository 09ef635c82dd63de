//! Rooms that are carved out of a block: what is not carved is wall, so that nothing leaks.
//!
//! All edges lie on one grid, and every surface is cut along all of it: neighbours share their corners,
//! and no picture shows cracks between them.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};

/// A box in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid3 {
    /// The corner with the least x, y and z.
    pub min: Vec3,
    /// The opposite one.
    pub max: Vec3,
}

impl Cuboid3 {
    /// From two corners.
    pub const fn new(min: [f32; 3], max: [f32; 3]) -> Self {
        Self { min: Vec3::from_array(min), max: Vec3::from_array(max) }
    }

    /// Whether a place is in it; its faces are in it too.
    pub fn contains(&self, place: Vec3) -> bool {
        place.cmpge(self.min).all() && place.cmple(self.max).all()
    }
}

/// A part of the inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Space(pub u8);

/// What a cell of the grid is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cell {
    Outside,
    Wall,
    Air(Space),
}

/// A block with spaces carved out of it.
#[derive(Clone, Debug)]
pub struct Building {
    /// Where the grid is cut, along x, y and z.
    cuts: [Vec<f32>; 3],
    cells: Vec<Cell>,
}

/// A plane part of the inside.
#[derive(Clone, Debug)]
pub struct Surface {
    /// The space that it faces.
    pub space: Space,
    /// Where it faces: along an axis of the world.
    pub normal: Vec3,
    /// The plane: its coordinate along the normal's axis.
    pub at: f32,
    /// Its triangles. UV set 0 is in metres, u to the right and v down as seen from inside (on floors
    /// and ceilings u is x, v is z); UV set 1 fills the unit square.
    pub mesh: Mesh,
}

/// One of the grid's squares that are seen.
struct Square {
    corners: [Vec3; 4],
}

impl Building {
    /// Carves spaces out of a block; each has a number, and several boxes may have the same.
    pub fn carve(block: Cuboid3, spaces: &[(Space, Cuboid3)]) -> Self {
        let cuts = std::array::from_fn(|axis| {
            let mut cuts: Vec<f32> = spaces
                .iter()
                .flat_map(|(_, space)| [space.min[axis], space.max[axis]])
                .chain([block.min[axis], block.max[axis]])
                .collect();
            cuts.sort_unstable_by(f32::total_cmp);
            cuts.dedup();
            cuts
        });
        let mut building = Self { cuts, cells: Vec::new() };
        let size = building.size();
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let middle = building.middle([x, y, z]);
                    let carved = spaces.iter().find(|(_, space)| space.contains(middle));
                    building.cells.push(match carved {
                        Some((space, _)) => Cell::Air(*space),
                        None if block.contains(middle) => Cell::Wall,
                        None => Cell::Outside,
                    });
                }
            }
        }
        building
    }

    fn size(&self) -> [usize; 3] {
        self.cuts.each_ref().map(|cuts| cuts.len() - 1)
    }

    fn middle(&self, cell: [usize; 3]) -> Vec3 {
        let at =
            |axis: usize| 0.5 * (self.cuts[axis][cell[axis]] + self.cuts[axis][cell[axis] + 1]);
        Vec3::new(at(0), at(1), at(2))
    }

    fn cell(&self, cell: [isize; 3]) -> Cell {
        let size = self.size();
        let inside = (0..3).all(|axis| (0..size[axis] as isize).contains(&cell[axis]));
        if !inside {
            return Cell::Outside;
        }
        let [x, y, z] = cell.map(|index| index as usize);
        self.cells[(z * size[1] + y) * size[0] + x]
    }

    fn at(&self, place: Vec3) -> Cell {
        let cell = std::array::from_fn(|axis| {
            self.cuts[axis].partition_point(|&cut| cut <= place[axis]) as isize - 1
        });
        self.cell(cell)
    }

    /// Whether a place is inside of a wall, a floor or a ceiling.
    pub fn is_wall(&self, place: Vec3) -> bool {
        self.at(place) == Cell::Wall
    }

    /// The space that a place is in.
    pub fn space(&self, place: Vec3) -> Option<Space> {
        match self.at(place) {
            Cell::Air(space) => Some(space),
            _ => None,
        }
    }

    /// What is seen from inside: a mesh for each plane of each space.
    pub fn surfaces(&self) -> Vec<Surface> {
        let mut found: Vec<((Space, usize, bool, u32), Vec<Square>)> = Vec::new();
        self.faces(
            |cell| match cell {
                Cell::Air(space) => Some(space),
                _ => None,
            },
            |space, axis, positive, at, square| {
                let key = (space, axis, positive, at.to_bits());
                match found.iter_mut().find(|(known, _)| *known == key) {
                    Some((_, squares)) => squares.push(square),
                    None => found.push((key, vec![square])),
                }
            },
        );
        found
            .into_iter()
            .map(|((space, axis, positive, at), squares)| {
                let mut normal = Vec3::ZERO;
                normal[axis] = if positive { 1.0 } else { -1.0 };
                Surface { space, normal, at: f32::from_bits(at), mesh: mesh(&squares, normal) }
            })
            .collect()
    }

    /// What is seen from outside, which keeps the sun out.
    pub fn shell(&self) -> Mesh {
        let mut squares: [Vec<Square>; 6] = Default::default();
        self.faces(
            |cell| (cell == Cell::Outside).then_some(()),
            |(), axis, positive, _, square| squares[axis * 2 + usize::from(positive)].push(square),
        );
        let mut shell: Option<Mesh> = None;
        for (side, squares) in squares.iter().enumerate().filter(|(_, squares)| !squares.is_empty())
        {
            let mut normal = Vec3::ZERO;
            normal[side / 2] = if side % 2 == 1 { 1.0 } else { -1.0 };
            let part = mesh(squares, normal);
            match &mut shell {
                Some(shell) => drop(shell.merge(&part)),
                None => shell = Some(part),
            }
        }
        shell.unwrap_or_else(|| mesh(&[], Vec3::Y))
    }

    /// All squares between walls and cells that count.
    fn faces<T>(
        &self,
        counts: impl Fn(Cell) -> Option<T>,
        mut found: impl FnMut(T, usize, bool, f32, Square),
    ) {
        let size = self.size().map(|size| size as isize);
        for z in -1..=size[2] {
            for y in -1..=size[1] {
                for x in -1..=size[0] {
                    for axis in 0..3 {
                        for positive in [false, true] {
                            let here = [x, y, z];
                            let mut behind = here;
                            behind[axis] += if positive { -1 } else { 1 };
                            if self.cell(behind) != Cell::Wall {
                                continue;
                            }
                            let Some(counted) = counts(self.cell(here)) else { continue };
                            let wall = behind.map(|index| index as usize);
                            let at = self.cuts[axis][wall[axis] + usize::from(positive)];
                            found(
                                counted,
                                axis,
                                positive,
                                at,
                                self.square(wall, axis, positive, at),
                            );
                        }
                    }
                }
            }
        }
    }

    /// A side of a cell, counter-clockwise as seen from the side that it faces.
    fn square(&self, cell: [usize; 3], axis: usize, positive: bool, at: f32) -> Square {
        let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
        let corner = |on_a: usize, on_b: usize| {
            let mut corner = Vec3::ZERO;
            corner[axis] = at;
            corner[a] = self.cuts[a][cell[a] + on_a];
            corner[b] = self.cuts[b][cell[b] + on_b];
            corner
        };
        let mut corners = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
        if !positive {
            corners.reverse();
        }
        Square { corners }
    }
}

/// Along which directions a surface's picture goes: to the right and down as seen from where it faces.
fn picture(normal: Vec3) -> [Vec3; 2] {
    match normal.y {
        0.0 => [Vec3::Y.cross(normal), Vec3::NEG_Y],
        _ => [Vec3::X, Vec3::Z],
    }
}

/// Squares of one plane as a mesh.
fn mesh(squares: &[Square], normal: Vec3) -> Mesh {
    let [right, down] = picture(normal);
    let positions: Vec<Vec3> = squares.iter().flat_map(|square| square.corners).collect();
    let metres: Vec<Vec2> =
        positions.iter().map(|p| Vec2::new(p.dot(right), p.dot(down))).collect();
    let low = metres.iter().copied().fold(Vec2::MAX, Vec2::min);
    let high = metres.iter().copied().fold(Vec2::MIN, Vec2::max);
    let unit: Vec<[f32; 2]> = metres
        .iter()
        .map(|m| ((*m - low) / (high - low).max(Vec2::splat(1e-6))).to_array())
        .collect();
    let count = positions.len();
    let corners = |square: u32| [0, 1, 2, 0, 2, 3].map(|corner| square * 4 + corner);
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_POSITION,
            positions.iter().map(Vec3::to_array).collect::<Vec<_>>(),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![normal.to_array(); count])
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_UV_0,
            metres.iter().map(Vec2::to_array).collect::<Vec<_>>(),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_1, unit)
        .with_inserted_indices(Indices::U32((0..squares.len() as u32).flat_map(corners).collect()))
}

//! Triangle meshes.

use glam::{Vec2, Vec3};
use thiserror::Error;

/// An indexed triangle mesh. Optional attributes are empty, never of another length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions in the mesh's own space.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one a vertex, or empty: then faces are flat.
    pub normals: Vec<Vec3>,
    /// First UV set (material textures), one a vertex, or empty.
    pub uv0: Vec<Vec2>,
    /// Second UV set (lightmap) in 0..1, not overlapping, one a vertex, or empty: then the mesh
    /// blocks and reflects light but has no lightmap. `v = 0` is the first row of the image.
    pub uv1: Vec<Vec2>,
    /// Three vertex indices a triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Why a mesh cannot be used.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum MeshProblem {
    /// Nothing to light.
    #[error("the mesh has no triangles")]
    Empty,
    /// An attribute does not have one value a vertex.
    #[error("{attribute}: {found} values for {vertices} vertices")]
    AttributeLength {
        /// Which attribute.
        attribute: &'static str,
        /// How many values it has.
        found: usize,
        /// How many there must be.
        vertices: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {index}, but there are {vertices}")]
    IndexOutOfRange {
        /// The offending triangle.
        triangle: usize,
        /// The index it holds.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// NaN or infinity among the positions.
    #[error("vertex {vertex} has a position that is not finite")]
    NotFinite {
        /// The offending vertex.
        vertex: usize,
    },
}

impl Mesh {
    /// Checks lengths, indices and finiteness.
    ///
    /// # Errors
    /// The first [`MeshProblem`] found.
    pub fn validate(&self) -> Result<(), MeshProblem> {
        if self.triangles.is_empty() {
            return Err(MeshProblem::Empty);
        }
        let vertices = self.positions.len();
        for (attribute, found) in
            [("normals", self.normals.len()), ("uv0", self.uv0.len()), ("uv1", self.uv1.len())]
        {
            if found != 0 && found != vertices {
                return Err(MeshProblem::AttributeLength { attribute, found, vertices });
            }
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            for &index in corners {
                if index as usize >= vertices {
                    return Err(MeshProblem::IndexOutOfRange { triangle, index, vertices });
                }
            }
        }
        match self.positions.iter().position(|p| !p.is_finite()) {
            Some(vertex) => Err(MeshProblem::NotFinite { vertex }),
            None => Ok(()),
        }
    }
}

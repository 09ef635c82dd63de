//! What a blob must fulfil before a solver sees it.

use farlight_gi_solver::scene::{Mesh, MeshProblem, SkyImage};
use glam::{Vec2, Vec3};

use super::Blob;
use crate::WireError;

/// Most texels along an edge of an image.
const EDGE: u32 = 16384;

impl Blob {
    /// Whether a receiver will take it: lengths, indices and dimensions fit, every number is finite
    /// and no radiance is negative. A mesh without triangles is fine (the solver leaves it out). A
    /// sender asks before it offers something to the other side, which ends the connection
    /// otherwise.
    ///
    /// # Errors
    /// [`WireError::Invalid`] says what is wrong.
    pub fn check(&self) -> Result<(), WireError> {
        match self {
            Self::Mesh(blob) => mesh(blob),
            Self::Texture(texture) => {
                dimensions(texture.width, texture.height, texture.texels.len())
            }
            Self::Sky(blob) => sky(blob),
        }
    }
}

fn mesh(mesh: &Mesh) -> Result<(), WireError> {
    let vertices = mesh.positions.len();
    match mesh.validate() {
        // It stops there, so lengths are looked at below.
        Ok(()) | Err(MeshProblem::Empty) => {}
        Err(problem) => return Err(WireError::invalid("a mesh", problem)),
    }
    for found in [mesh.normals.len(), mesh.uv0.len(), mesh.uv1.len()] {
        if found != 0 && found != vertices {
            let why = format_args!("{found} values for {vertices} vertices");
            return Err(WireError::invalid("a mesh", why));
        }
    }
    let finite = mesh.positions.iter().chain(&mesh.normals).copied().all(Vec3::is_finite)
        && mesh.uv0.iter().chain(&mesh.uv1).copied().all(Vec2::is_finite);
    if finite { Ok(()) } else { Err(WireError::invalid("a mesh", "a number is not finite")) }
}

fn sky(sky: &SkyImage) -> Result<(), WireError> {
    dimensions(sky.width, sky.height, sky.texels.len())?;
    let radiance = |v: &Vec3| v.is_finite() && v.cmpge(Vec3::ZERO).all();
    if sky.texels.iter().all(radiance) {
        return Ok(());
    }
    Err(WireError::invalid("a sky image", "a radiance is negative or not finite"))
}

/// Whether an image can have these dimensions.
pub(super) fn dimensions(width: u32, height: u32, texels: usize) -> Result<(), WireError> {
    WireError::check("an image's edge", width.max(height) as usize, EDGE as usize)?;
    if width as usize * height as usize == texels {
        return Ok(());
    }
    let why = format_args!("{width} x {height} is not {texels} texels");
    Err(WireError::invalid("an image", why))
}

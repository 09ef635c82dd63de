//! Where Bevy's irradiance volumes have their probes.
//!
//! An irradiance volume is a 3D texture of ambient cubes (Mitchell, McTaggart and Green, *Shading in
//! Valve's Source Engine*, SIGGRAPH 2006): six texels a probe, one a face.

use glam::UVec3;

/// The size in texels of the texture of `resolution` probes: (x, 2 y, 3 z).
#[must_use]
pub fn texture_size(resolution: UVec3) -> UVec3 {
    resolution * UVec3::new(1, 2, 3)
}

/// For every texel of the texture, x fastest, then y, then z: which probe and which of its faces +x, -x,
/// +y, -y, +z, -z it holds. Probes are counted with x fastest, then y, then z.
///
/// The texture has a slab in z for each of the axes x, y and z. In each slab the first half of the rows
/// is the positive side, the second half the negative one. (Bevy's documentation has the sides the
/// other way round; its shader adds the offset for negative normals.)
pub fn order(resolution: UVec3) -> impl Iterator<Item = (usize, usize)> {
    let [nx, ny, nz] = resolution.to_array().map(|n| n as usize);
    (0..3 * nz).flat_map(move |slab| {
        (0..2 * ny).flat_map(move |row| {
            let (axis, z) = (slab / nz, slab % nz);
            let (side, y) = (row / ny, row % ny);
            (0..nx).map(move |x| (x + nx * (y + ny * z), 2 * axis + side))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_face_of_every_probe_has_one_texel() {
        let resolution = UVec3::new(2, 3, 4);
        let mut all: Vec<_> = order(resolution).collect();
        assert_eq!(all.len() as u32, texture_size(resolution).element_product());
        assert_eq!(&all[..2], [(0, 0), (1, 0)]);
        // The fourth row is the negative side of the first.
        assert_eq!(all[2 * 3], (0, 1));
        // The second slab is that of y.
        assert_eq!(all[2 * 6 * 4], (0, 2));
        all.sort_unstable();
        let faces = (0..24).flat_map(|probe| (0..6).map(move |face| (probe, face)));
        assert!(all.into_iter().eq(faces));
        assert_eq!(order(UVec3::ZERO).count(), 0);
    }
}

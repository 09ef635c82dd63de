//! The map.

use std::{f64::consts::TAU, fs, path::Path};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::{EnvironmentError, Layout, read, shrink::Shrink, sphere};

/// Files larger than this are refused: 2 GiB.
const LARGEST_FILE: u64 = 1 << 31;
/// Irradiance is summed over at least so many cells, whatever the map has.
const FEWEST: [usize; 2] = [512, 256];

/// An equirectangular map of linear Rec. 709 radiance.
///
/// `u = 0.5 + atan2(x, -z) / 2π`, `v = acos(y) / π`: right-handed with y up, the centre is -z, right
/// is +x, row 0 is up. A texel's radiance holds for its whole solid angle. All values are finite, 0 or
/// above, at most 1e30. At most 2048 x 1024 texels: larger maps were averaged down by solid angle, which
/// keeps their energy.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    width: usize,
    height: usize,
    texels: Vec<Vec3>,
    repairs: Repairs,
}

/// How many values (three a texel) of the source were no radiance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// No number; set to 0.
    pub nan: u64,
    /// Infinite, or above 1e30; set to the largest value below that (0 if there is none above 0).
    pub infinite: u64,
    /// Negative; set to 0.
    pub negative: u64,
}

impl Repairs {
    /// Whether nothing had to be repaired.
    #[must_use]
    pub fn is_none(self) -> bool {
        self == Self::default()
    }
}

impl Environment {
    /// Reads a file. What it is, is told by its content: Radiance (.hdr), OpenEXR (.exr), KTX2 (.ktx2)
    /// without compression of blocks, or PNG and JPEG, whose sRGB values become linear.
    ///
    /// # Errors
    /// If it can't be read, is larger than 2 GiB, damaged, of an unknown format, or if its size
    /// doesn't fit the layout.
    pub fn open(path: &Path, layout: Layout) -> Result<Self, EnvironmentError> {
        let io = |source| EnvironmentError::Io { path: path.to_owned(), source };
        let length = fs::metadata(path).map_err(io)?.len();
        if length > LARGEST_FILE {
            let what = format!("{length} bytes are more than {LARGEST_FILE}");
            return Err(EnvironmentError::Size(what).in_file(path));
        }
        let bytes = fs::read(path).map_err(io)?;
        Self::read(&bytes, layout).map_err(|error| error.in_file(path))
    }

    /// Reads the bytes of a file; see [`open`](Self::open).
    ///
    /// # Errors
    /// As of [`open`](Self::open).
    pub fn read(bytes: &[u8], layout: Layout) -> Result<Self, EnvironmentError> {
        read::read(bytes, layout)
    }

    /// A map from its texels, row by row from the top. Values that are no radiance are repaired, and
    /// maps of more than 2048 x 1024 texels averaged down.
    ///
    /// # Errors
    /// If there are none, or not `width * height`, a side is longer than 65536, or there are more than 2^28.
    pub fn from_equirect(
        width: u32,
        height: u32,
        texels: Vec<Vec3>,
    ) -> Result<Self, EnvironmentError> {
        let mut shrink = Shrink::new([width, height], Layout::Equirect)?;
        if texels.len() as u64 != u64::from(width) * u64::from(height) {
            let what = format!("{} texels for a map of {width} x {height}", texels.len());
            return Err(EnvironmentError::Size(what));
        }
        for (y, row) in (0..).zip(texels.chunks_exact(width as usize)) {
            shrink.row(y, 0, row);
        }
        Ok(shrink.finish())
    }

    /// A map from the six faces of a cube, +X, -X, +Y, -Y, +Z and -Z, row by row from the top, as KTX2
    /// files and Vulkan have them. In that left-handed frame +Z is ahead; here, as in Bevy's skybox, it
    /// is -z.
    ///
    /// # Errors
    /// If a face has not `edge * edge` texels, or `edge` is 0 or above 6688.
    pub fn from_cube(edge: u32, faces: [&[Vec3]; 6]) -> Result<Self, EnvironmentError> {
        let size = [edge, edge.saturating_mul(6)];
        let mut shrink = Shrink::new(size, Layout::Cube)?;
        for (face, texels) in faces.into_iter().enumerate() {
            check_square(edge, texels)?;
            for (y, row) in texels.chunks_exact(edge as usize).enumerate() {
                shrink.row(face * edge as usize + y, 0, row);
            }
        }
        Ok(shrink.finish())
    }

    /// A map from Debevec's angular map (light probe), row by row from the top: ahead is the centre,
    /// straight back the circle that touches the edges
    /// (<https://www.pauldebevec.com/Probes/>, "light probe" format).
    ///
    /// # Errors
    /// If there are not `edge * edge` texels, or `edge` is 0 or above 16384.
    pub fn from_angular(edge: u32, texels: &[Vec3]) -> Result<Self, EnvironmentError> {
        let mut shrink = Shrink::new([edge; 2], Layout::Angular)?;
        check_square(edge, texels)?;
        for (y, row) in texels.chunks_exact(edge as usize).enumerate() {
            shrink.row(y, 0, row);
        }
        Ok(shrink.finish())
    }

    pub(crate) fn new(width: usize, height: usize, texels: Vec<Vec3>, repairs: Repairs) -> Self {
        debug_assert_eq!(texels.len(), width * height);
        Self { width, height, texels, repairs }
    }

    /// Texels beside each other.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width as u32
    }

    /// Texels above each other.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height as u32
    }

    /// Radiance of the texels, row by row from the top.
    #[must_use]
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }

    /// What was wrong with the source's values.
    #[must_use]
    pub fn repairs(&self) -> Repairs {
        self.repairs
    }

    /// Radiance of the texel that lies in a direction (of any length) of the map's frame.
    #[must_use]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let (x, y) = sphere::texel(direction.as_dvec3(), self.width, self.height);
        self.texels[y * self.width + x]
    }

    /// Irradiance of a surface with this unit normal that nothing shades, in the map's unit of
    /// radiance times steradian: the sum over all texels, each with the integral of the unit vector
    /// over its solid angle. Off by less than 1e-4 of the mean, at texels that the horizon crosses.
    #[must_use]
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        let normal = normal.as_dvec3();
        let [parts_x, parts_y] = self.parts(FEWEST);
        let columns = self.width * parts_x;
        let edge = |x: usize| sphere::azimuth(x as f64, columns);
        let sectors: Vec<f64> = (0..columns)
            .map(|x| {
                let sector = sphere::sector(edge(x), edge(x + 1));
                sector.x * normal.x + sector.y * normal.z
            })
            .collect();
        let edges = sphere::row_edges(self.height * parts_y);
        let up = normal.y * TAU / columns as f64;
        let sum: DVec3 = edges
            .par_windows(2)
            .enumerate()
            .map(|(y, cos)| {
                let band = sphere::band(cos[0], cos[1]);
                let row = &self.texels[y / parts_y * self.width..][..self.width];
                (row.iter().zip(sectors.chunks_exact(parts_x)))
                    .map(|(texel, sectors)| {
                        let cosines = sectors.iter().map(|s| (s * band.x + up * band.y).max(0.0));
                        texel.as_dvec3() * cosines.sum::<f64>()
                    })
                    .sum::<DVec3>()
            })
            // Sums of a fixed order: the same on any number of threads.
            .collect::<Vec<_>>()
            .into_iter()
            .sum();
        sum.as_vec3()
    }

    /// Into how many columns and rows each texel is cut, so that there are `fewest` at least.
    pub(crate) fn parts(&self, fewest: [usize; 2]) -> [usize; 2] {
        [fewest[0].div_ceil(self.width), fewest[1].div_ceil(self.height)]
    }
}

fn check_square(edge: u32, texels: &[Vec3]) -> Result<(), EnvironmentError> {
    if texels.len() as u64 == u64::from(edge).pow(2) {
        return Ok(());
    }
    let what = format!("{} texels for a square of {edge} x {edge}", texels.len());
    Err(EnvironmentError::Size(what))
}

//! The seam between Bevy and whatever solves the lighting.

use std::{any::Any, sync::Arc, time::Duration};

use bevy::prelude::*;
use farlight_gi_solver::{
    atlas::{PageId, TexelRect},
    session::{
        GridId, GridUpdate, LightingUpdate, Placement, Quality, SessionChange, SnapshotId, Tile,
    },
    sh::ShRgb,
};
use half::f16;

use crate::{GiSettings, LinkStatus};

/// What solves the lighting: a background thread, a GPU, another machine.
///
/// The plugin calls it from the main thread once a frame. No method may wait for anything.
pub trait LightingBackend: Any + Send + Sync {
    /// Takes changes of the scene over, in their order. `snapshot` names the state after them.
    fn submit(&mut self, snapshot: SnapshotId, changes: Vec<SessionChange>);

    /// The next update, if one is ready. It is called until it returns `None`.
    fn poll(&mut self) -> Option<GiUpdate>;

    /// How it is doing.
    fn state(&self) -> BackendState;

    /// Answers `true` once after the backend has lost the scene, for example when a connection was
    /// made anew. The plugin then submits everything again, as one snapshot.
    fn lost_scene(&mut self) -> bool {
        false
    }

    /// Asks for all light again, as updates that will come: textures were lost. The plugin writes
    /// what it remembers, so a backend in the same process need not do anything.
    fn resync(&mut self) {}

    /// How it is connected, if it is on another machine. Asked once a frame: it should not take
    /// memory where nothing changed.
    fn link(&self) -> Option<LinkStatus> {
        None
    }
}

/// How a backend is doing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum BackendState {
    /// Nothing to do, or nothing submitted yet.
    #[default]
    Idle,
    /// Working; updates will come.
    Solving,
    /// The scene is still and nothing better will come.
    Converged,
    /// It can't be reached, for this reason, and goes on trying. What was solved stays on screen.
    Disconnected {
        /// Why.
        reason: Arc<str>,
    },
    /// It has given up. What was solved stays on screen.
    Failed(Arc<str>),
}

/// Makes a backend; called at the start and whenever the settings ask for a new solver.
pub type BackendFactory = Arc<dyn Fn(&GiSettings) -> Box<dyn LightingBackend> + Send + Sync>;

/// The backend in use; there is none before the first frame. For plugins that bring a backend of
/// their own and have more to tell it than the seam can.
#[derive(Resource)]
pub struct GiBackend(pub(crate) Box<dyn LightingBackend>);

impl GiBackend {
    /// The backend, if it is a `T`.
    #[must_use]
    pub fn downcast_ref<T: LightingBackend>(&self) -> Option<&T> {
        let any: &dyn Any = &*self.0;
        any.downcast_ref()
    }

    /// The backend, if it is a `T`.
    #[must_use]
    pub fn downcast_mut<T: LightingBackend>(&mut self) -> Option<&mut T> {
        let any: &mut dyn Any = &mut *self.0;
        any.downcast_mut()
    }
}

/// A [`LightingUpdate`] in the formats of the textures, so that the main thread only copies.
/// Backends encode on their own threads, with [`GiUpdate::encode`].
#[derive(Clone, Debug, Default)]
pub struct GiUpdate {
    /// The newest snapshot whose changes it shows.
    pub snapshot: SnapshotId,
    /// Placements that are new or moved; they come with their tiles.
    pub placements: Vec<Placement>,
    /// Receivers that were refused, and why.
    pub refused: Vec<(farlight_gi_solver::scene::InstanceId, Arc<str>)>,
    /// Texels that changed.
    pub tiles: Vec<EncodedTile>,
    /// Probe grids that changed.
    pub grids: Vec<EncodedGrid>,
    /// How good it is.
    pub quality: Quality,
    /// Where the time went.
    pub times: UpdateTimes,
}

/// Where an update's time went, from the submission of its snapshot to the moment at which it could
/// be polled; `None` for what a backend doesn't have, or was not measured for this update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UpdateTimes {
    /// From the submission until the network had taken the changes over.
    pub send: Option<Duration>,
    /// Solving since the last update.
    pub solve: Option<Duration>,
    /// From the solver's numbers to what travels, or to what the textures hold.
    pub encode: Option<Duration>,
    /// On the network, there and back.
    pub transfer: Option<Duration>,
    /// From what travelled to what the textures hold.
    pub decode: Option<Duration>,
}

/// A rectangle of lightmap texels as RGBA half floats.
#[derive(Clone, Debug)]
pub struct EncodedTile {
    /// The page.
    pub page: PageId,
    /// Where in the page.
    pub rect: TexelRect,
    /// `width * height` texels E / π of 8 bytes, rows from the top, little endian, alpha 1.
    pub texels: Vec<u8>,
}

/// All probes of a grid as ambient cubes in the layout of Bevy's irradiance volumes.
#[derive(Clone, Debug)]
pub struct EncodedGrid {
    /// The grid.
    pub grid: GridId,
    /// Its resolution.
    pub resolution: UVec3,
    /// A 3D texture of (x, 2 y, 3 z) RGBA half floats, E(axis) / π: slabs in z for the axes x, y
    /// and z; in each slab the lower half of y (the first rows) is the positive side, the upper
    /// half the negative one. (Bevy's documentation has the sides the other way round; its shader
    /// adds the offset for negative normals.)
    pub texels: Vec<u8>,
}

impl GiUpdate {
    /// Encodes what a solver session returned.
    #[must_use]
    pub fn encode(update: &LightingUpdate) -> Self {
        Self {
            snapshot: update.snapshot,
            placements: update.placements.clone(),
            refused: update.refused.clone(),
            tiles: update.tiles.iter().map(EncodedTile::encode).collect(),
            grids: update.grids.iter().map(EncodedGrid::encode).collect(),
            quality: update.quality,
            times: UpdateTimes::default(),
        }
    }
}

impl EncodedTile {
    /// A tile of texels that are half floats already: `rect.width * rect.height` values E / π as bits,
    /// finite and not negative.
    #[must_use]
    pub fn from_half_bits(page: PageId, rect: TexelRect, halves: &[[u16; 3]]) -> Self {
        let one = f16::ONE.to_bits().to_le_bytes();
        let mut texels = vec![0; halves.len() * 8];
        for (bytes, texel) in texels.chunks_exact_mut(8).zip(halves) {
            for (channel, bits) in bytes.chunks_exact_mut(2).zip(texel) {
                channel.copy_from_slice(&bits.to_le_bytes());
            }
            bytes[6..].copy_from_slice(&one);
        }
        Self { page, rect, texels }
    }

    /// Encodes a tile. Values that aren't finite become black, negative ones too.
    #[must_use]
    pub fn encode(tile: &Tile) -> Self {
        let mut texels = Vec::with_capacity(tile.texels.len() * 8);
        for &texel in &tile.texels {
            push_texel(&mut texels, texel);
        }
        Self { page: tile.page, rect: tile.rect, texels }
    }
}

impl EncodedGrid {
    /// Encodes a grid.
    #[must_use]
    pub fn encode(grid: &GridUpdate) -> Self {
        Self::from_probes(grid.grid, grid.resolution, &grid.probes)
    }

    /// Encodes all probes of a grid, x fastest, then y, then z: incident radiance in SH. Missing
    /// ones are black.
    #[must_use]
    pub fn from_probes(grid: GridId, resolution: UVec3, probes: &[ShRgb]) -> Self {
        let [nx, ny, nz] = resolution.to_array().map(|n| n as usize);
        let cubes: Vec<[Vec3; 6]> = probes.iter().map(|sh| sh.ambient_cube()).collect();
        let mut texels = Vec::with_capacity(nx * ny * nz * 6 * 8);
        for axis in 0..3 {
            for z in 0..nz {
                for side in 0..2 {
                    for y in 0..ny {
                        for x in 0..nx {
                            let cube = cubes.get(x + nx * (y + ny * z));
                            let value = cube.map_or(Vec3::ZERO, |cube| cube[2 * axis + side]);
                            push_texel(&mut texels, value);
                        }
                    }
                }
            }
        }
        Self { grid, resolution, texels }
    }
}

fn push_texel(bytes: &mut Vec<u8>, value: Vec3) {
    // f32::max and min turn NaN into the bound.
    let channel = |v: f32| f16::from_f32(if v.is_finite() { v.clamp(0.0, 65504.0) } else { 0.0 });
    for half in [channel(value.x), channel(value.y), channel(value.z), f16::ONE] {
        bytes.extend_from_slice(&half.to_le_bytes());
    }
}

/// Reads a texel of RGBA half floats back.
pub(crate) fn decode_texel(bytes: &[u8]) -> Vec3 {
    let channel = |i: usize| f16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]).to_f32();
    Vec3::new(channel(0), channel(1), channel(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_taken_as_they_are() {
        let rect = TexelRect { x: 2, y: 4, width: 2, height: 1 };
        let values = vec![Vec3::new(1.0, 0.5, 1e-4), Vec3::new(65504.0, 0.0, 3.0)];
        let bits: Vec<_> =
            values.iter().map(|v| v.to_array().map(|c| f16::from_f32(c).to_bits())).collect();
        let direct = EncodedTile::from_half_bits(PageId(1), rect, &bits);
        let encoded = EncodedTile::encode(&Tile { page: PageId(1), rect, texels: values });
        assert_eq!(direct.texels, encoded.texels);
        assert_eq!((direct.page, direct.rect), (encoded.page, encoded.rect));
    }

    #[test]
    fn texels_become_halves_and_bad_ones_black() {
        let tile = Tile {
            page: PageId(0),
            rect: TexelRect { x: 0, y: 0, width: 2, height: 2 },
            texels: vec![
                Vec3::new(1.0, 0.5, 1e9),
                Vec3::splat(f32::NAN),
                Vec3::splat(-1.0),
                Vec3::splat(f32::INFINITY),
            ],
        };
        let encoded = EncodedTile::encode(&tile);
        assert_eq!(encoded.texels.len(), 4 * 8);
        assert_eq!(decode_texel(&encoded.texels), Vec3::new(1.0, 0.5, 65504.0));
        for texel in 1..4 {
            assert_eq!(decode_texel(&encoded.texels[texel * 8..]), Vec3::ZERO);
        }
    }

    #[test]
    fn an_ambient_cube_has_the_positive_side_in_the_first_rows() {
        // Light from +y only: the positive y side is bright, the negative one dark.
        let mut probe = ShRgb::ZERO;
        probe.add_direction(Vec3::Y, Vec3::ONE);
        let resolution = UVec3::new(2, 3, 4);
        let grid = GridUpdate { grid: GridId(0), resolution, probes: vec![probe; 24] };
        let encoded = EncodedGrid::encode(&grid);
        let at = |x: usize, y: usize, z: usize| {
            decode_texel(&encoded.texels[(x + 2 * (y + 6 * z)) * 8..]).x
        };
        assert_eq!(encoded.texels.len(), 2 * 6 * 12 * 8);
        let (up, down) = (at(0, 0, 4), at(0, 3, 4));
        assert!(up > 10.0 * down.max(0.01), "{up} {down}");
        assert!((at(0, 0, 0) - at(0, 3, 0)).abs() < 1e-3, "x has no preferred side");
    }
}

//! Light on its way to the client, in half floats.

use std::{sync::Arc, time::Duration};

use farlight_gi_solver::{
    atlas::{PageId, TexelRect},
    scene::InstanceId,
    session::{GridId, GridUpdate, Placement, Quality, SnapshotId, Tile},
    sh::ShRgb,
};
use glam::{UVec3, Vec3};
use half::f16;

/// One message of light: what the client should show now.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightingMessage {
    /// Grows by one a message of a session. Of two messages about the same texels the one with the
    /// larger number is right, whatever order they arrive in.
    pub sequence: u64,
    /// The newest snapshot whose changes it shows.
    pub snapshot: SnapshotId,
    /// Where the time went.
    pub times: ServerTimes,
    /// How good it is.
    pub quality: Quality,
    /// Placements that are new or moved; their tiles are in this message or in one with a larger
    /// number.
    pub placements: Vec<Placement>,
    /// Receivers that were refused, and why.
    pub refused: Vec<(InstanceId, Arc<str>)>,
    /// Texels that changed.
    pub tiles: Vec<HalfTile>,
    /// Probes that changed.
    pub grids: Vec<HalfGrid>,
}

/// How long the server took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ServerTimes {
    /// From the arrival of the snapshot to the departure of this message.
    pub held: Duration,
    /// Solving, a part of `held`.
    pub solve: Duration,
    /// Encoding, a part of `held`.
    pub encode: Duration,
}

/// A rectangle of lightmap texels.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HalfTile {
    /// The page.
    pub page: PageId,
    /// Where in the page.
    pub rect: TexelRect,
    /// `rect.width * rect.height` values E / π, rows from the top: the bits of half floats that are
    /// finite and not negative.
    pub texels: Vec<[u16; 3]>,
}

/// A run of a grid's probes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HalfGrid {
    /// The grid.
    pub grid: GridId,
    /// Its resolution.
    pub resolution: UVec3,
    /// Index of the first probe (x fastest, then y, then z).
    pub first: u32,
    /// Coefficients of incident radiance in the order of [`ShRgb`], as bits of finite half floats.
    pub probes: Vec<[[u16; 3]; 9]>,
}

/// Names what a message brings of the light: texels or probes that are sent as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Piece {
    /// A tile.
    Tile(PageId, TexelRect),
    /// A run of probes, from an index on.
    Probes(GridId, u32),
}

impl HalfTile {
    /// Its name.
    #[must_use]
    pub fn piece(&self) -> Piece {
        Piece::Tile(self.page, self.rect)
    }
}

impl HalfGrid {
    /// Its name.
    #[must_use]
    pub fn piece(&self) -> Piece {
        Piece::Probes(self.grid, self.first)
    }
}

/// The largest finite half float.
const MAX: f32 = 65504.0;

impl HalfTile {
    /// Rounds a tile. Values that aren't finite become black, negative ones too.
    #[must_use]
    pub fn new(tile: &Tile) -> Self {
        let channel = |v: f32| {
            let v = if v.is_finite() { v.clamp(0.0, MAX) } else { 0.0 };
            // A sum clears the sign of -0.
            f16::from_f32(v + 0.0).to_bits()
        };
        let texels = tile.texels.iter().map(|t| t.to_array().map(channel)).collect();
        Self { page: tile.page, rect: tile.rect, texels }
    }

    /// Back to floats.
    #[must_use]
    pub fn to_tile(&self) -> Tile {
        let texels = self.texels.iter().map(|t| vec3(*t)).collect();
        Tile { page: self.page, rect: self.rect, texels }
    }
}

impl HalfGrid {
    /// Rounds a grid. Values that aren't finite become 0.
    #[must_use]
    pub fn new(grid: &GridUpdate) -> Self {
        let channel = |v: f32| {
            let v = if v.is_finite() { v.clamp(-MAX, MAX) } else { 0.0 };
            f16::from_f32(v).to_bits()
        };
        let probes = grid.probes.iter().map(|sh| sh.0.map(|c| c.to_array().map(channel))).collect();
        Self { grid: grid.grid, resolution: grid.resolution, first: 0, probes }
    }

    /// The same grid without probes.
    pub(crate) fn clone_empty(&self) -> Self {
        Self { grid: self.grid, resolution: self.resolution, first: 0, probes: Vec::new() }
    }

    /// Back to floats.
    pub fn to_probes(&self) -> impl Iterator<Item = ShRgb> {
        self.probes.iter().map(|probe| ShRgb(probe.map(vec3)))
    }
}

fn vec3(bits: [u16; 3]) -> Vec3 {
    Vec3::from_array(bits.map(|b| f16::from_bits(b).to_f32()))
}

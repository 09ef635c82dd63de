//! The plan of the gallery: three rooms, what stands in them, and where people can stand.
//!
//! ```text
//!            north (-z)
//!   +--------+-----------+--------+
//!   |        |           |  red   |
//! w | window    hall        room  |
//!   |        |           |        |
//!   +--------|           |--------+
//!            +-----------+
//! ```
//!
//! Metres, y up, the floor at 0. The hall has a skylight, the room in the west a window; the red room has
//! the lamp and what comes through the doors.

use bevy::prelude::*;

use super::building::{Building, Cuboid3, Space};

/// The room in the middle.
pub const HALL: Space = Space(0);
/// The room in the east, with the red wall and the lamp.
pub const RED: Space = Space(1);
/// The room in the west, with the window.
pub const WINDOW: Space = Space(2);
/// Doors.
pub const DOORS: Space = Space(3);
/// Skylight and window.
pub const OPENINGS: Space = Space(4);

/// The rooms, doors and windows.
pub const SPACES: &[(Space, Cuboid3)] = &[
    (HALL, Cuboid3::new([-4.0, 0.0, -3.0], [4.0, 4.2, 3.4])),
    (RED, Cuboid3::new([4.4, 0.0, -3.0], [9.4, 3.2, 2.0])),
    (WINDOW, Cuboid3::new([-9.4, 0.0, -3.0], [-4.4, 3.2, 2.0])),
    (DOORS, Cuboid3::new([4.0, 0.0, -1.3], [4.4, 2.5, 0.3])),
    (DOORS, Cuboid3::new([-4.4, 0.0, -1.3], [-4.0, 2.5, 0.3])),
    (OPENINGS, Cuboid3::new([-1.8, 4.2, -1.0], [1.8, 4.7, 1.2])),
    (OPENINGS, Cuboid3::new([-9.9, 0.5, -1.7], [-9.4, 2.7, 0.1])),
];

/// All of it, walls included.
pub const BLOCK: Cuboid3 = Cuboid3::new([-9.9, -0.4, -3.6], [9.9, 4.7, 4.0]);

/// Where people enter, and look to the north.
pub const ENTRANCE: Vec3 = Vec3::new(0.3, 0.0, 2.5);

/// Something that stands on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    /// The middle of its foot.
    pub place: Vec3,
    /// Edges along x and z; a round one has the first as its diameter.
    pub size: Vec2,
    /// How high it is.
    pub height: f32,
    /// Whether it is round.
    pub round: bool,
    /// What it is made of.
    pub look: Look,
}

/// What stands are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// White paint.
    White,
    /// Oak.
    Oak,
}

const fn plinth(x: f32, z: f32, edge: f32, height: f32) -> Stand {
    Stand {
        place: Vec3::new(x, 0.0, z),
        size: Vec2::splat(edge),
        height,
        round: false,
        look: Look::White,
    }
}

const fn bench(x: f32, z: f32, size: Vec2, height: f32) -> Stand {
    Stand { place: Vec3::new(x, 0.0, z), size, height, round: false, look: Look::Oak }
}

/// All that stands on the floor, in a fixed order.
pub const STANDS: &[Stand] = &[
    // The hall: a round one in the middle, two in the corners, a bench.
    Stand {
        place: Vec3::new(0.0, 0.0, -0.9),
        size: Vec2::splat(1.1),
        height: 0.5,
        round: true,
        look: Look::White,
    },
    plinth(-2.7, -2.1, 0.5, 0.95),
    plinth(2.7, -2.1, 0.5, 0.95),
    bench(-2.5, 1.7, Vec2::new(0.45, 1.7), 0.44),
    // The red room: two plinths before the red wall, a low table.
    plinth(6.2, -2.2, 0.45, 0.9),
    plinth(7.9, -2.2, 0.45, 1.0),
    bench(7.2, 0.5, Vec2::new(1.3, 0.6), 0.72),
    // The room with the window.
    plinth(-6.9, -0.8, 0.75, 0.75),
    plinth(-5.4, -2.3, 0.45, 1.0),
    bench(-6.6, 1.5, Vec2::new(1.7, 0.45), 0.44),
];

/// Bars of skylight and window, which the sun draws on floor and walls.
pub const BARS: &[Cuboid3] = &[
    Cuboid3::new([-0.63, 4.45, -1.0], [-0.57, 4.6, 1.2]),
    Cuboid3::new([0.57, 4.45, -1.0], [0.63, 4.6, 1.2]),
    Cuboid3::new([-1.8, 4.47, 0.07], [1.8, 4.58, 0.13]),
    Cuboid3::new([-9.72, 0.5, -0.83], [-9.64, 2.7, -0.77]),
    Cuboid3::new([-9.71, 1.87, -1.7], [-9.65, 1.93, 0.1]),
];

/// Index in [`STANDS`] of the round plinth in the hall.
pub const ROUND: usize = 0;
/// Index in [`STANDS`] of the low table.
pub const TABLE: usize = 6;

impl Stand {
    /// The middle of its top.
    pub fn top(&self) -> Vec3 {
        self.place + Vec3::Y * self.height
    }

    /// Metres from a place to its outline, seen from above; negative over it.
    fn distance(&self, place: Vec3) -> f32 {
        let from = (place - self.place).xz();
        if self.round {
            return from.length() - 0.5 * self.size.x;
        }
        let beyond = from.abs() - 0.5 * self.size;
        beyond.max(Vec2::ZERO).length() + beyond.max_element().min(0.0)
    }

    fn contains(&self, place: Vec3) -> bool {
        place.y <= self.height && self.distance(place) <= 0.0
    }
}

/// Half the width of a person, in metres.
pub const PERSON: f32 = 0.25;

/// What is in the way of people, hands and arcs.
#[derive(Resource, Clone, Debug)]
pub struct Floor {
    /// The walls.
    pub building: Building,
}

impl Default for Floor {
    fn default() -> Self {
        Self { building: Building::carve(BLOCK, SPACES) }
    }
}

impl Floor {
    /// Whether a place is in a wall or in something that stands on the floor.
    pub fn blocks(&self, place: Vec3) -> bool {
        self.building.is_wall(place) || STANDS.iter().any(|stand| stand.contains(place))
    }

    /// Whether somebody can stand at a place of the floor: in a room or a door, clear of everything by
    /// half a person.
    pub fn carries(&self, place: Vec3) -> bool {
        let ring = (0..16).map(|i| Vec2::from_angle(i as f32 / 16.0 * std::f32::consts::TAU));
        let clear = |at: Vec2| {
            let at = place + Vec3::new(at.x, 0.05, at.y) * Vec3::new(PERSON, 1.0, PERSON);
            matches!(self.building.space(at), Some(HALL | RED | WINDOW | DOORS))
        };
        ring.chain([Vec2::ZERO]).all(clear)
            && STANDS.iter().all(|stand| stand.distance(place) >= PERSON)
    }

    /// Where somebody gets who walks from a place by a step: along walls rather than nowhere.
    pub fn walk(&self, from: Vec3, step: Vec3) -> Vec3 {
        let step = step * Vec3::new(1.0, 0.0, 1.0);
        let ways = [step, Vec3::X * step.x, Vec3::Z * step.z];
        // Long steps are walked in short ones, or they would lead through walls.
        let count = (step.length() / 0.1).ceil().clamp(1.0, 64.0);
        let mut place = from;
        for _ in 0..count as u32 {
            let next = ways.iter().map(|way| place + *way / count).find(|next| self.carries(*next));
            let Some(next) = next else { break };
            place = next;
        }
        place
    }

    /// The height of what is below a place: the floor, or what stands on it.
    pub fn support(&self, place: Vec3) -> f32 {
        let tops = STANDS.iter().filter(|stand| stand.distance(place) <= 0.0);
        tops.map(|stand| stand.height).filter(|top| *top <= place.y + 0.02).fold(0.0, f32::max)
    }

    /// The room that a place is in.
    pub fn room(&self, place: Vec3) -> Option<Space> {
        self.building.space(place)
    }
}

//! Where somebody aims to go: a thrown arc, and the floor where it comes down.

use bevy::prelude::*;

use super::plan::Floor;

/// Metres a second with which the arc leaves the hand: about five metres far.
const SPEED: f32 = 6.2;
/// Metres a second squared.
const GRAVITY: f32 = 9.81;
/// Seconds between points of the arc; a step is never longer than 20 cm.
const STEP: f32 = 0.02;
/// Seconds after which an arc that met nothing ends.
const LONGEST: f32 = 3.0;
/// Who aims closer to a wall than they can stand is put back along the arc, up to so many metres.
const PUT_BACK: f32 = 0.5;

/// An arc, and what it leads to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arc {
    /// From the hand to where it ends, in equal times.
    pub points: Vec<Vec3>,
    /// Where one would stand; `None` if the arc ends at a wall, on something, or in the open.
    pub landing: Option<Vec3>,
}

/// Throws an arc from a hand along where it points.
pub fn throw(from: Vec3, along: Vec3, floor: &Floor) -> Arc {
    let along = along.normalize_or_zero();
    if !from.is_finite() || along == Vec3::ZERO || floor.blocks(from) {
        return Arc { points: vec![from], landing: None };
    }
    let at = |time: f32| from + along * (SPEED * time) - Vec3::Y * (0.5 * GRAVITY * time * time);
    let mut arc = Arc { points: vec![from], landing: None };
    let mut time = 0.0;
    while time < LONGEST {
        let next = time + STEP;
        if !floor.blocks(at(next)) {
            time = next;
            arc.points.push(at(time));
            continue;
        }
        let end = at(last_free(floor, &at, time, next));
        arc.points.push(end);
        // The floor is met from above, a wall or a thing is not the floor.
        let below = end - Vec3::Y * 0.02;
        if end.y < 0.02 && floor.building.is_wall(below) {
            arc.landing = standing(Vec3::new(end.x, 0.0, end.z), along, floor);
        }
        return arc;
    }
    arc
}

/// The last moment between two at which the arc is free.
fn last_free(floor: &Floor, at: &impl Fn(f32) -> Vec3, mut free: f32, mut blocked: f32) -> f32 {
    for _ in 0..16 {
        let middle = 0.5 * (free + blocked);
        if floor.blocks(at(middle)) {
            blocked = middle;
        } else {
            free = middle;
        }
    }
    free
}

/// Where somebody can stand, at a place or a little before it.
fn standing(place: Vec3, along: Vec3, floor: &Floor) -> Option<Vec3> {
    let back = -Vec3::new(along.x, 0.0, along.z).normalize_or_zero();
    let steps = (PUT_BACK / 0.05) as u32;
    (0..=steps).map(|step| place + back * (step as f32 * 0.05)).find(|place| floor.carries(*place))
}

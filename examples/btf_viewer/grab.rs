//! Taking hold of an object with one hand or with both: from how hands moved to how it moves.

use bevy::prelude::*;

/// Where an object is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// Its middle.
    pub place: Vec3,
    /// How it is turned.
    pub rotation: Quat,
    /// Factor on its size.
    pub scale: f32,
}

/// Metres between hands below which they are taken for one.
const CLOSE: f32 = 0.02;

impl Held {
    /// Follows a hand from `before` to `now`. What the hand reaches turns about the hand, as if held;
    /// what is farther than `reach` metres from it turns about its own middle.
    #[must_use]
    pub fn by_one(self, before: Isometry3d, now: Isometry3d, reach: f32) -> Self {
        let turn = (now.rotation * before.rotation.inverse()).normalize();
        let (from, to) = (Vec3::from(before.translation), Vec3::from(now.translation));
        let arm = self.place - from;
        let place = if arm.length() <= reach { to + turn * arm } else { self.place + (to - from) };
        Self { place, rotation: (turn * self.rotation).normalize(), ..self }
    }

    /// Follows both hands: what is between them stays between them, turns with the line through them
    /// and grows as they part, within `scales`.
    #[must_use]
    pub fn by_both(self, before: [Isometry3d; 2], now: [Isometry3d; 2], scales: [f32; 2]) -> Self {
        let [was, is] = [before, now].map(|hands| hands.map(|hand| Vec3::from(hand.translation)));
        let (from, to) = (was[1] - was[0], is[1] - is[0]);
        if from.length() < CLOSE || to.length() < CLOSE {
            return self.by_one(before[0], now[0], f32::INFINITY);
        }
        let axis = to.normalize();
        let swing = Quat::from_rotation_arc(from.normalize(), axis);
        // Both wrists turned about that line: half of each.
        let twist = |hand: usize| {
            let turn = now[hand].rotation * before[hand].rotation.inverse() * swing.inverse();
            let turn = if turn.w < 0.0 { -turn } else { turn };
            2.0 * turn.xyz().dot(axis).atan2(turn.w)
        };
        let turn = Quat::from_axis_angle(axis, 0.5 * (twist(0) + twist(1))) * swing;
        let scale = (self.scale * to.length() / from.length()).clamp(scales[0], scales[1]);
        let grown = scale / self.scale;
        let (old, new) = (was[0].midpoint(was[1]), is[0].midpoint(is[1]));
        Self {
            place: new + turn * (self.place - old) * grown,
            rotation: (turn * self.rotation).normalize(),
            scale,
        }
    }
}

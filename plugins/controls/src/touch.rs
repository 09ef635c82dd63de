//! What fingers do: drags with one, two and three fingers, pinches, turns, taps. Knows no screen.

use bevy::{
    input::touch::{TouchInput, TouchPhase},
    prelude::*,
};
use farlight_bindings::Touch;

/// Fingers that are followed; more are not heard.
const FINGERS: usize = 10;
/// A finger that moved farther than this, in pixels, taps nothing and drags.
const SLOP: f32 = 12.0;
/// Longest tap in seconds.
const TAP: f32 = 0.3;
/// Longest time between two taps of a double tap.
const DOUBLE: f32 = 0.3;
/// Two taps of a double tap lie this close, in pixels.
const NEAR: f32 = 48.0;
/// What is held for so long is a long press, in seconds.
const LONG: f32 = 0.5;
/// A panel says a frame late or two that a finger is its own.
const LATE: u32 = 2;
/// Least distance of two fingers, in pixels: closer ones tell nothing about distance and angle.
const APART: f32 = 8.0;

/// A finger on the screen.
#[derive(Clone, Copy, Debug)]
struct Finger {
    id: u64,
    at: Vec2,
    /// Where it was when the last frame ended.
    before: Vec2,
    start: Vec2,
    /// How many frames it has been there.
    frames: u32,
    /// It lies on a panel.
    taken: bool,
}

/// What fingers did in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Gesture {
    /// By one, two and three fingers, in pixels, to the right and up.
    pub(crate) drags: [Vec2; 3],
    /// Doublings of two fingers' distance.
    pub(crate) pinch: f32,
    /// Degrees, clockwise.
    pub(crate) twist: f32,
    /// One of [`Touch::Tap`], [`Touch::DoubleTap`], [`Touch::Tap2`], [`Touch::Tap3`].
    pub(crate) tap: Option<Touch>,
    /// A finger is held still; for as long as it is.
    pub(crate) long: bool,
}

/// Recognizes gestures.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fingers {
    fingers: [Option<Finger>; FINGERS],
    /// How many fingers of this touch were there at once, at most.
    most: usize,
    /// Seconds since the first finger of this touch came.
    seconds: f32,
    /// A finger moved too far for a tap, or was taken away.
    moved: bool,
    /// It is a long press.
    long: bool,
    /// Where and how long ago the last tap was.
    last: Option<(Vec2, f32)>,
    /// Taps that have been finished since the last frame.
    tap: Option<Touch>,
}

impl Fingers {
    /// A finger did something. Events come in the order in which they happened.
    pub(crate) fn hear(&mut self, event: &TouchInput) {
        if !event.position.is_finite() {
            return;
        }
        match event.phase {
            TouchPhase::Started => self.begin(event.id, event.position),
            TouchPhase::Moved => {
                if let Some(finger) = self.finger(event.id) {
                    finger.at = event.position;
                    let far = finger.at.distance(finger.start) > SLOP;
                    let taken = finger.taken;
                    self.moved |= far && !taken;
                }
            }
            TouchPhase::Ended => self.end(event.id, true),
            TouchPhase::Canceled => self.end(event.id, false),
        }
    }

    fn finger(&mut self, id: u64) -> Option<&mut Finger> {
        self.fingers.iter_mut().flatten().find(|finger| finger.id == id)
    }

    fn free(&self) -> impl Iterator<Item = &Finger> {
        self.fingers.iter().flatten().filter(|finger| !finger.taken)
    }

    fn begin(&mut self, id: u64, at: Vec2) {
        self.end(id, false);
        if self.free().next().is_none() {
            (self.most, self.seconds, self.moved, self.long) = (0, 0.0, false, false);
        }
        let finger = Finger { id, at, before: at, start: at, frames: 0, taken: false };
        if let Some(place) = self.fingers.iter_mut().find(|place| place.is_none()) {
            *place = Some(finger);
        }
        self.most = self.most.max(self.free().count());
    }

    fn end(&mut self, id: u64, lifted: bool) {
        let place = |finger: &Option<Finger>| finger.is_some_and(|finger| finger.id == id);
        let Some(at) = self.fingers.iter().position(place) else { return };
        let Some(finger) = self.fingers[at].take() else { return };
        if finger.taken {
            return;
        }
        self.moved |= !lifted;
        if self.free().next().is_some() || self.moved || self.long || self.seconds > TAP {
            return;
        }
        self.tap = match self.most {
            1 => {
                let near = |(place, ago): (Vec2, f32)| {
                    ago <= DOUBLE && place.distance(finger.start) <= NEAR
                };
                let double = self.last.take().is_some_and(near);
                if !double {
                    self.last = Some((finger.start, 0.0));
                }
                Some(if double { Touch::DoubleTap } else { Touch::Tap })
            }
            2 => Some(Touch::Tap2),
            3 => Some(Touch::Tap3),
            _ => None,
        };
    }

    /// Ends a frame of this many seconds. `panel` says that the pointer is on a panel: fingers that have
    /// just come are the panel's.
    pub(crate) fn frame(&mut self, seconds: f32, panel: bool) -> Gesture {
        for finger in self.fingers.iter_mut().flatten() {
            finger.taken |= panel && finger.frames <= LATE;
        }
        let tap = self.tap.take().filter(|_| !panel);
        let mut gesture = Gesture { tap, ..default() };
        self.seconds += seconds;
        if let Some((_, ago)) = &mut self.last {
            *ago += seconds;
        }
        let count = self.free().count();
        self.long &= count == 1;
        if count == 1 && self.most == 1 && !self.moved && self.seconds >= LONG {
            self.long = true;
        }
        gesture.long = self.long;
        // Each finger's own way counts, so that one that comes or goes moves nothing.
        if (1..=3).contains(&count) && self.moved && !self.long {
            let sum: Vec2 = self.free().map(|finger| finger.at - finger.before).sum();
            gesture.drags[count - 1] = sum / count as f32 * Vec2::new(1.0, -1.0);
        }
        if count == 2 && self.moved {
            let mut two = self.free();
            if let (Some(a), Some(b)) = (two.next(), two.next()) {
                let (before, now) = (b.before - a.before, b.at - a.at);
                if before.length() > APART && now.length() > APART {
                    gesture.pinch = (now.length() / before.length()).log2();
                    // Screens count down, so that this is clockwise.
                    gesture.twist = before.angle_to(now).to_degrees();
                }
            }
        }
        for finger in self.fingers.iter_mut().flatten() {
            finger.before = finger.at;
            finger.frames = finger.frames.saturating_add(1);
        }
        gesture
    }

    /// Whether any finger of the scene is there.
    pub(crate) fn any(&self) -> bool {
        self.free().next().is_some()
    }

    /// The window has lost the focus: nothing is there any more.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}

impl Gesture {
    /// What an input says.
    pub(crate) fn value(&self, touch: Touch) -> Vec2 {
        let flag = |down: bool| Vec2::new(f32::from(u8::from(down)), 0.0);
        match touch {
            Touch::Drag => self.drags[0],
            Touch::Drag2 => self.drags[1],
            Touch::Drag3 => self.drags[2],
            Touch::Pinch => Vec2::new(self.pinch, 0.0),
            Touch::Twist => Vec2::new(self.twist, 0.0),
            Touch::LongPress => flag(self.long),
            // The second of two taps is a tap too.
            Touch::Tap => flag(matches!(self.tap, Some(Touch::Tap | Touch::DoubleTap))),
            Touch::DoubleTap | Touch::Tap2 | Touch::Tap3 => flag(self.tap == Some(touch)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: f32 = 1.0 / 60.0;

    struct Screen(Fingers);

    impl Screen {
        fn say(&mut self, id: u64, phase: TouchPhase, x: f32, y: f32) {
            self.0.hear(&TouchInput {
                phase,
                position: Vec2::new(x, y),
                window: Entity::PLACEHOLDER,
                force: None,
                id,
            });
        }

        fn down(&mut self, id: u64, x: f32, y: f32) {
            self.say(id, TouchPhase::Started, x, y);
        }

        fn to(&mut self, id: u64, x: f32, y: f32) {
            self.say(id, TouchPhase::Moved, x, y);
        }

        fn up(&mut self, id: u64) {
            self.say(id, TouchPhase::Ended, 0.0, 0.0);
        }

        fn frame(&mut self) -> Gesture {
            self.0.frame(FRAME, false)
        }
    }

    fn screen() -> Screen {
        Screen(Fingers::default())
    }

    #[test]
    fn one_finger_drags_and_taps_nothing() {
        let mut s = screen();
        s.down(1, 100.0, 100.0);
        assert_eq!(s.frame(), Gesture::default());
        s.to(1, 120.0, 90.0);
        let moved = s.frame();
        assert_eq!(moved.drags, [Vec2::new(20.0, 10.0), Vec2::ZERO, Vec2::ZERO]);
        s.up(1);
        assert_eq!(s.frame(), Gesture::default());
    }

    #[test]
    fn fingers_that_come_and_go_make_no_jumps() {
        let mut s = screen();
        s.down(1, 100.0, 100.0);
        s.to(1, 130.0, 100.0);
        s.frame();
        // Far away, and nothing moves.
        s.down(2, 500.0, 400.0);
        assert_eq!(s.frame(), Gesture::default());
        s.to(1, 140.0, 100.0);
        s.to(2, 510.0, 400.0);
        let two = s.frame();
        assert_eq!(two.drags, [Vec2::ZERO, Vec2::new(10.0, 0.0), Vec2::ZERO]);
        assert!(two.pinch.abs() < 1e-6 && two.twist.abs() < 1e-4);
        s.up(1);
        assert_eq!(s.frame(), Gesture::default());
        s.to(2, 511.0, 400.0);
        assert_eq!(s.frame().drags[0], Vec2::new(1.0, 0.0));
    }

    #[test]
    fn two_fingers_pinch_in_doublings_and_turn_in_degrees() {
        let mut s = screen();
        s.down(1, 100.0, 100.0);
        s.down(2, 200.0, 100.0);
        s.frame();
        s.to(1, 50.0, 100.0);
        s.to(2, 250.0, 100.0);
        let spread = s.frame();
        assert!((spread.pinch - 1.0).abs() < 1e-6 && spread.drags[1] == Vec2::ZERO);
        // The right one goes down on the screen: clockwise.
        s.to(1, 150.0, 0.0);
        s.to(2, 150.0, 200.0);
        let turned = s.frame();
        assert!((turned.twist - 90.0).abs() < 1e-3 && turned.pinch.abs() < 1e-6);
    }

    #[test]
    fn taps_are_told_apart() {
        let mut s = screen();
        s.down(1, 100.0, 100.0);
        s.up(1);
        assert_eq!(s.frame().tap, Some(Touch::Tap));
        assert_eq!(s.frame().tap, None);
        s.down(2, 110.0, 100.0);
        s.frame();
        s.up(2);
        assert_eq!(s.frame().tap, Some(Touch::DoubleTap));
        // A third one begins anew.
        s.down(3, 110.0, 100.0);
        s.up(3);
        assert_eq!(s.frame().tap, Some(Touch::Tap));
        for (fingers, tap) in [(2, Touch::Tap2), (3, Touch::Tap3)] {
            for id in 0..fingers {
                s.down(id, 100.0 * id as f32, 50.0);
                s.frame();
            }
            for id in 0..fingers {
                s.up(id);
            }
            assert_eq!(s.frame().tap, Some(tap));
        }
    }

    #[test]
    fn what_is_held_is_a_long_press_and_no_tap() {
        let mut s = screen();
        s.down(1, 100.0, 100.0);
        let pressed = (0..40).filter(|_| s.frame().long).count();
        assert!((8..=11).contains(&pressed), "{pressed}");
        s.up(1);
        assert_eq!(s.frame(), Gesture::default());
    }

    #[test]
    fn fingers_on_a_panel_are_the_panels() {
        let mut s = screen();
        s.down(1, 100.0, 100.0);
        s.frame();
        // The panel says so a frame late.
        s.0.frame(FRAME, true);
        s.to(1, 300.0, 100.0);
        assert_eq!(s.frame(), Gesture::default());
        // Another one on the scene drags with one finger.
        s.down(2, 500.0, 100.0);
        s.frame();
        s.to(2, 520.0, 100.0);
        assert_eq!(s.frame().drags[0], Vec2::new(20.0, 0.0));
        // What began on the scene goes on over a panel.
        s.to(2, 540.0, 100.0);
        assert_eq!(s.0.frame(FRAME, true).drags[0], Vec2::ZERO, "it has just come");
    }

    #[test]
    fn floods_of_fingers_are_borne() {
        let mut s = screen();
        for id in 0..1000 {
            s.down(id, id as f32, f32::NAN);
            s.down(id, id as f32, 5.0);
            s.to(id, 1e9, -1e9);
        }
        assert_eq!(s.frame().drags, [Vec2::ZERO; 3]);
        for id in 0..1000 {
            s.up(id);
        }
        s.frame();
        assert!(!s.0.any());
    }
}

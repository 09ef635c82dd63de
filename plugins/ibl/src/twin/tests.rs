//! The shader and its twin give the same.

use bevy::math::{IVec2, Mat4, URect, UVec2, Vec2, Vec3, Vec4};

use super::{Image, Input, Output, gpu, rest, step};
use crate::{
    camera::{Action, Pose, Step},
    changes::Disturb,
    uniform::{Accumulation, Changed},
};

/// Rows of a float are 256 bytes.
const SIZE: IVec2 = IVec2::new(64, 48);

/// Numbers from 0 to 1 that look like chance (xorshift).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
}

fn image<T>(mut value: impl FnMut(IVec2) -> T) -> Image<T> {
    let pixels = (0..SIZE.y).flat_map(|y| (0..SIZE.x).map(move |x| IVec2::new(x, y)));
    Image { width: SIZE.x, values: pixels.map(&mut value).collect() }
}

fn pose(eye: Vec3) -> Pose {
    let target = Vec3::new(0.0, 0.0, -5.0);
    let size = SIZE.as_uvec2();
    let clip = Mat4::perspective_infinite_reverse_rh(1.0, size.x as f32 / size.y as f32, 0.1);
    Pose {
        clip_from_world: clip * Mat4::look_at_rh(eye, target, Vec3::Y),
        eye,
        forward: (target - eye).normalize(),
        viewport: URect::from_corners(UVec2::new(3, 2), size - UVec2::new(2, 4)),
        exposure: 1.0,
    }
}

/// A wall with a box before it and a window to the sky, and whatever was kept of it.
fn input(eye: Vec3) -> Input {
    let mut chance = Chance(77);
    let mut colour = |most: f32| {
        image(|_| {
            Vec4::new(chance.next(), 2.0 * chance.next(), chance.next(), most * chance.next())
        })
    };
    let metres = |pixel: IVec2| match pixel {
        p if p.x > 48 && p.y < 20 => None,
        p if (20..40).contains(&p.x) && p.y > 15 => Some(3.0),
        _ => Some(6.0),
    };
    let mut frame = colour(1.0);
    frame.values[70] = Vec4::new(f32::INFINITY, -1.0, 1e9, 1.0);
    Input {
        frame,
        moved: colour(40.0),
        rested: colour(1.0),
        // Some were at an edge.
        distance: image(|p| match (metres(p), p.x % 8) {
            (Some(metres), 0) => -metres,
            (Some(metres), _) => metres,
            (None, 0) => -1e30,
            (None, _) => 0.0,
        }),
        depth: image(|p| metres(p).map_or(0.0, |metres| 0.1 / metres)),
        motion: image(
            |p| if p.y > 40 { Vec2::new(0.05, -0.02) } else { Vec2::new(eye.x, 0.0) * 0.01 },
        ),
    }
}

fn cases() -> Vec<(&'static str, Accumulation, Input, bool)> {
    let here = Vec3::new(0.02, 0.01, 0.0);
    let one = Step {
        action: Action::Move,
        pose: pose(here),
        previous: pose(Vec3::ZERO),
        still: 0,
        cycle: 40,
        longest: 30.0,
        jitter: Vec2::new(0.3, -0.2),
        fresh: false,
    };
    let changes = [
        Disturb { sphere: Some((Vec3::new(0.0, 0.0, -3.0), 0.5)), keep: 0.0 },
        Disturb { sphere: Some((Vec3::new(2.0, 0.0, -6.0), 1.0)), keep: 4.0 },
        Disturb { sphere: None, keep: 20.0 },
    ];
    let changed: Vec<Changed> = changes.iter().map(Changed::from).collect();
    let darker = Pose { exposure: 0.5, ..one.pose };
    let case = |name, step: Step, has_motion, changes: &[Changed]| {
        let still = step.action == Action::Rest;
        (name, Accumulation::new(&step, has_motion, changes), input(here), still)
    };
    vec![
        case("the first frame", Step { fresh: true, ..one }, true, &[]),
        case("the camera moves", one, true, &[]),
        case("without motion vectors", one, false, &[]),
        case("things change", one, true, &changed),
        case("exposure changes", Step { pose: darker, ..one }, true, &[]),
        case("rest ends", Step { still: 13, ..one }, true, &changed),
        case("rest begins", Step { action: Action::Rest, ..one }, true, &[]),
        case("at rest", Step { action: Action::Rest, still: 13, ..one }, true, &[]),
        case("rest is over the cycle", Step { action: Action::Rest, still: 55, ..one }, true, &[]),
    ]
}

#[test]
fn the_shader_gives_what_its_twin_gives() {
    let device = match gpu::open() {
        Ok(device) => device,
        Err(reason) => {
            println!("the accumulation on a device SKIPPED: {reason}");
            return;
        }
    };
    for (name, accumulation, input, still) in cases() {
        let outputs = device.run(&accumulation, &input, still);
        let [x, y, width, height] = accumulation.viewport.map(|v| v as i32);
        let (mut apart, mut worst, mut kept) = (0, 0.0_f32, 0);
        for py in y..y + height {
            for px in x..x + width {
                let pixel = IVec2::new(px, py);
                let told = outputs[(py * SIZE.x + px) as usize];
                let expected = if still {
                    rest(&accumulation, &input, pixel)
                } else {
                    step(&accumulation, &input, pixel)
                };
                let error = difference(told, expected);
                worst = worst.max(error.min(1.0));
                // Half floats are exact to 5e-4.
                apart += usize::from(error > 2e-3);
                kept += usize::from(expected.mean.w > 1.0);
            }
        }
        let pixels = (width * height) as usize;
        println!("{name}: {apart} of {pixels} differ, worst {worst:.1e}; {kept} keep something");
        // Rounding may put a place on the other side of a pixel's middle or of a tolerance.
        assert!(apart * 200 <= pixels, "{name}: {apart} of {pixels} differ");
        if name != "the first frame" && !still {
            assert!(kept * 2 > pixels, "{name}: only {kept} keep something");
        }
    }
}

/// Relative to what is expected.
fn difference(told: Output, expected: Output) -> f32 {
    let of = |a: Vec4, b: Vec4| ((a - b).abs() / (b.abs() + 0.05)).max_element();
    of(told.colour, expected.colour)
        .max(of(told.mean, expected.mean))
        .max((told.distance - expected.distance).abs() / (expected.distance + 0.05))
}

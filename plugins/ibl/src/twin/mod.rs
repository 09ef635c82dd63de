//! `shaders/ibl/accumulate.wgsl` on the CPU: the specification, and a test that compares both.

mod gpu;
mod tests;

use bevy::math::{IVec2, Mat4, Vec2, Vec3, Vec4, Vec4Swizzles};

use crate::uniform::Accumulation;

/// A picture of `width * height` values, rows from the top.
#[derive(Clone, Debug)]
struct Image<T> {
    width: i32,
    values: Vec<T>,
}

impl<T: Copy> Image<T> {
    fn at(&self, pixel: IVec2) -> T {
        self.values[(pixel.y * self.width + pixel.x) as usize]
    }
}

/// What the pass reads.
struct Input {
    frame: Image<Vec4>,
    moved: Image<Vec4>,
    rested: Image<Vec4>,
    distance: Image<f32>,
    depth: Image<f32>,
    motion: Image<Vec2>,
}

/// What it writes for a pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Output {
    colour: Vec4,
    mean: Vec4,
    distance: f32,
}

/// A frame of a still picture.
fn rest(a: &Accumulation, input: &Input, pixel: IVec2) -> Output {
    let drawn = clamped(input.frame.at(pixel));
    let before = input.rested.at(pixel);
    let mean = if a.still > 0.0 { before + (drawn - before) / (a.still + 1.0) } else { drawn };
    let shown = both(a, input.moved.at(pixel), mean.xyz(), a.still + 1.0);
    Output { colour: shown.extend(mean.w), mean, distance: 0.0 }
}

/// A frame of a picture that moves along.
fn step(a: &Accumulation, input: &Input, pixel: IVec2) -> Output {
    let drawn = clamped(input.frame.at(pixel));
    let [x, y, width, height] = a.viewport;
    let (origin, size) = (Vec2::new(x, y), Vec2::new(width, height));
    let position = pixel.as_vec2() + 0.5;
    let uv = (position - origin + Vec2::from(a.jitter)) / size;
    let ndc = Vec2::new(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0);
    let depth = input.depth.at(pixel);
    let world = Mat4::from_cols_array(&a.world_from_clip) * Vec4::new(ndc.x, ndc.y, depth, 1.0);
    let is_sky = depth <= 0.0;
    let place = world.xyz() / if is_sky { 1.0 } else { world.w };
    let along = |eye: [f32; 4], forward: [f32; 4]| {
        (place - Vec4::from(eye).xyz()).dot(Vec4::from(forward).xyz())
    };
    let (mut distance, mut expected) = (0.0, 0.0);
    if !is_sky {
        distance = along(a.eye, a.forward);
        expected = along(a.previous_eye, a.previous_forward);
    }
    let (mut frames, mut mean) = (0.0, Vec3::ZERO);
    let before = Mat4::from_cols_array(&a.previous_clip_from_world) * world;
    if a.flags & 1 == 0 && before.w != 0.0 {
        let before = before.xy() / before.w * Vec2::new(0.5, -0.5) + 0.5;
        let (mut step, mut tolerance) = (uv - before, 0.02);
        if a.flags & 2 != 0 {
            let told = input.motion.at(pixel);
            if ((told - step).abs() * size).max_element() > 0.25 {
                (step, tolerance) = (told, 0.2);
            }
        }
        let kept = kept_between(a, input, position - step * size, expected, tolerance);
        mean = kept.xyz() * a.scale;
        frames = kept.w.min(frames_left(a, (!is_sky).then_some(place)));
    }
    mean += (drawn.xyz() - mean) / (frames + 1.0);
    Output { colour: mean.extend(drawn.w), mean: mean.extend(frames + 1.0), distance }
}

fn clamped(drawn: Vec4) -> Vec4 {
    drawn.clamp(Vec4::ZERO, Vec4::splat(65504.0))
}

fn left_of_moved(a: &Accumulation, still: f32) -> f32 {
    (1.0 - still / a.cycle).max(0.0)
}

fn both(a: &Accumulation, moved: Vec4, rested: Vec3, still: f32) -> Vec3 {
    let left = moved.w * left_of_moved(a, still);
    moved.xyz().lerp(rested, still / (still + left).max(1.0))
}

fn kept_at(a: &Accumulation, input: &Input, pixel: IVec2) -> Vec4 {
    let mean = input.moved.at(pixel);
    if a.still <= 0.0 {
        return mean;
    }
    let frames = a.still + mean.w * left_of_moved(a, a.still);
    both(a, mean, input.rested.at(pixel).xyz(), a.still).extend(frames)
}

/// The mean of what changes leave at a place, or of the sky.
fn frames_left(a: &Accumulation, place: Option<Vec3>) -> f32 {
    let mut left = a.longest;
    for change in &a.changes[..a.change_count as usize] {
        let (sphere, keep) = (Vec4::from(change.sphere), change.keep);
        if sphere.w < 0.0 {
            left = left.min(keep);
        } else if let Some(place) = place {
            let radii = place.distance(sphere.xyz()) / sphere.w.max(1e-6);
            left = left.min(if radii <= 1.0 { keep } else { keep.max(1.0) * radii * radii });
        }
    }
    left.max(0.0)
}

/// Mean and frames at a place between pixels; nothing where another surface was seen.
fn kept_between(
    a: &Accumulation,
    input: &Input,
    place: Vec2,
    expected: f32,
    tolerance: f32,
) -> Vec4 {
    let [x, y, width, height] = a.viewport.map(|v| v as i32);
    let (low, high) = (IVec2::new(x, y), IVec2::new(x + width, y + height) - 1);
    let base = (place - 0.5).floor();
    let t = place - 0.5 - base;
    let base = base.as_ivec2();
    let same = |pixel: IVec2| {
        if pixel.cmplt(low).any() || pixel.cmpgt(high).any() {
            return false;
        }
        let seen = input.distance.at(pixel);
        if expected <= 0.0 || seen <= 0.0 {
            return expected <= 0.0 && seen <= 0.0;
        }
        (seen - expected).abs() <= tolerance * expected
    };
    let (mut sum, mut weights) = (Vec4::ZERO, 0.0);
    let (mut least, mut most) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let pixel = base + IVec2::new(dx, dy);
        if same(pixel) {
            let side = |d: i32, t: f32| if d == 0 { 1.0 - t } else { t };
            let weight = side(dx, t.x) * side(dy, t.y);
            let kept = kept_at(a, input, pixel);
            sum += kept * weight;
            weights += weight;
            least = least.min(kept.xyz());
            most = most.max(kept.xyz());
        }
    }
    if weights < 1e-3 {
        return Vec4::ZERO;
    }
    let linear = sum / weights;
    if weights < 0.9999 || t.min(1.0 - t).cmplt(Vec2::splat(1e-3)).all() {
        return linear;
    }
    let (across, down) = (catmull_rom(t.x), catmull_rom(t.y));
    let (mut smooth, mut weights) = (Vec3::ZERO, 0.0);
    for y in 0..4 {
        for x in 0..4 {
            let is_corner = (x == 0 || x == 3) && (y == 0 || y == 3);
            if !is_corner {
                let pixel = (base + IVec2::new(x, y) - 1).clamp(low, high);
                let weight = across[x as usize] * down[y as usize];
                smooth += kept_at(a, input, pixel).xyz() * weight;
                weights += weight;
            }
        }
    }
    (smooth / weights).clamp(least, most).extend(linear.w)
}

/// A Catmull-Rom spline between the second and the third of four values.
fn catmull_rom(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        0.5 * (-t3 + 2.0 * t2 - t),
        0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
        0.5 * (-3.0 * t3 + 4.0 * t2 + t),
        0.5 * (t3 - t2),
    ]
}

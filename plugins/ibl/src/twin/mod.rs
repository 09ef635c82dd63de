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
    let size = Vec4::from(a.viewport).zw();
    let seen = around(a, input, pixel);
    let is_sky = seen.here <= 0.0;
    let place = (!is_sky).then(|| place_at(a, uv_of(a, pixel), seen.here));
    let is_edge = seen.nearest > seen.farthest * (1.05 + 2.0 * seen.slope);

    // All of an edge moves along with what is nearest in it.
    let nearest = pixel + seen.step;
    let uv = uv_of(a, nearest);
    let previous = Mat4::from_cols_array(&a.previous_clip_from_world);
    let before = previous * world_at(a, uv, seen.nearest);
    let (mut frames, mut mean, mut mixed) = (0.0, Vec3::ZERO, false);
    if a.flags & 1 == 0 && before.w != 0.0 {
        let before = before.xy() / before.w * Vec2::new(0.5, -0.5) + 0.5;
        let (mut step, mut tolerance) = (uv - before, (0.02 + seen.slope).min(0.3));
        if a.flags & 2 != 0 {
            let told = input.motion.at(nearest);
            if ((told - step).abs() * size).max_element() > 0.25 {
                (step, tolerance) = (told, tolerance.max(0.2));
            }
        }
        let before = |depth: f32| match depth {
            d if d <= 0.0 => SKY,
            d => along(place_at(a, uv_of(a, pixel), d), a.previous_eye, a.previous_forward),
        };
        let own = before(seen.here);
        let own = [own * (1.0 - tolerance), own * (1.0 + tolerance)];
        let range =
            [before(seen.nearest) * (1.0 - tolerance), before(seen.farthest) * (1.0 + tolerance)];
        let (kept, kept_mixed) =
            kept_between(a, input, pixel.as_vec2() + 0.5 - step * size, range, own, is_edge);
        mixed = is_edge && kept_mixed;
        mean = kept.xyz() * a.scale;
        frames = kept.w.min(frames_left(a, place));
    }
    mean += (drawn.xyz() - mean) / (frames + 1.0);
    let distance = match (place, mixed) {
        (Some(place), false) => along(place, a.eye, a.forward),
        (Some(place), true) => -along(place, a.eye, a.forward),
        (None, false) => 0.0,
        (None, true) => -SKY,
    };
    Output { colour: mean.extend(drawn.w), mean: mean.extend(frames + 1.0), distance }
}

/// The distance of the sky.
const SKY: f32 = 1e30;
/// Where there is no edge, a mean of both sides of one counts as so many frames, and so little beside
/// what is of one side.
const LEFT_OF_EDGE: f32 = 0.1;
const EDGE_WEIGHT: f32 = 0.01;
/// Frames that count of an edge, and beside what moved.
const LONGEST_EDGE: f32 = 24.0;
const LONGEST_BESIDE: f32 = 3.0;

/// What was drawn in a pixel and beside it: depths, the nearest one's place, the change of distance
/// from pixel to pixel as a part of it.
struct Around {
    here: f32,
    nearest: f32,
    farthest: f32,
    step: IVec2,
    slope: f32,
}

fn around(a: &Accumulation, input: &Input, pixel: IVec2) -> Around {
    let (low, high) = inside(a);
    let here = input.depth.at(pixel);
    let steps = [IVec2::NEG_X, IVec2::X, IVec2::NEG_Y, IVec2::Y];
    let beside = steps.map(|step| input.depth.at((pixel + step).clamp(low, high)));
    let nearest = beside.into_iter().fold(here, f32::max);
    let last = steps.iter().zip(beside).rfind(|(_, depth)| *depth > here && *depth == nearest);
    let change = |i: usize| (beside[i] - here).abs().min((beside[i + 1] - here).abs());
    Around {
        here,
        nearest,
        farthest: beside.into_iter().fold(here, f32::min),
        step: last.map_or(IVec2::ZERO, |(step, _)| *step),
        slope: (change(0) + change(2)) / here.max(1e-9),
    }
}

/// First and last pixel of the viewport.
fn inside(a: &Accumulation) -> (IVec2, IVec2) {
    let [x, y, width, height] = a.viewport.map(|v| v as i32);
    (IVec2::new(x, y), IVec2::new(x + width, y + height) - 1)
}

/// Where the middle of a pixel lies, without jitter.
fn uv_of(a: &Accumulation, pixel: IVec2) -> Vec2 {
    let viewport = Vec4::from(a.viewport);
    (pixel.as_vec2() + 0.5 - viewport.xy() + Vec2::from(a.jitter)) / viewport.zw()
}

fn world_at(a: &Accumulation, uv: Vec2, depth: f32) -> Vec4 {
    let ndc = Vec4::new(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, depth, 1.0);
    Mat4::from_cols_array(&a.world_from_clip) * ndc
}

fn place_at(a: &Accumulation, uv: Vec2, depth: f32) -> Vec3 {
    let world = world_at(a, uv, depth);
    world.xyz() / world.w
}

fn along(place: Vec3, eye: [f32; 4], forward: [f32; 4]) -> f32 {
    (place - Vec4::from(eye).xyz()).dot(Vec4::from(forward).xyz())
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

/// The most frames that changes leave at a place, or of the sky.
fn frames_left(a: &Accumulation, place: Option<Vec3>) -> f32 {
    let mut left = a.longest;
    for change in &a.changes[..a.change_count as usize] {
        let (sphere, keep) = (Vec4::from(change.sphere), change.keep);
        if sphere.w < 0.0 {
            left = left.min(keep);
        } else if let Some(place) = place {
            let radii = place.distance(sphere.xyz()) / sphere.w.max(1e-6);
            let beside = keep.clamp(1.0, LONGEST_BESIDE) * radii * radii;
            left = left.min(if radii <= 1.0 { keep } else { beside });
        }
    }
    left.max(0.0)
}

/// Mean and frames at a place between pixels, nothing where another surface was seen; and whether it
/// is of other surfaces, too.
fn kept_between(
    a: &Accumulation,
    input: &Input,
    place: Vec2,
    [near, far]: [f32; 2],
    [own_near, own_far]: [f32; 2],
    is_edge: bool,
) -> (Vec4, bool) {
    let (low, high) = inside(a);
    let base = (place - 0.5).floor();
    let t = place - 0.5 - base;
    let base = base.as_ivec2();
    let seen = |pixel: IVec2| match input.distance.at(pixel) {
        0.0 => SKY,
        distance => distance.abs(),
    };
    let same = |pixel: IVec2| {
        let inside = pixel.cmpge(low).all() && pixel.cmple(high).all();
        inside && (near..=far).contains(&seen(pixel))
    };
    let (mut sum, mut weights, mut mixed) = (Vec4::ZERO, 0.0, 0.0);
    let (mut least, mut most) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let pixel = base + IVec2::new(dx, dy);
        if same(pixel) {
            let side = |d: i32, t: f32| if d == 0 { 1.0 - t } else { t };
            let is_mixed =
                input.distance.at(pixel) < 0.0 || !(own_near..=own_far).contains(&seen(pixel));
            let less = if is_mixed && !is_edge { EDGE_WEIGHT } else { 1.0 };
            let weight = side(dx, t.x) * side(dy, t.y) * less;
            let kept = kept_at(a, input, pixel);
            sum += kept * weight;
            weights += weight;
            mixed += if is_mixed { weight } else { 0.0 };
            least = least.min(kept.xyz());
            most = most.max(kept.xyz());
        }
    }
    if weights < 1e-3 {
        return (Vec4::ZERO, false);
    }
    let mut linear = sum / weights;
    let mixed = mixed / weights;
    if !is_edge {
        let left = linear.w.min(LEFT_OF_EDGE);
        linear.w += (left - linear.w) * mixed;
    } else {
        linear.w = linear.w.min(LONGEST_EDGE);
    }
    if weights < 0.9999 || t.min(1.0 - t).cmplt(Vec2::splat(1e-3)).all() {
        return (linear, mixed > 0.1);
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
    ((smooth / weights).clamp(least, most).extend(linear.w), mixed > 0.1)
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

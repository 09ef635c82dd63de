// The mean of the pictures of many frames, each lit by another group of lights.
//
// Twin on the CPU: `plugins/ibl/src/twin.rs`, the specification.

struct Change {
    // Centre in the world, radius in metres (negative: everywhere).
    sphere: vec4<f32>,
    // So many frames are kept inside of the sphere; beyond it more and more.
    keep: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

struct Accumulation {
    // From clip space (not jittered) to the world, and the other way, now and before.
    world_from_clip: mat4x4<f32>,
    clip_from_world: mat4x4<f32>,
    previous_clip_from_world: mat4x4<f32>,
    // Where the camera was and looked to.
    eye: vec4<f32>,
    forward: vec4<f32>,
    previous_eye: vec4<f32>,
    previous_forward: vec4<f32>,
    // Viewport: origin and size in pixels.
    viewport: vec4<f32>,
    // Sub-pixel offset of this frame, in pixels.
    jitter: vec2<f32>,
    // Frames of the still mean so far.
    still: f32,
    // Frames of a whole cycle.
    cycle: f32,
    // Kept frames while moving, at most.
    longest: f32,
    // Multiplies what is kept (another exposure).
    scale: f32,
    // Bit 0: nothing is kept; bit 1: there are motion vectors.
    flags: u32,
    change_count: u32,
    changes: array<Change, 16>,
}

@group(0) @binding(0) var<uniform> accumulation: Accumulation;
// The frame as it was just drawn.
@group(0) @binding(1) var frame: texture_2d<f32>;
// Mean of what moved along, and of how many frames (alpha).
@group(0) @binding(2) var moved: texture_2d<f32>;
// Mean since everything is still.
@group(0) @binding(3) var rested: texture_2d<f32>;
#ifndef STILL
// Distance of what `moved` shows, in metres along the view; 0 is the sky.
@group(0) @binding(4) var moved_distance: texture_2d<f32>;
@group(0) @binding(5) var depth: texture_depth_2d;
@group(0) @binding(6) var motion: texture_2d<f32>;
#endif

// One frame's light; what is no number would stay for ever.
fn drawn_at(pixel: vec2<i32>) -> vec4<f32> {
    return clamp(textureLoad(frame, pixel, 0), vec4(0.0), vec4(65504.0));
}

// How much of what moved along still counts, after so many still frames.
fn left_of_moved(still: f32) -> f32 {
    return max(0.0, 1.0 - still / accumulation.cycle);
}

// Both means as one, in proportion to the frames that they stand for.
fn both(moved_mean: vec4<f32>, rested_mean: vec3<f32>, still: f32) -> vec3<f32> {
    let left = moved_mean.a * left_of_moved(still);
    return mix(moved_mean.rgb, rested_mean, still / max(still + left, 1.0));
}

#ifdef STILL

struct Output {
    @location(0) colour: vec4<f32>,
    @location(1) rested: vec4<f32>,
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> Output {
    let pixel = vec2<i32>(position.xy);
    let drawn = drawn_at(pixel);
    var mean = drawn;
    if accumulation.still > 0.0 {
        let before = textureLoad(rested, pixel, 0);
        mean = before + (drawn - before) / (accumulation.still + 1.0);
    }
    var output: Output;
    output.rested = mean;
    output.colour = vec4(both(textureLoad(moved, pixel, 0), mean.rgb, accumulation.still + 1.0), mean.a);
    return output;
}

#else

struct Output {
    @location(0) colour: vec4<f32>,
    @location(1) moved: vec4<f32>,
    @location(2) distance: f32,
}

struct Kept {
    mean: vec3<f32>,
    frames: f32,
}

fn inside(pixel: vec2<i32>) -> bool {
    let low = vec2<i32>(accumulation.viewport.xy);
    let high = low + vec2<i32>(accumulation.viewport.zw);
    return all(pixel >= low) && all(pixel < high);
}

// What is kept of a pixel: mean and frames.
fn kept_at(pixel: vec2<i32>) -> vec4<f32> {
    let mean = textureLoad(moved, pixel, 0);
#ifdef RESTED
    let frames = accumulation.still + mean.a * left_of_moved(accumulation.still);
    return vec4(both(mean, textureLoad(rested, pixel, 0).rgb, accumulation.still), frames);
#else
    return mean;
#endif
}

// The same of the nearest pixel of the viewport.
fn kept_within(pixel: vec2<i32>) -> vec4<f32> {
    let low = vec2<i32>(accumulation.viewport.xy);
    let high = low + vec2<i32>(accumulation.viewport.zw) - 1;
    return kept_at(clamp(pixel, low, high));
}

// Weights of four neighbours in a Catmull-Rom spline, at `t` between the second and the third.
fn catmull_rom(t: f32) -> vec4<f32> {
    let t2 = t * t;
    let t3 = t2 * t;
    return 0.5 * vec4(
        -t3 + 2.0 * t2 - t,
        3.0 * t3 - 5.0 * t2 + 2.0,
        -3.0 * t3 + 4.0 * t2 + t,
        t3 - t2,
    );
}

// Whether a kept pixel shows what is `expected` metres away (0: the sky).
fn same_surface(pixel: vec2<i32>, expected: f32, tolerance: f32) -> bool {
    if !inside(pixel) {
        return false;
    }
    let seen = textureLoad(moved_distance, pixel, 0).x;
    if expected <= 0.0 || seen <= 0.0 {
        return expected <= 0.0 && seen <= 0.0;
    }
    return abs(seen - expected) <= tolerance * expected;
}

// One of the four pixels round a place: its mean and frames, weight 0 if it shows another surface.
struct Corner {
    kept: vec4<f32>,
    weight: f32,
}

fn corner_at(pixel: vec2<i32>, weight: f32, expected: f32, tolerance: f32) -> Corner {
    if !same_surface(pixel, expected, tolerance) {
        return Corner(vec4(0.0), 0.0);
    }
    return Corner(kept_at(pixel), weight);
}

// What is kept at a place between pixels, of the surface in `expected` metres.
//
// No loops and no arrays: drivers that don't unroll them are many times slower.
fn kept_between(place: vec2<f32>, expected: f32, tolerance: f32) -> Kept {
    let low_corner = floor(place - 0.5);
    let base = vec2<i32>(low_corner);
    let t = place - 0.5 - low_corner;
    let u = 1.0 - t;
    let a = corner_at(base, u.x * u.y, expected, tolerance);
    let b = corner_at(base + vec2(1, 0), t.x * u.y, expected, tolerance);
    let c = corner_at(base + vec2(0, 1), u.x * t.y, expected, tolerance);
    let d = corner_at(base + vec2(1, 1), t.x * t.y, expected, tolerance);
    let weights = a.weight + b.weight + c.weight + d.weight;
    if weights < 1.0e-3 {
        return Kept(vec3(0.0), 0.0);
    }
    let linear = (a.kept * a.weight + b.kept * b.weight + c.kept * c.weight + d.kept * d.weight)
        / weights;
    // Sharper where all four are of the surface, by eight more around them (a Catmull-Rom spline
    // without its corners): what is moved a hundred times by parts of pixels would be blurred
    // otherwise. What these show can't reach beyond what the four show.
    if weights < 0.9999 || all(min(t, u) < vec2(1.0e-3)) {
        return Kept(linear.rgb, linear.a);
    }
    let across = catmull_rom(t.x);
    let down = catmull_rom(t.y);
    let inner = (a.kept.rgb * across.y + b.kept.rgb * across.z) * down.y
        + (c.kept.rgb * across.y + d.kept.rgb * across.z) * down.z;
    let above = kept_within(base + vec2(0, -1)).rgb * across.y
        + kept_within(base + vec2(1, -1)).rgb * across.z;
    let below = kept_within(base + vec2(0, 2)).rgb * across.y
        + kept_within(base + vec2(1, 2)).rgb * across.z;
    let left = kept_within(base + vec2(-1, 0)).rgb * down.y
        + kept_within(base + vec2(-1, 1)).rgb * down.z;
    let right = kept_within(base + vec2(2, 0)).rgb * down.y
        + kept_within(base + vec2(2, 1)).rgb * down.z;
    let sum = inner + above * down.x + below * down.w + left * across.x + right * across.w;
    let middle = (across.y + across.z) * (down.y + down.z);
    let sides = (across.y + across.z) * (down.x + down.w) + (across.x + across.w) * (down.y + down.z);
    let low = min(min(a.kept.rgb, b.kept.rgb), min(c.kept.rgb, d.kept.rgb));
    let high = max(max(a.kept.rgb, b.kept.rgb), max(c.kept.rgb, d.kept.rgb));
    return Kept(clamp(sum / (middle + sides), low, high), linear.a);
}

// The most frames that changes leave at a place of the world.
fn frames_left(place: vec3<f32>) -> f32 {
    var left = accumulation.longest;
    for (var i = 0u; i < accumulation.change_count; i++) {
        let sphere = accumulation.changes[i].sphere;
        let keep = accumulation.changes[i].keep;
        if sphere.w < 0.0 {
            left = min(left, keep);
            continue;
        }
        // Its shadow and its reflection reach further than it does, but less and less.
        let radii = distance(place, sphere.xyz) / max(sphere.w, 1.0e-6);
        left = min(left, select(max(keep, 1.0) * radii * radii, keep, radii <= 1.0));
    }
    return max(left, 0.0);
}

fn to_uv(clip: vec4<f32>) -> vec2<f32> {
    return clip.xy / clip.w * vec2(0.5, -0.5) + 0.5;
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> Output {
    let pixel = vec2<i32>(position.xy);
    let drawn = drawn_at(pixel);
    let origin = accumulation.viewport.xy;
    let size = accumulation.viewport.zw;

    // The surface that was drawn, in homogeneous coordinates: the sky is infinitely far.
    let uv = (position.xy - origin + accumulation.jitter) / size;
    let ndc = vec2(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0);
    let depth_here = textureLoad(depth, pixel, 0);
    let world = accumulation.world_from_clip * vec4(ndc, depth_here, 1.0);
    let is_sky = depth_here <= 0.0;
    let place = world.xyz / select(world.w, 1.0, is_sky);
    var distance_here = 0.0;
    var expected = 0.0;
    if !is_sky {
        distance_here = dot(place - accumulation.eye.xyz, accumulation.forward.xyz);
        expected = dot(place - accumulation.previous_eye.xyz, accumulation.previous_forward.xyz);
    }

    var frames = 0.0;
    var mean = vec3(0.0);
    let before = accumulation.previous_clip_from_world * world;
    if (accumulation.flags & 1u) == 0u && before.w != 0.0 {
        // By the camera's motion alone, exactly; or by what the surface says if that is another.
        var step = uv - to_uv(before);
        var tolerance = 0.02;
        if (accumulation.flags & 2u) != 0u {
            let told = textureLoad(motion, pixel, 0).xy;
            let apart = abs(told - step) * size;
            if max(apart.x, apart.y) > 0.25 {
                step = told;
                tolerance = 0.2;
            }
        }
        let from_place = position.xy - step * size;
        let kept = kept_between(from_place, expected, tolerance);
        frames = kept.frames;
        mean = kept.mean * accumulation.scale;
        if is_sky {
            frames = min(frames, accumulation.longest);
            for (var i = 0u; i < accumulation.change_count; i++) {
                if accumulation.changes[i].sphere.w < 0.0 {
                    frames = min(frames, accumulation.changes[i].keep);
                }
            }
        } else {
            frames = min(frames, frames_left(place));
        }
    }
    mean += (drawn.rgb - mean) / (frames + 1.0);

    var output: Output;
    output.moved = vec4(mean, frames + 1.0);
    output.distance = distance_here;
    output.colour = vec4(mean, drawn.a);
    return output;
}

#endif

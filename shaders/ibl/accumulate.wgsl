// The mean of the pictures of many frames, each lit by another group of lights.
//
// Twin on the CPU: `plugins/ibl/src/twin`, the specification.

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
    // Viewport: origin and size in pixels. First, where `present.wgsl` expects it.
    viewport: vec4<f32>,
    // From clip space (not jittered) to the world now, and the other way before.
    world_from_clip: mat4x4<f32>,
    previous_clip_from_world: mat4x4<f32>,
    // Where the camera was and looked to.
    eye: vec4<f32>,
    forward: vec4<f32>,
    previous_eye: vec4<f32>,
    previous_forward: vec4<f32>,
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
// Distance of what `moved` shows, in metres along the view; 0 is the sky. Negative where the mean is
// of both sides of an edge.
@group(0) @binding(4) var moved_distance: texture_2d<f32>;
@group(0) @binding(5) var depth: texture_depth_2d;
@group(0) @binding(6) var motion: texture_2d<f32>;
#endif

// Beyond the viewport lies what other cameras have drawn.
fn inside(pixel: vec2<i32>) -> bool {
    let low = vec2<i32>(accumulation.viewport.xy);
    let high = low + vec2<i32>(accumulation.viewport.zw);
    return all(pixel >= low) && all(pixel < high);
}

// The nearest pixel inside.
fn nearest_inside(pixel: vec2<i32>) -> vec2<i32> {
    let low = vec2<i32>(accumulation.viewport.xy);
    return clamp(pixel, low, low + vec2<i32>(accumulation.viewport.zw) - 1);
}

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
    if !inside(pixel) {
        return Output(textureLoad(frame, pixel, 0), vec4(0.0));
    }
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
    // Whether it is of other surfaces, too.
    mixed: bool,
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
    return kept_at(nearest_inside(pixel));
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

// Distances at which something is seen here and in the pixels beside; far beyond everything where
// the sky is among it.
struct Range {
    near: f32,
    far: f32,
    // Of the pixel itself.
    own_near: f32,
    own_far: f32,
}

const SKY: f32 = 1.0e30;

// Where there is no edge, a mean of both sides of one counts as so many frames, and so little beside
// what is of one side.
const LEFT_OF_EDGE: f32 = 0.1;
const EDGE_WEIGHT: f32 = 0.01;
// Frames that count of an edge: every one moves it by a part of a pixel, and blurs it.
const LONGEST_EDGE: f32 = 24.0;
// Frames that count where something moved, a radius beside it: shadows must follow.
const LONGEST_BESIDE: f32 = 3.0;

// One of the four pixels round a place: its mean and frames, weight 0 if it shows another surface.
struct Corner {
    kept: vec4<f32>,
    weight: f32,
    // The weight, if it is of other surfaces, too, or of another.
    mixed: f32,
}

fn corner_at(pixel: vec2<i32>, bilinear: f32, range: Range, is_edge: bool) -> Corner {
    // Whether it shows what is in the range: at an edge, both sides of it.
    let seen = textureLoad(moved_distance, pixel, 0).x;
    let distance = select(abs(seen), SKY, seen == 0.0);
    if !inside(pixel) || distance < range.near || distance > range.far {
        return Corner(vec4(0.0), 0.0, 0.0);
    }
    let mixed = seen < 0.0 || distance < range.own_near || distance > range.own_far;
    let weight = bilinear * select(1.0, EDGE_WEIGHT, mixed && !is_edge);
    return Corner(kept_at(pixel), weight, select(0.0, weight, mixed));
}

// What is kept at a place between pixels, of what is in the range.
//
// No loops and no arrays: drivers that don't unroll them are many times slower.
fn kept_between(place: vec2<f32>, range: Range, is_edge: bool) -> Kept {
    let low_corner = floor(place - 0.5);
    let base = vec2<i32>(low_corner);
    let t = place - 0.5 - low_corner;
    let u = 1.0 - t;
    let a = corner_at(base, u.x * u.y, range, is_edge);
    let b = corner_at(base + vec2(1, 0), t.x * u.y, range, is_edge);
    let c = corner_at(base + vec2(0, 1), u.x * t.y, range, is_edge);
    let d = corner_at(base + vec2(1, 1), t.x * t.y, range, is_edge);
    let weights = a.weight + b.weight + c.weight + d.weight;
    if weights < 1.0e-3 {
        return Kept(vec3(0.0), 0.0, false);
    }
    var linear = (a.kept * a.weight + b.kept * b.weight + c.kept * c.weight + d.kept * d.weight)
        / weights;
    let mixed = (a.mixed + b.mixed + c.mixed + d.mixed) / weights;
    if !is_edge {
        linear.a = mix(linear.a, min(linear.a, LEFT_OF_EDGE), mixed);
    } else {
        linear.a = min(linear.a, LONGEST_EDGE);
    }
    // Sharper where all four are of the surface, by eight more around them (a Catmull-Rom spline
    // without its corners): what is moved a hundred times by parts of pixels would be blurred
    // otherwise. What these show can't reach beyond what the four show.
    if weights < 0.9999 || all(min(t, u) < vec2(1.0e-3)) {
        return Kept(linear.rgb, linear.a, mixed > 0.1);
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
    return Kept(clamp(sum / (middle + sides), low, high), linear.a, mixed > 0.1);
}

// The most frames that changes leave at a place of the world, or of the sky.
fn frames_left(place: vec3<f32>, is_sky: bool) -> f32 {
    var left = accumulation.longest;
    for (var i = 0u; i < accumulation.change_count; i++) {
        let sphere = accumulation.changes[i].sphere;
        let keep = accumulation.changes[i].keep;
        if sphere.w < 0.0 {
            left = min(left, keep);
        }
        if sphere.w < 0.0 || is_sky {
            continue;
        }
        // Its shadow and its reflection reach further than it does, but less and less.
        let radii = distance(place, sphere.xyz) / max(sphere.w, 1.0e-6);
        let beside = clamp(keep, 1.0, LONGEST_BESIDE) * radii * radii;
        left = min(left, select(beside, keep, radii <= 1.0));
    }
    return max(left, 0.0);
}

// What was drawn in a pixel and beside it.
struct Around {
    // Depths of the pixel itself, and of the nearest and the farthest of the five.
    here: f32,
    nearest: f32,
    farthest: f32,
    // The nearest one's place beside the pixel.
    step: vec2<i32>,
    // By how much distance changes to the pixels beside, as a part of it: the smaller change of
    // each axis, so that an edge is none. Depth is linear in a plane on the screen.
    slope: f32,
}

fn depth_beside(pixel: vec2<i32>, step: vec2<i32>) -> f32 {
    return textureLoad(depth, nearest_inside(pixel + step), 0);
}

fn around(pixel: vec2<i32>) -> Around {
    let here = textureLoad(depth, pixel, 0);
    let left = depth_beside(pixel, vec2(-1, 0));
    let right = depth_beside(pixel, vec2(1, 0));
    let above = depth_beside(pixel, vec2(0, -1));
    let below = depth_beside(pixel, vec2(0, 1));
    let nearest = max(here, max(max(left, right), max(above, below)));
    let farthest = min(here, min(min(left, right), min(above, below)));
    var step = vec2(0, 0);
    step = select(step, vec2(-1, 0), left > here && left == nearest);
    step = select(step, vec2(1, 0), right > here && right == nearest);
    step = select(step, vec2(0, -1), above > here && above == nearest);
    step = select(step, vec2(0, 1), below > here && below == nearest);
    let across = min(abs(left - here), abs(right - here));
    let down = min(abs(above - here), abs(below - here));
    return Around(here, nearest, farthest, step, (across + down) / max(here, 1.0e-9));
}

// Where the middle of a pixel lies, without jitter.
fn uv_of(pixel: vec2<i32>) -> vec2<f32> {
    let middle = vec2<f32>(pixel) + 0.5 - accumulation.viewport.xy;
    return (middle + accumulation.jitter) / accumulation.viewport.zw;
}

// A place of the world in homogeneous coordinates: the sky is infinitely far.
fn world_at(uv: vec2<f32>, depth_there: f32) -> vec4<f32> {
    let ndc = vec2(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0);
    return accumulation.world_from_clip * vec4(ndc, depth_there, 1.0);
}

// How far from the camera's place before something is.
fn distance_before(uv: vec2<f32>, depth_there: f32) -> f32 {
    if depth_there <= 0.0 {
        return SKY;
    }
    let world = world_at(uv, depth_there);
    let place = world.xyz / world.w;
    return dot(place - accumulation.previous_eye.xyz, accumulation.previous_forward.xyz);
}

fn to_uv(clip: vec4<f32>) -> vec2<f32> {
    return clip.xy / clip.w * vec2(0.5, -0.5) + 0.5;
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> Output {
    let pixel = vec2<i32>(position.xy);
    if !inside(pixel) {
        return Output(textureLoad(frame, pixel, 0), vec4(0.0), 0.0);
    }
    let drawn = drawn_at(pixel);
    let size = accumulation.viewport.zw;

    let seen = around(pixel);
    let uv = uv_of(pixel);
    let world = world_at(uv, seen.here);
    let is_sky = seen.here <= 0.0;
    let place = world.xyz / select(world.w, 1.0, is_sky);
    let away = dot(place - accumulation.eye.xyz, accumulation.forward.xyz);
    let is_edge = seen.nearest > seen.farthest * (1.05 + 2.0 * seen.slope);

    // All of an edge moves along with what is nearest in it.
    let nearest_pixel = pixel + seen.step;
    let nearest_uv = uv_of(nearest_pixel);
    let before = accumulation.previous_clip_from_world * world_at(nearest_uv, seen.nearest);
    var frames = 0.0;
    var mean = vec3(0.0);
    var mixed = false;
    if (accumulation.flags & 1u) == 0u && before.w != 0.0 {
        // By the camera's motion alone, exactly; or by what the surface says if that is another.
        var step = nearest_uv - to_uv(before);
        // What was kept was seen up to a pixel beside.
        var tolerance = min(0.02 + seen.slope, 0.3);
        if (accumulation.flags & 2u) != 0u {
            let told = textureLoad(motion, nearest_pixel, 0).xy;
            let apart = abs(told - step) * size;
            if max(apart.x, apart.y) > 0.25 {
                step = told;
                tolerance = max(tolerance, 0.2);
            }
        }
        let own = distance_before(uv, seen.here);
        var range: Range;
        range.near = distance_before(uv, seen.nearest) * (1.0 - tolerance);
        range.far = distance_before(uv, seen.farthest) * (1.0 + tolerance);
        range.own_near = own * (1.0 - tolerance);
        range.own_far = own * (1.0 + tolerance);
        let kept = kept_between(position.xy - step * size, range, is_edge);
        mixed = is_edge && kept.mixed;
        frames = min(kept.frames, frames_left(place, is_sky));
        mean = kept.mean * accumulation.scale;
    }
    mean += (drawn.rgb - mean) / (frames + 1.0);

    var output: Output;
    output.moved = vec4(mean, frames + 1.0);
    let distance_here = select(away, select(0.0, SKY, mixed), is_sky);
    output.distance = select(distance_here, -distance_here, mixed);
    output.colour = vec4(mean, drawn.a);
    return output;
}

#endif

// A panel in the world: a picture on a quad, as it is. What lies under a pixel is averaged, so that
// text neither blurs nor shimmers, however near the panel is. What is nearer than the panel is seen before
// it, if the picture has a depth (DEPTH), of several samples a pixel (SAMPLES) or of one.

struct Quad {
    // From the quad (1 x 1 around the origin, x to the right, y up) to clip space.
    clip_from_panel: mat4x4<f32>,
    texels: vec2<f32>,
    // Of the picture that it is drawn over.
    pixels: vec2<f32>,
    // How much of it is seen through what is nearer.
    through: f32,
}

@group(0) @binding(0) var<uniform> quad: Quad;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var between: sampler;

#ifdef DEPTH
#ifdef SAMPLES
@group(0) @binding(3) var scene: texture_depth_multisampled_2d;
#else
@group(0) @binding(3) var scene: texture_depth_2d;
#endif
#endif

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) uv: vec2<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    // Lower left, lower right, upper left, upper right.
    let uv = vec2(f32(index & 1u), 1.0 - f32(index >> 1u));
    let place = vec4(uv.x - 0.5, 0.5 - uv.y, 0.0, 1.0);
    return Corner(quad.clip_from_panel * place, uv);
}

// Samples a direction at most: footprints up to 8 texels wide, as bilinear taps take two each.
const MOST: f32 = 4.0;

// Which part of a pixel has something nearer in it.
fn covered(position: vec4<f32>) -> f32 {
#ifdef DEPTH
    // Depths are those of a reversed projection: nearer is greater.
    let place = vec2<i32>(position.xy * vec2<f32>(textureDimensions(scene)) / quad.pixels);
#ifdef SAMPLES
    let samples = i32(textureNumSamples(scene));
    var count = 0.0;
    for (var sample = 0; sample < samples; sample += 1) {
        count += select(0.0, 1.0, textureLoad(scene, place, sample) > position.z);
    }
    return count / f32(samples);
#else
    return select(0.0, 1.0, textureLoad(scene, place, 0) > position.z);
#endif
#else
    return 0.0;
#endif
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4<f32> {
    let right = dpdx(in.uv);
    let down = dpdy(in.uv);
    let width = max(length(right * quad.texels), length(down * quad.texels));
    let taps = i32(clamp(ceil(width), 1.0, MOST));
    var sum = vec4(0.0);
    for (var y = 0; y < taps; y += 1) {
        for (var x = 0; x < taps; x += 1) {
            let place = (vec2(f32(x), f32(y)) + 0.5) / f32(taps) - 0.5;
            let uv = in.uv + right * place.x + down * place.y;
            sum += textureSampleLevel(picture, between, uv, 0.0);
        }
    }
    let seen = mix(1.0, quad.through, covered(in.position));
    return sum * seen / f32(taps * taps);
}

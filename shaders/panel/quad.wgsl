// A panel in the world: a picture on a quad, as it is. What lies under a pixel is averaged, so that
// text neither blurs nor shimmers, however near the panel is.

struct Quad {
    // From the quad (1 x 1 around the origin, x to the right, y up) to clip space.
    clip_from_panel: mat4x4<f32>,
    texels: vec2<f32>,
    padding: vec2<f32>,
}

@group(0) @binding(0) var<uniform> quad: Quad;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var between: sampler;

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
    return sum / f32(taps * taps);
}

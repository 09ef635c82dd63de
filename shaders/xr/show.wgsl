// A picture of an eye into another picture: all of it, or the middle that has the other's shape.

// Size and place, in the eye's picture, of what is shown: 1, 1, 0, 0 is all.
@group(0) @binding(0) var<uniform> part: vec4<f32>;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var linear_filter: sampler;

@fragment
fn fragment(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {
    let colour = textureSample(picture, linear_filter, uv * part.xy + part.zw);
    return vec4(colour.rgb, 1.0);
}

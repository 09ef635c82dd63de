// A refined picture, as it is kept. Beyond the viewport, what other cameras have drawn.

@group(0) @binding(0) var kept: texture_2d<f32>;
@group(0) @binding(1) var frame: texture_2d<f32>;
// Origin and size of the viewport in pixels: the first 16 bytes of `Accumulation`.
@group(0) @binding(2) var<uniform> viewport: vec4<f32>;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(position.xy);
    let place = position.xy - viewport.xy;
    if any(place < vec2(0.0)) || any(place >= viewport.zw) {
        return textureLoad(frame, pixel, 0);
    }
    return textureLoad(kept, pixel, 0);
}

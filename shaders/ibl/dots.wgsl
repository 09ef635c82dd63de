// The environment's lights as dots on the sky, drawn over a picture after it was kept.

struct Dots {
    // From the map's frame to clip space.
    clip_from_map: mat4x4<f32>,
    // Size of the viewport in pixels.
    viewport: vec2<f32>,
    // Radius of a dot in pixels.
    radius: f32,
    pad: f32,
    // Lights from the first to before the second shine in this frame.
    shining: vec2<u32>,
}

@group(0) @binding(0) var<uniform> dots: Dots;
// What hides dots: distance of the kept picture (see `accumulate.wgsl`) or depth of the frame; 0 is
// the sky in both.
#ifdef DEPTH
@group(0) @binding(1) var surface: texture_depth_2d;
#else
@group(0) @binding(1) var surface: texture_2d<f32>;
#endif

struct Corner {
    @builtin(position) position: vec4<f32>,
    // From the dot's middle, in radii.
    @location(0) place: vec2<f32>,
    @location(1) colour: vec4<f32>,
}

@vertex
fn vertex(
    @builtin(vertex_index) vertex: u32,
    // In the map's frame; w is the light's index.
    @location(0) direction: vec4<f32>,
) -> Corner {
    let light = u32(direction.w);
    let shines = light >= dots.shining.x && light < dots.shining.y;
    let place = vec2(f32(vertex & 1u), f32(vertex >> 1u)) * 2.0 - 1.0;
    let middle = dots.clip_from_map * vec4(direction.xyz, 0.0);
    // One pixel more for the soft edge.
    let radius = dots.radius * select(1.0, 1.8, shines);
    let step = place * (radius + 1.0) * 2.0 / dots.viewport;

    var corner: Corner;
    corner.place = place * (radius + 1.0) / radius;
    corner.colour = select(vec4(0.75, 0.8, 0.85, 0.7), vec4(2.2, 0.9, 0.12, 1.0), shines);
    corner.position = vec4(middle.xy / middle.w + step, 0.5, 1.0);
    if middle.w <= 1.0e-4 {
        // Behind the camera: no triangle.
        corner.position = vec4(2.0, 2.0, 0.5, 1.0);
    }
    return corner;
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(corner.position.xy);
#ifdef DEPTH
    let hidden = textureLoad(surface, pixel, 0) > 0.0;
#else
    let distance = abs(textureLoad(surface, pixel, 0).x);
    let hidden = distance > 0.0 && distance < 1.0e29;
#endif
    let from_middle = length(corner.place);
    let width = max(fwidth(from_middle), 1.0e-3);
    let cover = 1.0 - smoothstep(1.0 - width, 1.0 + width, from_middle);
    if hidden || cover <= 0.0 {
        discard;
    }
    // A dark rim, so that dots are seen on bright skies.
    let rim = smoothstep(0.62, 0.62 + width, from_middle);
    return vec4(mix(corner.colour.rgb, vec3(0.01), rim), corner.colour.a * cover);
}

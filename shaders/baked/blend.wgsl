// Baked light of several scenarios, each by its weight, into one texture. CPU twin: `blend/twin.rs` of
// `farlight_baked`.

struct Blend {
    // Weights of the textures, four in each vector.
    weights: array<vec4<f32>, 2>,
    // How many textures count; the others are the first one again.
    count: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> blend: Blend;

#ifdef VOLUME
@group(0) @binding(1) var mixed: texture_storage_3d<rgba16float, write>;
@group(0) @binding(2) var baked0: texture_3d<f32>;
@group(0) @binding(3) var baked1: texture_3d<f32>;
@group(0) @binding(4) var baked2: texture_3d<f32>;
@group(0) @binding(5) var baked3: texture_3d<f32>;
@group(0) @binding(6) var baked4: texture_3d<f32>;
@group(0) @binding(7) var baked5: texture_3d<f32>;
@group(0) @binding(8) var baked6: texture_3d<f32>;
@group(0) @binding(9) var baked7: texture_3d<f32>;
#else
@group(0) @binding(1) var mixed: texture_storage_2d<rgba16float, write>;
@group(0) @binding(2) var baked0: texture_2d<f32>;
@group(0) @binding(3) var baked1: texture_2d<f32>;
@group(0) @binding(4) var baked2: texture_2d<f32>;
@group(0) @binding(5) var baked3: texture_2d<f32>;
@group(0) @binding(6) var baked4: texture_2d<f32>;
@group(0) @binding(7) var baked5: texture_2d<f32>;
@group(0) @binding(8) var baked6: texture_2d<f32>;
@group(0) @binding(9) var baked7: texture_2d<f32>;
#endif

// The largest half float.
const MOST: f32 = 65504.0;

fn weight(index: u32) -> f32 {
    return blend.weights[index / 4u][index % 4u];
}

#ifdef VOLUME
@compute @workgroup_size(4, 4, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = id;
    if any(at >= textureDimensions(mixed)) {
        return;
    }
#else
@compute @workgroup_size(8, 8, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = id.xy;
    if any(at >= textureDimensions(mixed)) {
        return;
    }
#endif
    var sum = weight(0u) * textureLoad(baked0, at, 0).rgb;
    if blend.count > 1u { sum += weight(1u) * textureLoad(baked1, at, 0).rgb; }
    if blend.count > 2u { sum += weight(2u) * textureLoad(baked2, at, 0).rgb; }
    if blend.count > 3u { sum += weight(3u) * textureLoad(baked3, at, 0).rgb; }
    if blend.count > 4u { sum += weight(4u) * textureLoad(baked4, at, 0).rgb; }
    if blend.count > 5u { sum += weight(5u) * textureLoad(baked5, at, 0).rgb; }
    if blend.count > 6u { sum += weight(6u) * textureLoad(baked6, at, 0).rgb; }
    if blend.count > 7u { sum += weight(7u) * textureLoad(baked7, at, 0).rgb; }
    textureStore(mixed, at, vec4(clamp(sum, vec3(0.0), vec3(MOST)), 1.0));
}

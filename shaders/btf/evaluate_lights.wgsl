// Texels from one direction each under many lights: what the shading of a surface does, without the
// engine. A kernel of plugins/btf/codec/src/gpu.

#import farlight::math::sine_cosine
#import farlight::btf::angles::slice_of_direction
#import farlight::btf::evaluate::{evaluate_slices, view_slices}
#import farlight::btf::queries::{btf, queries, values}

// Unit vectors in the frame of the surface.
@group(0) @binding(4) var<storage, read> lights: array<vec4<f32>>;

@compute @workgroup_size(64)
fn evaluate_lights(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&queries) {
        return;
    }
    let query = queries[id.x];
    let slices = view_slices(btf, query.texel, query.angles.z, query.angles.w);
    let azimuth = sine_cosine(query.angles.w).yx;
    var sum = vec3(0.0);
    for (var light = 0u; light < arrayLength(&lights); light++) {
        let direction = lights[light].xyz;
        if direction.z >= 0.0 {
            sum += evaluate_slices(btf, slices, slice_of_direction(direction, azimuth));
        }
    }
    values[id.x] = vec4(sum, 1.0);
}

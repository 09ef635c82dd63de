// A list of queries: the kernel of plugins/btf/codec/src/gpu.

#import farlight::btf::angles::Angles
#import farlight::btf::evaluate::evaluate
#import farlight::btf::layout::Layout

struct Query {
    // Column and row.
    texel: vec2<u32>,
    // Theta and phi of the light, then of the view, in radians.
    angles: vec4<f32>,
}

@group(0) @binding(0) var<uniform> btf: Layout;
@group(0) @binding(2) var<storage, read> queries: array<Query>;
@group(0) @binding(3) var<storage, read_write> values: array<vec4<f32>>;

@compute @workgroup_size(64)
fn evaluate_points(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&queries) {
        return;
    }
    let query = queries[id.x];
    let angles = Angles(query.angles.x, query.angles.y, query.angles.z, query.angles.w);
    values[id.x] = vec4(evaluate(btf, query.texel, angles), 1.0);
}

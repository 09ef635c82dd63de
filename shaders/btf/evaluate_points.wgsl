// A list of queries: the kernel of plugins/btf/codec/src/gpu.

#import farlight::btf::angles::Angles
#import farlight::btf::evaluate::evaluate
#import farlight::btf::queries::{btf, queries, values}

@compute @workgroup_size(64)
fn evaluate_points(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&queries) {
        return;
    }
    let query = queries[id.x];
    let angles = Angles(query.angles.x, query.angles.y, query.angles.z, query.angles.w);
    values[id.x] = vec4(evaluate(btf, query.texel, angles), 1.0);
}

// Lists of queries and what they come to: what the kernels of plugins/btf/codec/src/gpu share.

#define_import_path farlight::btf::queries

#import farlight::btf::layout::Layout

struct Query {
    // Column and row.
    texel: vec2<u32>,
    // Theta and phi of the light (unused under a list of lights), then of the view, in radians.
    angles: vec4<f32>,
}

@group(0) @binding(0) var<uniform> btf: Layout;
@group(0) @binding(2) var<storage, read> queries: array<Query>;
@group(0) @binding(3) var<storage, read_write> values: array<vec4<f32>>;

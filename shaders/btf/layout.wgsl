// Where the tables of a material lie among its words: the twin of plugins/btf/codec/src/layout.rs,
// which describes the fields. Offsets count from the first word of the buffer.

#define_import_path farlight::btf::layout

const LOG_LUV: u32 = 1u;
const BETA_IN_SINE: u32 = 2u;

struct Packed {
    offset: u32,
    index_bits: u32,
    min: f32,
    step: f32,
}

struct Coded {
    offset: u32,
    stride: u32,
    min: f32,
    step: f32,
}

struct Layout {
    columns: u32,
    rows: u32,
    flags: u32,
    words: u32,
    phi_count: u32,
    theta_count: u32,
    alpha_count: u32,
    beta_count: u32,
    texels: Packed,
    azimuths: Packed,
    elevations: Packed,
    luminances: Packed,
    shapes: Coded,
    colour_rows: Coded,
    chromas: u32,
    factor: f32,
    reserved: vec2<u32>,
}

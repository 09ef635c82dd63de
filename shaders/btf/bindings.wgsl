// The materials that share one buffer of tables: the twin of plugins/btf/src/entry.rs.

#define_import_path farlight::btf::bindings

#import farlight::btf::layout::Layout

struct Entry {
    btf: Layout,
    repeat: vec2<f32>,
    gain: f32,
    environment_directions: u32,
    // Tables of texels at half, quarter, .. size, one after the other: first word, ...
    coarse_offset: u32,
    // ... how many, ...
    coarse_count: u32,
    // ... and two tints for each texel of them, for views along the normal and grazing ones:
    // 11, 11 and 10 bits, roots of shares of the greatest tint.
    coarse_tints: u32,
    coarse_most: f32,
    albedo_directions: u32,
    mean_red: f32,
    mean_green: f32,
    mean_blue: f32,
    // A light's share is min(1, fade * cosine): less than 1 where it stands lower than was measured.
    fade: f32,
    // Halvings of the picture's size: at least so many, or, less than 0, so many fewer than its size on
    // screen asks for.
    coarseness: f32,
}

#if AVAILABLE_STORAGE_BUFFER_BINDINGS >= 8
@group(#{MATERIAL_BIND_GROUP}) @binding(1) var<storage, read> btf_entries: array<Entry>;
#else
// Without room for storage buffers: the mean colour under diffuse light, and the gain.
@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> btf_mean: vec4<f32>;
#endif

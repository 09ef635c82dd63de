// The texels that a fragment sees, joined in linear light.
//
// Where the picture is shown large, the nearest texel or four of them. Where it is shown small,
// texels of a coarser picture, made at loading (plugins/btf/src/coarse.rs); which of two coarser
// pictures is told by a dither, so that the work stays the same.

#define_import_path farlight::btf::taps

#import bevy_pbr::utils::interleaved_gradient_noise
#import farlight::btf::{
    angles::{SliceAngles, azimuth, elevation},
    bindings::Entry,
    evaluate::{LightCell, ViewSlices, light_cell, linear_value, slice_value, view_slices},
    layout::Layout,
    tables::btf_words,
}

struct Taps {
    a: ViewSlices,
    weight_a: vec3<f32>,
#ifndef BTF_NEAREST
    b: ViewSlices,
    c: ViewSlices,
    d: ViewSlices,
    weight_b: vec3<f32>,
    weight_c: vec3<f32>,
    weight_d: vec3<f32>,
#endif
}

// How the picture lies on the screen: UVs times the repetitions, and their derivatives.
struct Footprint {
    uv: vec2<f32>,
    along_x: vec2<f32>,
    along_y: vec2<f32>,
    pixel: vec2<f32>,
}

// `direction` to the viewer in the frame of the surface.
fn find_taps(entry: ptr<function, Entry>, footprint: Footprint, direction: vec3<f32>) -> Taps {
    let btf = level_of(entry, footprint);
    let theta = elevation(direction);
    let phi = azimuth(direction);
    let size = vec2(f32(btf.columns), f32(btf.rows));
    let place = footprint.uv * size;

    var taps: Taps;
#ifdef BTF_NEAREST
    let texel = wrapped(floor(place), size);
    taps.a = view_slices(btf, texel, theta, phi);
    taps.weight_a = tint(entry, btf, texel, direction.z);
#else
    let corner = floor(place - 0.5);
    let near = place - 0.5 - corner;
    let far = 1.0 - near;
    let a = wrapped(corner, size);
    let b = wrapped(corner + vec2(1.0, 0.0), size);
    let c = wrapped(corner + vec2(0.0, 1.0), size);
    let d = wrapped(corner + vec2(1.0, 1.0), size);
    taps.a = view_slices(btf, a, theta, phi);
    taps.b = view_slices(btf, b, theta, phi);
    taps.c = view_slices(btf, c, theta, phi);
    taps.d = view_slices(btf, d, theta, phi);
    taps.weight_a = (far.x * far.y) * tint(entry, btf, a, direction.z);
    taps.weight_b = (near.x * far.y) * tint(entry, btf, b, direction.z);
    taps.weight_c = (far.x * near.y) * tint(entry, btf, c, direction.z);
    taps.weight_d = (near.x * near.y) * tint(entry, btf, d, direction.z);
#endif
    return taps;
}

// Reflected light for a light from a direction, 1 for a white diffuse surface that faces it.
fn reflectance(btf: Layout, taps: ptr<function, Taps>, light: SliceAngles) -> vec3<f32> {
    let cell = light_cell(btf, light);
#ifdef BTF_NEAREST
    return (*taps).weight_a * tap(btf, (*taps).a, cell);
#else
    return (*taps).weight_a * tap(btf, (*taps).a, cell)
        + (*taps).weight_b * tap(btf, (*taps).b, cell)
        + (*taps).weight_c * tap(btf, (*taps).c, cell)
        + (*taps).weight_d * tap(btf, (*taps).d, cell);
#endif
}

// What a texel's linear values are multiplied by: 1 in the picture itself.
fn tint(
    entry: ptr<function, Entry>,
    btf: Layout,
    texel: vec2<u32>,
    cosine_of_view: f32,
) -> vec3<f32> {
    if btf.texels.offset == (*entry).btf.texels.offset {
        return vec3(1.0);
    }
    let place = btf.texels.offset - (*entry).coarse_offset + texel.y * btf.columns + texel.x;
    let first = (*entry).coarse_tints + 2u * place;
    let share = grazing(cosine_of_view);
    return (*entry).coarse_most
        * mix(unit_tint(btf_words[first]), unit_tint(btf_words[first + 1u]), share);
}

fn unit_tint(word: u32) -> vec3<f32> {
    let root = vec3<f32>(vec3(word, word >> 11u, word >> 22u) & vec3(2047u, 2047u, 1023u))
        * vec3(1.0 / 2047.0, 1.0 / 2047.0, 1.0 / 1023.0);
    return root * root;
}

// Share of the tint for grazing views: the twin of `grazing` in coarse.rs.
fn grazing(cosine_of_view: f32) -> f32 {
    return min((1.0 - cosine_of_view) / 0.75, 1.0);
}

fn tap(btf: Layout, slices: ViewSlices, cell: LightCell) -> vec3<f32> {
    return linear_value(btf, slices.weights.x * slice_value(btf, slices.luminances.x, slices.chromas.x, cell)
        + slices.weights.y * slice_value(btf, slices.luminances.y, slices.chromas.y, cell)
        + slices.weights.z * slice_value(btf, slices.luminances.z, slices.chromas.z, cell)
        + slices.weights.w * slice_value(btf, slices.luminances.w, slices.chromas.w, cell));
}

fn wrapped(texel: vec2<f32>, size: vec2<f32>) -> vec2<u32> {
    return vec2<u32>(clamp(texel - size * floor(texel / size), vec2(0.0), size - 1.0));
}

// The layout of the picture whose texels are about as large as a pixel, or as coarse as is asked for.
fn level_of(entry: ptr<function, Entry>, footprint: Footprint) -> Layout {
    var btf = (*entry).btf;
    let size = vec2(f32(btf.columns), f32(btf.rows));
    let x = length(footprint.along_x * size);
    let y = length(footprint.along_y * size);
    // Where a pixel is long, half of its length: rather a little noise than a blur.
    let texels = max(min(x, y), 0.5 * max(x, y));
    let halvings = max(log2(max(texels, 1.0)) + min((*entry).coarseness, 0.0), (*entry).coarseness);
    if !(halvings > 0.0) || (*entry).coarse_count == 0u {
        return btf;
    }
    let dither = interleaved_gradient_noise(footprint.pixel, 0u);
    let level = u32(min(halvings + dither, f32((*entry).coarse_count)));
    if level == 0u {
        return btf;
    }
    btf.texels.offset = (*entry).coarse_offset;
    for (var finer = 1u; finer < level; finer++) {
        btf.texels.offset += max(btf.columns >> finer, 1u) * max(btf.rows >> finer, 1u);
    }
    btf.columns = max(btf.columns >> level, 1u);
    btf.rows = max(btf.rows >> level, 1u);
    return btf;
}

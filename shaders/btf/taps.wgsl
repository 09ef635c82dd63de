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
}

struct Taps {
    a: ViewSlices,
#ifndef BTF_NEAREST
    b: ViewSlices,
    c: ViewSlices,
    d: ViewSlices,
    weights: vec4<f32>,
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
    taps.a = view_slices(btf, wrapped(floor(place), size), theta, phi);
#else
    let corner = floor(place - 0.5);
    let near = place - 0.5 - corner;
    let far = 1.0 - near;
    taps.weights = vec4(far.x * far.y, near.x * far.y, far.x * near.y, near.x * near.y);
    taps.a = view_slices(btf, wrapped(corner, size), theta, phi);
    taps.b = view_slices(btf, wrapped(corner + vec2(1.0, 0.0), size), theta, phi);
    taps.c = view_slices(btf, wrapped(corner + vec2(0.0, 1.0), size), theta, phi);
    taps.d = view_slices(btf, wrapped(corner + vec2(1.0, 1.0), size), theta, phi);
#endif
    return taps;
}

// Reflected light for a light from a direction, 1 for a white diffuse surface that faces it.
fn reflectance(btf: Layout, taps: ptr<function, Taps>, light: SliceAngles) -> vec3<f32> {
    let cell = light_cell(btf, light);
#ifdef BTF_NEAREST
    return tap(btf, (*taps).a, cell);
#else
    return (*taps).weights.x * tap(btf, (*taps).a, cell)
        + (*taps).weights.y * tap(btf, (*taps).b, cell)
        + (*taps).weights.z * tap(btf, (*taps).c, cell)
        + (*taps).weights.w * tap(btf, (*taps).d, cell);
#endif
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

// The layout of the picture whose texels are about as large as a pixel.
fn level_of(entry: ptr<function, Entry>, footprint: Footprint) -> Layout {
    var btf = (*entry).btf;
    let size = vec2(f32(btf.columns), f32(btf.rows));
    let x = length(footprint.along_x * size);
    let y = length(footprint.along_y * size);
    // Where a pixel is long, half of its length: rather a little noise than a blur.
    let texels = max(min(x, y), 0.5 * max(x, y));
    if !(texels > 1.0) || (*entry).coarse_count == 0u {
        return btf;
    }
    let dither = interleaved_gradient_noise(footprint.pixel, 0u);
    let level = min(u32(log2(texels) + dither), (*entry).coarse_count);
    if level == 0u {
        return btf;
    }
    btf.texels.offset = (*entry).coarse_offset;
    for (var finer = 1u; finer < level; finer++) {
        btf.texels.offset += max(btf.columns >> finer, 1u) * max(btf.rows >> finer, 1u);
    }
    btf.columns = max(btf.columns >> level, 1u);
    btf.rows = max(btf.rows >> level, 1u);
    btf.texels.min = (*entry).coarse_min;
    btf.texels.step = (*entry).coarse_step;
    return btf;
}

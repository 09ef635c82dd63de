// Values of a material: the twin of plugins/btf/codec/src/evaluate/scalar.rs.
//
// What depends on the view is found once by `view_slices`, for any number of lights. A layout comes
// best from a uniform; one from a storage buffer is copied into a variable before a loop over lights.
//
// Definitions: BTF_GROUP and BTF_TABLES (tables.wgsl), and the rules of the specification:
// BTF_HALF_END_SLOPE, BTF_GUARD_BETA_POLE, BTF_LINEAR. Shading sets BTF_LINEAR alone.

#define_import_path farlight::btf::evaluate

#import farlight::math::{HALF_PI, finite}
#import farlight::btf::angles::{Angles, Cell, SliceAngles, above, cell_between, cell_in_sine, cell_on_circle, slice_of_angles}
#import farlight::btf::colour::{decode_log_luv, decode_ycbcr, linear}
#import farlight::btf::layout::{BETA_IN_SINE, Coded, LOG_LUV, Layout, Packed}
#import farlight::btf::tables::btf_words

// What a texel looks like from one direction: four slices with their weights.
struct ViewSlices {
    // Rows of luminances.
    luminances: vec4<u32>,
    // Rows of chromas.
    chromas: vec4<u32>,
    // Interpolation weights times the scales of three levels.
    weights: vec4<f32>,
}

// Where a light falls on the axes of a slice: found once for all slices.
struct LightCell {
    alpha: Cell,
    beta: Cell,
    // Of the curve over beta: three words of a row of shapes, as offsets from its first word, ...
    words: vec3<u32>,
    // ... and the weights of the codes in them, which sum to 1.
    first: vec2<f32>,
    second: vec2<f32>,
    third: f32,
}

// An entry of a table of indices with factors.
struct Entry {
    index: u32,
    factor: f32,
}

// An entry of the table of elevations.
struct SliceEntry {
    index: u32,
    factor: f32,
    chroma_row: u32,
}

// The value of a texel (column, row; both wrap round): red, green and blue in the range of the
// material's colour space, the cosine of the light already in it. Black below the horizon.
fn evaluate(btf: Layout, texel: vec2<u32>, angles: Angles) -> vec3<f32> {
    if !above(angles) {
        return vec3(0.0);
    }
    let slices = view_slices(btf, texel, angles.theta_v, angles.phi_v);
    let light = slice_of_angles(angles.theta_i, angles.phi_i - angles.phi_v);
    return evaluate_slices(btf, slices, light);
}

// The part of an evaluation that depends on texel and view.
fn view_slices(btf: Layout, texel: vec2<u32>, theta_v: f32, phi_v: f32) -> ViewSlices {
    let place = texel % vec2(btf.columns, btf.rows);
    let start = packed_entry(btf.texels, place.y * btf.columns + place.x);
    let theta = cell_between(finite(theta_v), 0.0, HALF_PI, btf.theta_count);
    // The stored azimuth of a view runs the other way round.
    let phi = cell_on_circle(finite(-phi_v), btf.phi_count);
    let azimuths = start.index * btf.phi_count;
    let low = packed_entry(btf.azimuths, azimuths + phi.low);
    let high = packed_entry(btf.azimuths, azimuths + phi.high);
    let low_row = low.index * btf.theta_count;
    let high_row = high.index * btf.theta_count;
    let a = slice_entry(btf.elevations, low_row + theta.low);
    let b = slice_entry(btf.elevations, low_row + theta.high);
    let c = slice_entry(btf.elevations, high_row + theta.low);
    let d = slice_entry(btf.elevations, high_row + theta.high);

    let around = vec2(1.0 - phi.weight, phi.weight) * vec2(low.factor, high.factor) * start.factor;
    let upwards = vec2(1.0 - theta.weight, theta.weight);
    return ViewSlices(
        vec4(a.index, b.index, c.index, d.index),
        vec4(a.chroma_row, b.chroma_row, c.chroma_row, d.chroma_row),
        around.xxyy * upwards.xyxy * vec4(a.factor, b.factor, c.factor, d.factor),
    );
}

// The part of an evaluation that depends on the light.
fn evaluate_slices(btf: Layout, slices: ViewSlices, light: SliceAngles) -> vec3<f32> {
    let cell = light_cell(btf, light);
    return slices.weights.x * slice_value(btf, slices.luminances.x, slices.chromas.x, cell)
        + slices.weights.y * slice_value(btf, slices.luminances.y, slices.chromas.y, cell)
        + slices.weights.z * slice_value(btf, slices.luminances.z, slices.chromas.z, cell)
        + slices.weights.w * slice_value(btf, slices.luminances.w, slices.chromas.w, cell);
}

// A value as a factor of light: 1 reflects as much as a white diffuse surface. HDR values are linear
// already (BTF_LINEAR).
fn linear_value(btf: Layout, value: vec3<f32>) -> vec3<f32> {
    if (btf.flags & LOG_LUV) != 0u {
        return value;
    }
    return linear(value * (1.0 / 255.0));
}

fn light_cell(btf: Layout, light: SliceAngles) -> LightCell {
    var cell: LightCell;
    cell.alpha = cell_between(light.alpha, -HALF_PI, HALF_PI, btf.alpha_count);
    if (btf.flags & BETA_IN_SINE) != 0u {
        cell.beta = cell_in_sine(light, btf.beta_count);
    } else {
        cell.beta = cell_between(light.beta, -HALF_PI, HALF_PI, btf.beta_count);
    }
    let low = cell.beta.low;
    let weights = curve_weights(cell.beta, low == 0u, low + 2u == btf.beta_count);
    // Two codes a word. The curve goes through those of low - 1 to low + 2.
    let middle = (low + 1u) / 2u;
    cell.words = vec3(max(middle, 1u) - 1u, middle, middle + 1u);
    if (low & 1u) == 1u {
        cell.first = weights.xy;
        cell.second = weights.zw;
        // Nothing of the third word is needed: one that is already there serves.
        cell.words.z = middle;
    } else {
        cell.first = vec2(0.0, weights.x);
        cell.second = weights.yz;
        cell.third = weights.w;
    }
    return cell;
}

// Cubic Hermite interpolation as weights of the samples low - 1, low, low + 1, low + 2. The ends of
// the axis have one-sided slopes.
fn curve_weights(cell: Cell, first: bool, last: bool) -> vec4<f32> {
    let t = cell.weight;
    let s = 1.0 - t;
    let start = t * s * s;
    let end = -t * t * s;
    let value = t * t * (3.0 - 2.0 * t);
    var weights = vec4(0.0, 1.0 - value, value, 0.0);
    weights += select(vec4(-0.5, 0.0, 0.5, 0.0), vec4(0.0, -1.0, 1.0, 0.0), first) * start;
#ifdef BTF_HALF_END_SLOPE
    let inner = vec4(0.0, -0.5, 0.5, 0.0);
#else
    let inner = vec4(0.0, -0.5, 0.0, 0.5);
#endif
    weights += select(inner, vec4(0.0, -1.0, 1.0, 0.0), last) * end;
    return weights;
}

// One slice: red, green and blue before its weight.
fn slice_value(btf: Layout, luminance_row: u32, chroma_row: u32, cell: LightCell) -> vec3<f32> {
    let row = luminance_row * btf.alpha_count;
    let low = packed_entry(btf.luminances, row + cell.alpha.low);
    let high = packed_entry(btf.luminances, row + cell.alpha.high);
    let luma = (1.0 - cell.alpha.weight) * low.factor * shape(btf.shapes, low.index, cell)
        + cell.alpha.weight * high.factor * shape(btf.shapes, high.index, cell);

    let chromas = btf.chromas + chroma_row * btf.alpha_count;
    let near = row_chroma(btf.colour_rows, btf_words[chromas + cell.alpha.low], cell.beta);
    let far = row_chroma(btf.colour_rows, btf_words[chromas + cell.alpha.high], cell.beta);
    let codes = mix(near, far, cell.alpha.weight);
    let chroma = btf.colour_rows.min + codes * btf.colour_rows.step;
    if (btf.flags & LOG_LUV) != 0u {
        return decode_log_luv(luma, chroma, btf.factor);
    }
    return decode_ycbcr(luma, chroma);
}

// A point on the curve through a row of shapes.
fn shape(shapes: Coded, row: u32, cell: LightCell) -> f32 {
    let start = shapes.offset + row * shapes.stride;
    let codes = dot(cell.first, halves(btf_words[start + cell.words.x]))
        + dot(cell.second, halves(btf_words[start + cell.words.y]))
        + cell.third * f32(btf_words[start + cell.words.z] & 0xffffu);
    return shapes.min + codes * shapes.step;
}

fn halves(word: u32) -> vec2<f32> {
    return vec2(f32(word & 0xffffu), f32(word >> 16u));
}

// Codes of the chroma on a row of colours, linear over beta.
fn row_chroma(colours: Coded, row: u32, beta: Cell) -> vec2<f32> {
    let start = colours.offset + row * colours.stride;
    return mix(
        halves(btf_words[start + beta.low]),
        halves(btf_words[start + beta.high]),
        beta.weight,
    );
}

fn slice_entry(table: Packed, entry: u32) -> SliceEntry {
    let packed = packed_entry(table, 2u * entry);
    return SliceEntry(packed.index, packed.factor, btf_words[table.offset + 2u * entry + 1u]);
}

fn packed_entry(table: Packed, entry: u32) -> Entry {
    let word = btf_words[table.offset + entry];
    let index = word & ((1u << table.index_bits) - 1u);
    return Entry(index, table.min + f32(word >> table.index_bits) * table.step);
}

// From luminance and chroma to red, green and blue: the twin of plugins/btf/codec/src/colour.rs.

#define_import_path farlight::btf::colour

// 8-bit video luma with Cb and Cr (ITU-R BT.601); gamma-encoded, 0 to 255 and beyond.
fn decode_ycbcr(luma: f32, chroma: vec2<f32>) -> vec3<f32> {
    let grey = 1.1643828 * luma;
    return max(vec3(0.0), vec3(
        grey + 1.5960273 * chroma.y - 222.921,
        grey - 0.39176172 * chroma.x - 0.81296875 * chroma.y + 135.576,
        grey + 2.0172344 * chroma.x - 276.836,
    ));
}

// Logarithmic luma with 410 u' and 410 v', divided by `factor`: sRGB-encoded, 0 to 1 and beyond, or
// linear with BTF_LINEAR.
fn decode_log_luv(luma: f32, chroma: vec2<f32>, factor: f32) -> vec3<f32> {
    let luminance = luminance_of_log_luma(luma);
    let v = max(chroma.y, 1e-6);
    let x = 2.25 * (chroma.x / v) * luminance;
    let xyz = vec3(x, luminance, luminance * (3.0 * 410.0 / v - 5.0) - x / 3.0);
    // CIE XYZ to linear Rec. 709 (D65), IEC 61966-2-1.
    var rgb = max(vec3(0.0), vec3(
        dot(xyz, vec3(3.24097, -1.5373832, -0.49861076)),
        dot(xyz, vec3(-0.96924365, 1.8759675, 0.04155506)),
        dot(xyz, vec3(0.05563008, -0.20397696, 1.0569715)),
    ));
#ifndef BTF_LINEAR
    rgb = srgb_encode(rgb);
#endif
    return rgb / factor;
}

// Three pieces: linear, a power and an exponential.
fn luminance_of_log_luma(luma: f32) -> f32 {
    if luma < 98.381 {
        return 0.056968 * luma;
    }
    if luma < 1204.7 {
        // 7.3014e-30 (luma + 884.17)^9.9872, about 1024, where a power in f32 keeps its digits.
        return 8.469813907557 * pow((luma + 884.17) * (1.0 / 1024.0), 9.9872);
    }
    return 32.994 * exp(0.0047811 * luma);
}

// The sRGB curve from linear to encoded, its power branch continued above 1.
fn srgb_encode(rgb: vec3<f32>) -> vec3<f32> {
    let power = 1.055 * pow(max(rgb, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055;
    return select(power, 12.92 * rgb, rgb <= vec3(0.0031308));
}

// The sRGB curve from encoded to linear, its power branch continued above 1.
fn linear(rgb: vec3<f32>) -> vec3<f32> {
    let power = pow((max(rgb, vec3(0.04045)) + 0.055) * (1.0 / 1.055), vec3(2.4));
    return select(power, rgb * (1.0 / 12.92), rgb <= vec3(0.04045));
}

// Elementary functions to about 1e-6: what graphics interfaces promise for the built-in ones (Vulkan:
// 2^-11 for sines, 4096 units in the last place for arc functions) is too coarse for look-ups by
// angle. Polynomials are minimax fits; their errors stand beside them, f32 rounding comes on top.

#define_import_path farlight::math

const PI: f32 = 3.14159265358979;
const TAU: f32 = 6.28318530717959;
const HALF_PI: f32 = 1.57079632679490;

// 0 for infinities and what is not a number. By bits: compilers may assume that there are none.
fn finite(x: f32) -> f32 {
    return select(x, 0.0, (bitcast<u32>(x) & 0x7f800000u) == 0x7f800000u);
}

// Arc tangent of 0 to 1; 2.5e-7.
fn arc_tangent_of_ratio(x: f32) -> f32 {
    let s = x * x;
    var p = 0.00681179283;
    p = p * s - 0.0336042194;
    p = p * s + 0.0796236716;
    p = p * s - 0.132333421;
    p = p * s + 0.198078156;
    p = p * s - 0.333173681;
    p = p * s + 0.999996112;
    return p * x;
}

// Angle of the vector (x, y) from the first axis towards the second, -pi to pi; 0 for no vector.
fn arc_tangent(y: f32, x: f32) -> f32 {
    let a = abs(y);
    let b = abs(x);
    // The bound is the least normal number.
    var angle = arc_tangent_of_ratio(min(a, b) / max(max(a, b), 1.17549435e-38));
    angle = select(angle, HALF_PI - angle, a > b);
    angle = select(angle, PI - angle, x < 0.0);
    return select(angle, -angle, y < 0.0);
}

// Of -1 to 1, clamped; 1e-7.
fn arc_cosine(x: f32) -> f32 {
    let a = min(abs(x), 1.0);
    var p = 0.00261171997;
    p = p * a - 0.0120033934;
    p = p * a + 0.0277629118;
    p = p * a - 0.0491974362;
    p = p * a + 0.0888358856;
    p = p * a - 0.214591089;
    p = p * a + 1.57079624;
    let angle = p * sqrt(1.0 - a);
    return select(angle, PI - angle, x < 0.0);
}

// Of -1 to 1, clamped; 1e-7.
fn arc_sine(x: f32) -> f32 {
    let angle = HALF_PI - arc_cosine(abs(x));
    return select(angle, -angle, x < 0.0);
}

// Sine and cosine; 1e-7 up to a few turns, then losing digits as the angle itself does.
fn sine_cosine(angle: f32) -> vec2<f32> {
    let quarters = round(angle * (1.0 / HALF_PI));
    // A quarter turn in two parts, the first with few digits, so that its multiples are exact.
    let rest = (angle - quarters * 1.5703125) - quarters * 4.83826794897e-4;
    let r = clamp(rest, -0.8, 0.8);
    let s = r * r;
    let sine = r * (0.999999986 + s * (-0.166666368 + s * (0.00833158461 - s * 0.000194621171)));
    let cosine = 1.0 + s * (-0.499999996 + s * (0.0416666167 + s * (-0.00138866193 + s * 2.43799367e-5)));
    let quadrant = i32(quarters) & 3;
    let turned = select(vec2(sine, cosine), vec2(cosine, sine), (quadrant & 1) == 1);
    return vec2(
        select(turned.x, -turned.x, quadrant >= 2),
        select(turned.y, -turned.y, quadrant == 1 || quadrant == 2),
    );
}

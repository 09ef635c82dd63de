//! Sine, cosine and arc tangent of whole vectors, to about 1e-7 (radians, or of 1).

use std::f32::consts::{FRAC_2_PI, FRAC_PI_2};

use super::lanes::{Float, Int, Lanes};

/// Sine and cosine of angles of at most some thousand radians.
///
/// The reduction to an eighth of a turn is Cody and Waite's (*Software Manual for the Elementary
/// Functions*, 1980), the polynomials are those of Cephes (netlib.org/cephes, `sinf.c`).
#[inline(always)]
pub(super) fn sin_cos<L: Lanes>(lanes: L, angle: L::Float) -> (L::Float, L::Float) {
    let quarter = (angle * lanes.float(FRAC_2_PI)).round();
    // Pi/2 in two parts.
    let x = quarter.neg_mul_add(lanes.float(FRAC_PI_2), angle);
    let x = quarter.neg_mul_add(lanes.float(-4.371_139e-8), x);
    let z = x * x;
    let sine = z.mul_add(lanes.float(-1.951_529_6e-4), lanes.float(8.332_161e-3));
    let sine = z.mul_add(sine, lanes.float(-1.666_665_5e-1));
    let sine = (sine * z).mul_add(x, x);
    let cosine = z.mul_add(lanes.float(2.443_315_7e-5), lanes.float(-1.388_731_6e-3));
    let cosine = z.mul_add(cosine, lanes.float(4.166_664_6e-2));
    let cosine = z.mul_add(cosine, lanes.float(-0.5));
    let cosine = z.mul_add(cosine, lanes.float(1.0));

    let quadrant = quarter.to_int();
    let swap = (quadrant & lanes.int(1)).equals(lanes.int(1));
    let sign = |quadrant: L::Int| (quadrant & lanes.int(2)) << 30;
    let signed = |value: L::Float, sign: L::Int| value.bits().xor(sign).as_float();
    (
        signed(cosine.select(swap, sine), sign(quadrant)),
        signed(sine.select(swap, cosine), sign(quadrant + lanes.int(1))),
    )
}

/// The arc tangent of `y / x` for `x` of at least 0: -pi/2 to pi/2.
///
/// The polynomial is an expansion in Chebyshev's, of degree 17 in the tangent; it is off by 7e-8.
#[inline(always)]
pub(super) fn atan2_upper<L: Lanes>(lanes: L, y: L::Float, x: L::Float) -> L::Float {
    let sign = y.bits() & lanes.int(1 << 31);
    let height = (y.bits() & lanes.int(!(1 << 31))).as_float();
    let steep = x.less(height);
    let (least, most) = (height.min(x), height.max(x));
    // Both may be 0.
    let tangent = least.div(most.max(lanes.float(f32::MIN_POSITIVE)));
    let z = tangent * tangent;
    let series = [
        -2.036_447e-2,
        4.938_493_7e-2,
        -8.042_295e-2,
        1.087_740_8e-1,
        -1.425_903_7e-1,
        1.999_881e-1,
        -3.333_332_5e-1,
    ];
    let mut sum = lanes.float(3.962_16e-3);
    for coefficient in series {
        sum = sum.mul_add(z, lanes.float(coefficient));
    }
    let angle = (sum * z).mul_add(tangent, tangent);
    let angle = (lanes.float(FRAC_PI_2) - angle).select(steep, angle);
    (angle.bits().xor(sign)).as_float()
}

//! Least squares with polynomials in two variables, for the value at their origin.

use glam::Vec3;

/// Share of the constant's weight that is added to the diagonal for slopes and for curvatures: what the
/// samples don't tell is taken as flat.
const RIDGE: [f32; 2] = [0.001, 0.0005];

/// Which of the products 1, x, y, x², xy, y², x³, x²y, xy², y³, x⁴, x³y, x²y², xy³, y⁴ is that of two terms.
const PRODUCT: [[usize; 6]; 6] = [
    [0, 1, 2, 3, 4, 5],
    [1, 3, 4, 6, 7, 8],
    [2, 4, 5, 7, 8, 9],
    [3, 6, 7, 10, 11, 12],
    [4, 7, 8, 11, 12, 13],
    [5, 8, 9, 12, 13, 14],
];

/// A sample for a fit.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub(super) x: f32,
    pub(super) y: f32,
    /// Above 0.
    pub(super) weight: f32,
    pub(super) value: Vec3,
    /// Variance of the value.
    pub(super) variance: Vec3,
}

/// Value at the origin, and its variance, of the polynomial with `N` terms (1, 3 or 6: of degree 0, 1
/// or 2) that fits best. At least one sample.
pub(super) fn fit<const N: usize>(samples: &[Sample]) -> (Vec3, Vec3) {
    // Sums of weight * terms[a] * terms[b]; equal products are summed once.
    let mut sums = [0.0; 15];
    for s in samples {
        let (x, y, w) = (s.x, s.y, s.weight);
        let (wx, wy) = (w * x, w * y);
        let (wxx, wxy, wyy) = (wx * x, wx * y, wy * y);
        let (xx, yy) = (x * x, y * y);
        let products = [
            w,
            wx,
            wy,
            wxx,
            wxy,
            wyy,
            wxx * x,
            wxx * y,
            wyy * x,
            wyy * y,
            wxx * xx,
            wxx * x * y,
            wxx * yy,
            wyy * y * x,
            wyy * yy,
        ];
        for (sum, product) in sums.iter_mut().zip(products) {
            *sum += product;
        }
    }
    let moments: [[f32; N]; N] =
        std::array::from_fn(|a| std::array::from_fn(|b| sums[PRODUCT[a][b]]));
    let row = first_row_of_inverse(moments);
    let (mut value, mut variance, mut sum) = (Vec3::ZERO, Vec3::ZERO, 0.0);
    for s in samples {
        let terms = terms::<N>(s);
        let share = (0..N).map(|a| row[a] * terms[a]).sum::<f32>() * s.weight;
        sum += share;
        value += s.value * share;
        variance += s.variance * (share * share);
    }
    (value / sum, variance / (sum * sum))
}

fn terms<const N: usize>(s: &Sample) -> [f32; N] {
    let all = [1.0, s.x, s.y, s.x * s.x, s.x * s.y, s.y * s.y];
    std::array::from_fn(|k| all[k])
}

/// First row of the inverse of a symmetric matrix (its lower half counts), by Cholesky's method.
fn first_row_of_inverse<const N: usize>(mut m: [[f32; N]; N]) -> [f32; N] {
    let constant = m[0][0];
    for k in 1..N {
        m[k][k] += constant * RIDGE[usize::from(k > 2)];
    }
    for j in 0..N {
        for k in 0..j {
            m[j][j] -= m[j][k] * m[j][k];
        }
        // Rounding must not make it negative.
        m[j][j] = m[j][j].max(constant * 1e-6).sqrt();
        for i in j + 1..N {
            for k in 0..j {
                m[i][j] -= m[i][k] * m[j][k];
            }
            m[i][j] /= m[j][j];
        }
    }
    let mut row = [0.0; N];
    row[0] = 1.0;
    for i in 0..N {
        for k in 0..i {
            row[i] -= m[i][k] * row[k];
        }
        row[i] /= m[i][i];
    }
    for i in (0..N).rev() {
        for k in i + 1..N {
            row[i] -= m[k][i] * row[k];
        }
        row[i] /= m[i][i];
    }
    row
}

//! Least squares with polynomials in two variables, for the value at their origin.

use glam::Vec3;

/// Share of the constant's weight that is added to the diagonal for slopes and for curvatures: what the
/// samples don't tell is taken as flat.
const RIDGE: [f32; 2] = [0.001, 0.0005];

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
    let mut moments = [[0.0; N]; N];
    for s in samples {
        let terms = terms::<N>(s);
        for a in 0..N {
            let weighted = s.weight * terms[a];
            for b in 0..=a {
                moments[a][b] += weighted * terms[b];
            }
        }
    }
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

//! A few coordinates of long vectors, and the search for near ones by them.

use rayon::prelude::*;

/// Coordinates on a basis, and one for what the basis leaves out.
pub(super) const FEATURES: usize = 24;
pub(super) type Features = [f32; FEATURES];

/// How many near rows a search gives for a closer look.
pub(super) const NEAR: usize = 4;

/// Sum of products, in an order that compilers turn into vector instructions.
pub(super) fn dot(a: &[f32], b: &[f32]) -> f32 {
    let (a_heads, a_tail) = a.as_chunks::<8>();
    let (b_heads, b_tail) = b.as_chunks::<8>();
    let mut sums = [0.0_f32; 8];
    for (a, b) in a_heads.iter().zip(b_heads) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let tail: f32 = a_tail.iter().zip(b_tail).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f32>() + tail
}

/// Orthonormal directions along which some vectors vary most, near enough.
#[derive(Clone, Default)]
pub(super) struct Basis {
    length: usize,
    directions: Vec<f32>,
}

impl Basis {
    /// By orthogonal iteration from a start that depends on nothing but the sizes.
    pub(super) fn new(length: usize, samples: &[Vec<f32>]) -> Self {
        let count = (FEATURES - 1).min(length).min(samples.len());
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut random = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (state >> 40) as f32 / (1 << 24) as f32 - 0.5
        };
        let mut directions: Vec<Vec<f32>> =
            (0..count).map(|_| (0..length).map(|_| random()).collect()).collect();
        for _ in 0..8 {
            directions = directions
                .par_iter()
                .map(|direction| {
                    let mut next = vec![0.0; length];
                    for sample in samples {
                        let weight = dot(sample, direction);
                        next.iter_mut().zip(sample).for_each(|(next, s)| *next += weight * s);
                    }
                    next
                })
                .collect();
            orthonormalize(&mut directions);
        }
        Self { length, directions: directions.concat() }
    }

    /// Their distance is at most that of the vectors.
    pub(super) fn features(&self, vector: &[f32]) -> Features {
        let mut features = [0.0; FEATURES];
        let mut rest = dot(vector, vector);
        for (feature, direction) in
            features.iter_mut().zip(self.directions.chunks_exact(self.length.max(1)))
        {
            *feature = dot(vector, direction);
            rest -= *feature * *feature;
        }
        features[FEATURES - 1] = rest.max(0.0).sqrt();
        features
    }
}

/// Gram and Schmidt, twice for the sake of rounding; what vanishes becomes zero.
fn orthonormalize(vectors: &mut [Vec<f32>]) {
    for at in 0..vectors.len() {
        let (done, rest) = vectors.split_at_mut(at);
        let vector = &mut rest[0];
        let before = dot(vector, vector);
        for _ in 0..2 {
            for other in done.iter() {
                let along = dot(vector, other);
                vector.iter_mut().zip(other).for_each(|(v, o)| *v -= along * o);
            }
        }
        let length = dot(vector, vector);
        let scale = if length > 1e-9 * before { 1.0 / length.sqrt() } else { 0.0 };
        vector.iter_mut().for_each(|v| *v *= scale);
    }
}

/// Rows of a code-book by their features.
#[derive(Clone, Default)]
pub(super) struct Book {
    rows: Vec<Features>,
}

impl Book {
    pub(super) fn push(&mut self, features: Features) {
        self.rows.push(features);
    }

    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    pub(super) fn features(&self, row: u32) -> Features {
        self.rows[row as usize]
    }

    pub(super) fn set(&mut self, row: usize, features: Features) {
        self.rows[row] = features;
    }

    /// The nearest of the rows from `first` on, nearest first.
    pub(super) fn near(&self, features: &Features, first: usize) -> impl Iterator<Item = u32> {
        let mut best = [(f32::INFINITY, u32::MAX); NEAR];
        for (row, other) in (first as u32..).zip(&self.rows[first.min(self.rows.len())..]) {
            let mut distance = 0.0;
            for part in 0..FEATURES / 8 {
                let at = 8 * part;
                let mut squares = [0.0_f32; 8];
                for lane in 0..8 {
                    let difference = features[at + lane] - other[at + lane];
                    squares[lane] = difference * difference;
                }
                distance += squares.iter().sum::<f32>();
                if distance >= best[NEAR - 1].0 {
                    break;
                }
            }
            if distance < best[NEAR - 1].0 {
                let mut place = NEAR - 1;
                while place > 0 && best[place - 1].0 > distance {
                    best[place] = best[place - 1];
                    place -= 1;
                }
                best[place] = (distance, row);
            }
        }
        best.into_iter().map(|(_, row)| row).filter(|row| *row != u32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vectors(count: usize, length: usize) -> Vec<Vec<f32>> {
        let value = |i: usize, j: usize| {
            ((i * 37 + j) as f32 * 0.7).sin() + ((i * i) as f32 * 0.13 + j as f32 * 0.05).cos()
        };
        (0..count).map(|i| (0..length).map(|j| value(i, j)).collect()).collect()
    }

    #[test]
    fn features_never_exceed_a_distance_and_find_the_nearest() {
        let all = vectors(200, 61);
        let basis = Basis::new(61, &all[..80]);
        let features: Vec<_> = all.iter().map(|v| basis.features(v)).collect();
        let mut book = Book::default();
        features[1..].iter().for_each(|f| book.push(*f));
        let distance = |a: &[f32], b: &[f32]| {
            a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt()
        };
        for i in 0..all.len() {
            for j in 0..all.len() {
                let bound = distance(&features[i], &features[j]);
                let exact = distance(&all[i], &all[j]);
                assert!(bound <= exact + 1e-3, "{bound} {exact}");
            }
        }
        let nearest = (1..200).min_by(|a, b| {
            f32::total_cmp(&distance(&all[0], &all[*a]), &distance(&all[0], &all[*b]))
        });
        let found: Vec<_> = book.near(&features[0], 0).collect();
        assert!(found.contains(&(nearest.unwrap() as u32 - 1)), "{found:?} {nearest:?}");
        assert_eq!(Book::default().near(&features[0], 0).count(), 0);
        assert_eq!(book.near(&features[0], 198).count(), 1);
    }
}

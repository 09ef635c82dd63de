//! Coarser pictures of a material, for where it is seen from afar.
//!
//! A texel of the picture at half size has to look like the mean of four texels from every side. A
//! mean of functions of view and light is no row of the code-books, but one of those below it, with a
//! tint on its linear values, comes close. The tint has two ends, one for views along the normal and
//! one for grazing views, since what hides what changes with the view: cloth of two colours shows
//! them in other shares. Tints are such that the sums over the probes are those of the mean, in each
//! channel and for both ends; the texel is the one that differs the least. What is left over goes to
//! the neighbours that come next, as in error diffusion, so that the mean over the picture stays.

use bevy::math::Vec3;
use farlight_btf_codec::{Angles, Btf, Rules, SliceAngles};

/// Tables of texels at half, quarter, .. size, down to about 4 x 4 texels.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct CoarseLevels {
    /// Words of the material's own texels, level after level; then two tints for each of them.
    pub(crate) words: Vec<u32>,
    /// How many levels.
    pub(crate) count: u32,
    /// Texels of all levels: where the tints begin.
    pub(crate) texels: u32,
    /// The greatest tint, which the greatest codes stand for.
    pub(crate) most: f32,
    /// Mean of linear values under light from all round: the albedo as a colour.
    pub(crate) mean: Vec3,
}

/// Views (elevation, azimuth in degrees) and lights for which texels are compared.
const VIEWS: [(f64, f64); 9] = [
    (10.0, 30.0),
    (45.0, 20.0),
    (45.0, 110.0),
    (45.0, 200.0),
    (45.0, 290.0),
    (70.0, 65.0),
    (70.0, 155.0),
    (70.0, 245.0),
    (70.0, 335.0),
];
const LIGHTS: [(f64, f64); 4] = [(15.0, 30.0), (40.0, 130.0), (55.0, 260.0), (70.0, 10.0)];
const PROBES: usize = VIEWS.len() * LIGHTS.len();

/// Pictures of more texels have no coarser ones, to bound memory (0.2 GB while they are made) and time.
const MOST_TEXELS: u32 = 1 << 21;

/// No level after one of at most so many texels: one of a few texels cannot balance the others, and the
/// means of a sixteenth of the picture hardly differ.
const LEAST_TEXELS: u32 = 16;

/// Beyond this a texel would have to be another one.
const MOST_TINT: f32 = 16.0;

type Probes = [Vec3; PROBES];

/// Tints for views along the normal and for grazing ones.
type Tints = [Vec3; 2];

struct Block {
    texel: [u32; 2],
    tints: Tints,
}

/// Evaluates texels of a material for all views and lights.
struct Prober<'a> {
    btf: &'a Btf,
    lights: [[SliceAngles; LIGHTS.len()]; VIEWS.len()],
    /// Values are multiplied by these, so that in the picture's mean all probes count the same.
    scales: [f32; PROBES],
    /// Share of the second tint.
    grazing: [f32; PROBES],
}

/// Share of the tint for grazing views: the twin of `grazing` in taps.wgsl.
fn grazing(cosine_of_view: f32) -> f32 {
    ((1.0 - cosine_of_view) / 0.75).min(1.0)
}

impl<'a> Prober<'a> {
    fn new(btf: &'a Btf) -> Self {
        const GRID: u32 = 8;
        let grazing = std::array::from_fn(|probe| {
            grazing(VIEWS[probe / LIGHTS.len()].0.to_radians().cos() as f32)
        });
        let lights = VIEWS.map(|view| LIGHTS.map(|light| slice_angles(view, light)));
        let mut prober = Self { btf, lights, scales: [1.0; PROBES], grazing };
        let [columns, rows] = btf.size();
        let mut sums = [0.0; PROBES];
        for at in 0..GRID * GRID {
            let texel = [(at % GRID) * columns / GRID, (at / GRID) * rows / GRID];
            for (sum, value) in sums.iter_mut().zip(prober.values(texel)) {
                *sum += value.element_sum() / (3 * GRID * GRID) as f32;
            }
        }
        prober.scales = sums.map(|mean| 1.0 / mean.max(1e-3));
        prober
    }

    /// Linear values.
    fn values(&self, texel: [u32; 2]) -> Probes {
        let mut values = [Vec3::ZERO; PROBES];
        let [x, y] = texel.map(|edge| edge as i32);
        for (view, lights) in self.lights.iter().enumerate() {
            let angles = Angles::from_degrees(0.0, 0.0, VIEWS[view].0, VIEWS[view].1);
            let slices = self.btf.view_slices(x, y, angles.theta_v, angles.phi_v);
            for (light, angles) in lights.iter().enumerate() {
                let value = self.btf.evaluate_slices(&slices, *angles, Rules::SHADING);
                let probe = view * LIGHTS.len() + light;
                values[probe] = self.scales[probe] * self.btf.colour_space().to_linear(value);
            }
        }
        values
    }

    /// Tints with which values have the sums of a goal, for both ends.
    fn fit(&self, values: &Probes, goal: &Probes) -> Tints {
        let (mut a, mut b, mut c) = (Vec3::splat(1e-6), Vec3::ZERO, Vec3::splat(1e-6));
        let (mut near, mut far) = (Vec3::splat(1e-6), Vec3::splat(1e-6));
        for probe in 0..PROBES {
            let g = self.grazing[probe];
            a += (1.0 - g) * (1.0 - g) * values[probe];
            b += (1.0 - g) * g * values[probe];
            c += g * g * values[probe];
            near += (1.0 - g) * goal[probe];
            far += g * goal[probe];
        }
        let determinant = (a * c - b * b).max(Vec3::splat(1e-12));
        let limit = |tint: Vec3| tint.clamp(Vec3::ZERO, Vec3::splat(MOST_TINT));
        [limit((c * near - b * far) / determinant), limit((a * far - b * near) / determinant)]
    }

    /// The best of several texels, and what its values lack.
    fn best(&self, goal: &Probes, texels: impl Iterator<Item = [u32; 2]>) -> (Block, Probes) {
        let mut best = (f32::INFINITY, Block { texel: [0; 2], tints: [Vec3::ONE; 2] }, *goal);
        for texel in texels {
            let values = self.values(texel);
            let tints = self.fit(&values, goal);
            let lack: Probes = std::array::from_fn(|probe| {
                goal[probe] - tints[0].lerp(tints[1], self.grazing[probe]) * values[probe]
            });
            let difference = lack.iter().map(|lack| lack.length_squared()).sum();
            if difference < best.0 {
                best = (difference, Block { texel, tints }, lack);
            }
        }
        (best.1, best.2)
    }
}

/// Means of four neighbours each.
fn halved(size: [u32; 2], value: impl Fn([u32; 2]) -> Probes) -> ([u32; 2], Vec<Probes>) {
    let half = size.map(|edge| (edge / 2).max(1));
    let mut means = Vec::with_capacity((half[0] * half[1]) as usize);
    for y in 0..half[1] {
        for x in 0..half[0] {
            let mut sum = [Vec3::ZERO; PROBES];
            for [right, down] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                let at = [(2 * x + right).min(size[0] - 1), (2 * y + down).min(size[1] - 1)];
                for (sum, value) in sum.iter_mut().zip(value(at)) {
                    *sum += 0.25 * value;
                }
            }
            means.push(sum);
        }
    }
    (half, means)
}

/// A level from the means of its blocks.
fn level(prober: &Prober<'_>, step: u32, size: [u32; 2], means: &[Probes], to: &mut Vec<Block>) {
    let [columns, rows] = prober.btf.size();
    let width = size[0] as usize;
    // Few blocks are worth a longer search.
    let edge = match means.len() {
        ..=16 => 16,
        17..=64 => 8,
        _ => 3,
    }
    .min(1 << step);
    let mut above = vec![[Vec3::ZERO; PROBES]; width];
    for y in 0..size[1] {
        let mut left = [Vec3::ZERO; PROBES];
        for x in 0..size[0] {
            let at = y as usize * width + x as usize;
            let below = &mut above[x as usize];
            let goal: Probes =
                std::array::from_fn(|probe| means[at][probe] + left[probe] + below[probe]);
            let texels = (0..edge * edge).map(|at| {
                let inside = |at: u32| ((2 * at + 1) << step) / (2 * edge);
                [
                    ((x << step) + inside(at % edge)).min(columns - 1),
                    ((y << step) + inside(at / edge)).min(rows - 1),
                ]
            });
            let (block, lack) = prober.best(&goal, texels);
            to.push(block);
            left = lack.map(|lack| 0.5 * lack);
            *below = left;
        }
    }
}

impl CoarseLevels {
    pub(crate) fn of(btf: &Btf) -> Self {
        let layout = btf.layout();
        let mean = mean_albedo(btf);
        let mut size = [layout.columns, layout.rows];
        if size == [1, 1] || u64::from(size[0]) * u64::from(size[1]) > u64::from(MOST_TEXELS) {
            return Self { mean, ..Self::default() };
        }
        let prober = Prober::new(btf);
        let (mut blocks, mut count) = (Vec::new(), 1);
        let (half, mut means) = halved(size, |texel| prober.values(texel));
        size = half;
        level(&prober, count, size, &means, &mut blocks);
        while size[0] * size[1] > LEAST_TEXELS {
            let finer = std::mem::take(&mut means);
            let (half, coarser) = halved(size, |[x, y]| finer[(y * size[0] + x) as usize]);
            (size, means) = (half, coarser);
            count += 1;
            level(&prober, count, size, &means, &mut blocks);
        }
        Self { count, mean, ..Self::packed(btf, &blocks) }
    }

    fn packed(btf: &Btf, blocks: &[Block]) -> Self {
        let texels = btf.layout().texels;
        let most = blocks
            .iter()
            .flat_map(|block| block.tints)
            .fold(1e-3, |most: f32, tint| most.max(tint.max_element()));
        let mut words: Vec<u32> = blocks
            .iter()
            .map(|Block { texel: [x, y], .. }| {
                btf.words()[(texels.offset + y * btf.layout().columns + x) as usize]
            })
            .collect();
        words.extend(blocks.iter().flat_map(|block| block.tints).map(|tint| {
            let [red, green, blue] = (tint / most).to_array().map(f32::sqrt);
            let code = |root: f32, last: f32| (root * last).round() as u32;
            code(red, 2047.0) | code(green, 2047.0) << 11 | code(blue, 1023.0) << 22
        }));
        Self { words, texels: blocks.len() as u32, most, ..Self::default() }
    }
}

fn slice_angles(view: (f64, f64), light: (f64, f64)) -> SliceAngles {
    let angles = Angles::from_degrees(light.0, light.1, view.0, view.1);
    SliceAngles::new(angles.theta_i, angles.phi_i - angles.phi_v, false)
}

/// Albedo seen from 30 degrees, mean over a grid of texels.
fn mean_albedo(btf: &Btf) -> Vec3 {
    const DIRECTIONS: u32 = 16;
    const GRID: u32 = 16;
    let [columns, rows] = btf.size();
    let view = Angles::from_degrees(0.0, 0.0, 30.0, 45.0);
    let mut sum = Vec3::ZERO;
    for at in 0..GRID * GRID {
        let x = (at % GRID) * columns / GRID;
        let y = (at / GRID) * rows / GRID;
        let slices = btf.view_slices(x as i32, y as i32, view.theta_v, view.phi_v);
        for direction in 0..DIRECTIONS {
            let height = (direction as f32 + 0.5) / DIRECTIONS as f32;
            let turn = direction as f32 * 2.399_963_2;
            let light = SliceAngles::new(height.acos(), turn - view.phi_v, false);
            let value = btf.evaluate_slices(&slices, light, Rules::SHADING);
            sum += btf.colour_space().to_linear(value);
        }
    }
    sum * (2.0 / DIRECTIONS as f32 / (GRID * GRID) as f32)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use farlight_btf_codec::synthetic::lambert;

    use super::*;

    /// The tint of a texel of the coarser pictures, as the shader decodes it.
    fn tint(coarse: &CoarseLevels, texel: u32, cosine_of_view: f32) -> Vec3 {
        let [near, far] = [0, 1].map(|end| {
            let word = coarse.words[(coarse.texels + 2 * texel + end) as usize];
            let root = Vec3::new(
                (word & 2047) as f32 / 2047.0,
                (word >> 11 & 2047) as f32 / 2047.0,
                (word >> 22) as f32 / 1023.0,
            );
            coarse.most * root * root
        });
        near.lerp(far, grazing(cosine_of_view))
    }

    #[test]
    fn a_uniform_material_is_its_own_coarse_picture() {
        let btf = lambert([0.5, 0.4, 0.3], [6, 4]).unwrap();
        let coarse = CoarseLevels::of(&btf);
        // 3 x 2; a texel and two tints each.
        assert_eq!((coarse.count, coarse.texels, coarse.words.len()), (1, 6, 18));
        let texel = btf.words()[btf.layout().texels.offset as usize];
        for at in 0..6 {
            assert_eq!(coarse.words[at as usize], texel);
            for cosine in [1.0, 0.5, 0.1] {
                let off = (tint(&coarse, at, cosine) - 1.0).abs().max_element();
                assert!(off < 3e-3, "{off}");
            }
        }
        assert!(
            (coarse.mean - Vec3::new(0.5, 0.4, 0.3)).abs().max_element() < 5e-3,
            "{}",
            coarse.mean
        );
    }

    /// Means over the picture at a level, for one view and light.
    fn mean(
        btf: &Btf,
        coarse: &CoarseLevels,
        level: u32,
        view: (f64, f64),
        light: (f64, f64),
    ) -> Vec3 {
        let layout = btf.layout();
        let angles = Angles::from_degrees(0.0, 0.0, view.0, view.1);
        let lit = slice_angles(view, light);
        let value = |x: u32, y: u32| {
            let slices = btf.view_slices(x as i32, y as i32, angles.theta_v, angles.phi_v);
            btf.colour_space().to_linear(btf.evaluate_slices(&slices, lit, Rules::SHADING))
        };
        let own = &btf.words()[layout.texels.offset as usize..][..4096];
        let first: u32 = (1..level).map(|level| (64 >> level) * (64 >> level)).sum();
        let count = (64 >> level) * (64 >> level);
        let mut sum = Vec3::ZERO;
        for at in 0..count {
            sum += if level == 0 {
                value(at % 64, at / 64)
            } else {
                let word = coarse.words[(first + at) as usize];
                let texel = own.iter().position(|own| *own == word).unwrap() as u32;
                tint(coarse, first + at, angles.theta_v.cos()) * value(texel % 64, texel / 64)
            };
        }
        sum / count as f32
    }

    /// Views and lights between those that texels are chosen by.
    #[test]
    fn the_mean_over_the_picture_stays_from_level_to_level() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/materials/cloth.fbtf");
        let btf = Btf::open(&file).unwrap();
        assert_eq!(btf.size(), [64, 64]);
        let start = std::time::Instant::now();
        let coarse = CoarseLevels::of(&btf);
        println!("{:.0?}, greatest tint {}", start.elapsed(), coarse.most);
        for level in 1..=coarse.count {
            let (mut worst, mut sum, mut count) = (0.0_f32, 0.0, 0);
            for view in [
                (0.0, 0.0),
                (30.0, 75.0),
                (55.0, 170.0),
                (60.0, 320.0),
                (75.0, 250.0),
                (80.0, 20.0),
            ] {
                for light in [(10.0, 100.0), (30.0, 0.0), (50.0, 200.0), (60.0, 300.0)] {
                    let fine = mean(&btf, &coarse, 0, view, light);
                    let found = mean(&btf, &coarse, level, view, light);
                    let off = ((found - fine) / fine.max(Vec3::splat(0.01))).abs();
                    worst = worst.max(off.max_element());
                    sum += off.element_sum() / 3.0;
                    count += 1;
                }
            }
            println!(
                "level {level}: {:.1} % on average, {:.1} % at most",
                100.0 * sum / count as f32,
                100.0 * worst
            );
            // What is left of a level of 16 or 64 texels cannot fit each view and light.
            assert!(sum / count as f32 <= 0.05 && worst <= 0.2, "level {level}");
        }
    }
}

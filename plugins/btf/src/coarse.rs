//! Coarser pictures of a material, for where it is seen from afar.
//!
//! A texel of the picture at half size has to look like the mean of four texels from every side. A
//! mean of functions of view and light is no row of the code-books, but one of the four functions,
//! made brighter or darker, comes close: the one whose values for some views and lights differ the
//! least from the mean in linear light. So a coarser picture is another table of texels over the
//! same code-books, and all of them take a third of the first one.

use bevy::math::Vec3;
use farlight_btf_codec::{Angles, Btf, Layout, Rules, SliceAngles, linear};

/// Tables of texels at half, quarter, .. size, down to one texel.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct CoarseLevels {
    /// Packed as the material's own texels, level after level.
    pub(crate) words: Vec<u32>,
    /// How many levels.
    pub(crate) count: u32,
    /// Factor of code 0, ...
    pub(crate) min: f32,
    /// ... and the step of the codes.
    pub(crate) step: f32,
    /// Mean of linear values under light from all round: the albedo as a colour.
    pub(crate) mean: Vec3,
}

/// Views (elevation, azimuth in degrees) and lights for which texels are compared.
const VIEWS: [(f64, f64); 3] = [(0.0, 0.0), (40.0, 75.0), (60.0, 250.0)];
const LIGHTS: [(f64, f64); 4] = [(15.0, 30.0), (40.0, 130.0), (40.0, 260.0), (65.0, 10.0)];
const PROBES: usize = VIEWS.len() * LIGHTS.len();

/// Pictures of more texels have no coarser ones, to bound memory and time.
const MOST_TEXELS: u32 = 1 << 22;

type Probes = [Vec3; PROBES];

/// The texel that stands for a block, and the block's mean.
#[derive(Clone, Copy)]
struct Block {
    texel: [i32; 2],
    /// On the values of the texel.
    factor: f32,
    mean: Probes,
}

impl CoarseLevels {
    pub(crate) fn of(btf: &Btf) -> Self {
        let layout = btf.layout();
        let mean = mean_albedo(btf);
        if u64::from(layout.columns) * u64::from(layout.rows) > u64::from(MOST_TEXELS) {
            return Self { mean, ..Self::default() };
        }
        let lights = VIEWS.map(|view| LIGHTS.map(|light| slice_angles(view, light)));
        let values = |texel: [i32; 2]| probe(btf, texel, &lights);
        let mut size = [layout.columns, layout.rows];
        let mut levels: Vec<Vec<Block>> = Vec::new();
        while size != [1, 1] {
            let half = size.map(|edge| (edge / 2).max(1));
            let finer = levels.last();
            let mut blocks = Vec::with_capacity((half[0] * half[1]) as usize);
            for y in 0..half[1] {
                for x in 0..half[0] {
                    let parts = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]| {
                        let at =
                            [(2 * x + right).min(size[0] - 1), (2 * y + down).min(size[1] - 1)];
                        match finer {
                            Some(blocks) => blocks[(at[1] * size[0] + at[0]) as usize],
                            None => {
                                let texel = at.map(|edge| edge as i32);
                                let mean = values(texel).map(|value| to_linear(btf, value));
                                Block { texel, factor: 1.0, mean }
                            }
                        }
                    });
                    blocks.push(joined(btf, &parts, &values));
                }
            }
            levels.push(blocks);
            size = half;
        }
        let mut coarse = Self { count: levels.len() as u32, mean, ..Self::default() };
        coarse.pack(btf, &levels.concat());
        coarse
    }

    fn pack(&mut self, btf: &Btf, blocks: &[Block]) {
        let texels = btf.layout().texels;
        let entries: Vec<(u32, f32)> = blocks
            .iter()
            .map(|block| {
                let [x, y] = block.texel.map(|edge| edge as u32);
                let at = texels.offset + y * btf.layout().columns + x;
                let word = btf.words()[at as usize];
                let index = word & ((1 << texels.index_bits) - 1);
                let code = word >> texels.index_bits;
                (index, block.factor * (texels.min + code as f32 * texels.step))
            })
            .collect();
        let least = entries.iter().map(|(_, factor)| *factor).fold(f32::INFINITY, f32::min);
        let most = entries.iter().map(|(_, factor)| *factor).fold(0.0, f32::max);
        if entries.is_empty() {
            return;
        }
        let last = (1_u32 << (32 - texels.index_bits).min(16)) - 1;
        self.min = least;
        self.step = (most - least) / last as f32;
        self.words = entries
            .iter()
            .map(|(index, factor)| {
                let code =
                    if self.step > 0.0 { ((factor - least) / self.step).round() } else { 0.0 };
                index | (code as u32).min(last) << texels.index_bits
            })
            .collect();
    }
}

/// One of four parts stands for all.
fn joined(btf: &Btf, parts: &[Block; 4], values: &impl Fn([i32; 2]) -> Probes) -> Block {
    let mean: Probes =
        std::array::from_fn(|probe| parts.iter().map(|part| part.mean[probe]).sum::<Vec3>() / 4.0);
    let goal: f32 = mean.iter().map(|value| value.element_sum()).sum();
    let candidate = |part: &Block| {
        let encoded = values(part.texel);
        let scaled = |factor: f32| encoded.map(|value| to_linear(btf, factor * value));
        let sum =
            |factor: f32| -> f32 { scaled(factor).iter().map(|value| value.element_sum()).sum() };
        // The brightness grows with the factor.
        let (mut low, mut high) = (0.25_f32, 4.0_f32);
        for _ in 0..12 {
            let middle = (low * high).sqrt();
            if sum(middle) < goal { low = middle } else { high = middle }
        }
        let factor = (low * high).sqrt();
        let difference: f32 = scaled(factor)
            .iter()
            .zip(&mean)
            .map(|(value, mean)| value.distance_squared(*mean))
            .sum();
        (difference, Block { texel: part.texel, factor, mean })
    };
    let mut best = candidate(&parts[0]);
    for part in &parts[1..] {
        let other = candidate(part);
        if other.0 < best.0 {
            best = other;
        }
    }
    best.1
}

fn slice_angles(view: (f64, f64), light: (f64, f64)) -> SliceAngles {
    let angles = Angles::from_degrees(light.0, light.1, view.0, view.1);
    SliceAngles::new(angles.theta_i, angles.phi_i - angles.phi_v, false)
}

/// Values of a texel for all views and lights.
fn probe(btf: &Btf, texel: [i32; 2], lights: &[[SliceAngles; 4]; 3]) -> Probes {
    let mut values = [Vec3::ZERO; PROBES];
    for (view, lights) in lights.iter().enumerate() {
        let angles = Angles::from_degrees(0.0, 0.0, VIEWS[view].0, VIEWS[view].1);
        let slices = btf.view_slices(texel[0], texel[1], angles.theta_v, angles.phi_v);
        for (light, angles) in lights.iter().enumerate() {
            values[view * LIGHTS.len() + light] =
                btf.evaluate_slices(&slices, *angles, Rules::SHADING);
        }
    }
    values
}

/// From a value of [`Rules::SHADING`] to a factor of light.
fn to_linear(btf: &Btf, value: Vec3) -> Vec3 {
    if btf.layout().flags & Layout::LOG_LUV != 0 { value } else { (value / 255.0).map(linear) }
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
            sum += to_linear(btf, value);
        }
    }
    sum * (2.0 / DIRECTIONS as f32 / (GRID * GRID) as f32)
}

#[cfg(test)]
mod tests {
    use farlight_btf_codec::synthetic::lambert;

    use super::*;

    #[test]
    fn a_uniform_material_is_its_own_coarse_picture() {
        let btf = lambert([0.5, 0.4, 0.3], [6, 4]).unwrap();
        let coarse = CoarseLevels::of(&btf);
        // 3 x 2, 1 x 1.
        assert_eq!((coarse.count, coarse.words.len()), (2, 7));
        let texel = btf.words()[btf.layout().texels.offset as usize];
        let bits = btf.layout().texels.index_bits;
        for word in coarse.words {
            assert_eq!(word & ((1 << bits) - 1), texel & ((1 << bits) - 1));
            let factor = coarse.min + (word >> bits) as f32 * coarse.step;
            assert!((factor - 1.0).abs() < 2e-3, "{factor}");
        }
        assert!(
            (coarse.mean - Vec3::new(0.5, 0.4, 0.3)).abs().max_element() < 5e-3,
            "{}",
            coarse.mean
        );
    }
}

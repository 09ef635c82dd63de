//! Materials of random numbers, with sample counts that measured ones do not have.

use farlight_btf_codec::{
    Angles, Btf, ColourSpace, Info, Query, References, Samples, Scaled, Tables,
};

/// SplitMix64 (Steele, Lea, Flood 2014).
pub(crate) struct Random(pub u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, count: usize) -> u32 {
        (self.next() % count as u64) as u32
    }

    pub(crate) fn between(&mut self, from: f32, to: f32) -> f32 {
        from + (to - from) * (self.next() >> 40) as f32 / (1 << 24) as f32
    }

    fn scaled(&mut self, rows: usize, columns: usize, below: usize, scale: [f32; 2]) -> Scaled {
        let count = rows * columns;
        Scaled {
            columns,
            index: (0..count).map(|_| self.below(below)).collect(),
            scale: (0..count).map(|_| self.between(scale[0], scale[1])).collect(),
            range: None,
        }
    }

    fn references(&mut self, rows: usize, columns: usize, below: usize) -> References {
        References { columns, index: (0..rows * columns).map(|_| self.below(below)).collect() }
    }

    fn samples(&mut self, rows: usize, columns: usize, range: [f32; 2]) -> Samples {
        let value = (0..rows * columns).map(|_| self.between(range[0], range[1])).collect();
        Samples { columns, value, range: None }
    }
}

/// Samples of a material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counts {
    pub phi: usize,
    pub theta: usize,
    pub alpha: usize,
    pub beta: usize,
}

/// 13 x 7 texels of random numbers; luminances and chromas are those that the colour space has.
pub(crate) fn made(counts: Counts, colour_space: ColourSpace, sine: bool, seed: u64) -> Btf {
    let mut random = Random(seed);
    let random = &mut random;
    let (chromas, luminance) = match colour_space {
        ColourSpace::YCbCr => ([60.0, 200.0], [100.0, 1500.0]),
        // All three pieces of the luminance curve.
        ColourSpace::LogLuv { .. } => ([60.0, 200.0], [10.0, 10000.0]),
    };
    let tables = Tables {
        colour_space,
        beta_uniform_in_sine: sine,
        texels: random.scaled(7, 13, 50, [0.9, 1.1]),
        azimuths: random.scaled(50, counts.phi, 70, [0.9, 1.1]),
        elevations: random.scaled(70, counts.theta, 90, [0.4, 1.7]),
        slices: {
            // not both halves from as many rows
            let mut slices = random.references(90, 2, 60);
            slices.index.iter_mut().skip(1).step_by(2).for_each(|chroma| *chroma %= 40);
            slices
        },
        luminances: random.scaled(60, counts.alpha, 80, luminance),
        shapes: random.samples(80, counts.beta, [0.01, 0.25]),
        chromas: random.references(40, counts.alpha, 30),
        colour_rows: random.references(30, counts.beta, 20),
        colours: random.samples(20, 2, chromas),
    };
    Btf::new(Info::default(), 13, &tables).unwrap()
}

/// Texels in and around the picture, directions over the hemispheres and a little below.
pub(crate) fn queries(count: usize, seed: u64) -> Vec<Query> {
    let mut random = Random(seed);
    let horizon = std::f32::consts::FRAC_PI_2;
    (0..count)
        .map(|_| Query {
            x: random.below(100) as i32 - 50,
            y: random.below(100) as i32 - 50,
            angles: Angles {
                theta_i: random.between(0.0, 1.02 * horizon),
                phi_i: random.between(-10.0, 10.0),
                theta_v: random.between(0.0, 1.02 * horizon),
                phi_v: random.between(-10.0, 10.0),
            },
        })
        .collect()
}

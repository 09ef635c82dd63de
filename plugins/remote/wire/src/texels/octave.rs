//! Logarithms of half floats, the same on every machine.
//!
//! The bits of a half float are nearly its logarithm, but linear within an octave: light that gets a
//! fifth brighter adds between 205 and 341 to them. Their true logarithms all grow alike.

/// `1024 log2(1 + m / 1024)`, rounded.
static LOG: [u16; 1024] = {
    let mut table = [0; 1024];
    let mut m = 0;
    while m < 1024 {
        table[m] = log(m as u64);
        m += 1;
    }
    table
};

/// The `m` whose logarithm comes nearest.
static POWER: [u16; 1024] = {
    let mut table = [0; 1024];
    let (mut f, mut m) = (0, 0);
    while f < 1024 {
        while m < 1023 && LOG[m] < f as u16 {
            m += 1;
        }
        // The one before may be nearer.
        let nearer = m > 0 && f as u16 - LOG[m - 1] < LOG[m].saturating_sub(f as u16);
        table[f] = if nearer { m - 1 } else { m } as u16;
        f += 1;
    }
    table
};

/// Binary digits of a logarithm by squaring (Knuth, The Art of Computer Programming 1, section 1.2.2).
const fn log(m: u64) -> u16 {
    let one = 1_u64 << 31;
    let mut x = one + (m << 21);
    let mut digits = 0;
    let mut i = 0;
    while i < 12 {
        x = (x * x) >> 31;
        digits <<= 1;
        if x >= 2 * one {
            x >>= 1;
            digits += 1;
        }
        i += 1;
    }
    let rounded = (digits + 2) >> 2;
    if rounded > 1023 { 1023 } else { rounded }
}

/// 1024 times the binary logarithm of a half that is not negative, by its bits, up to a constant.
pub(super) fn log_of(bits: u16) -> i32 {
    i32::from(bits & 0xfc00) + i32::from(LOG[usize::from(bits & 0x3ff)])
}

/// The bits of the finite half whose logarithm is nearest.
pub(super) fn half_of(log: i32) -> u16 {
    let log = log.clamp(0, i32::from(super::step::LARGEST)) as u16;
    (log & 0xfc00) + POWER[usize::from(log & 0x3ff)]
}

#[cfg(test)]
mod tests {
    use half::f16;

    use super::*;

    #[test]
    fn logarithms_are_right_and_come_back() {
        for bits in 0x0400..=super::super::step::LARGEST {
            let exact = 1024.0 * (f16::from_bits(bits).to_f32().log2() + 15.0);
            assert!((log_of(bits) as f32 - exact).abs() <= 0.63, "{bits}");
            assert!(half_of(log_of(bits)).abs_diff(bits) <= 1, "{bits}");
        }
        assert_eq!(half_of(-5), 0);
        assert!(half_of(i32::MAX) <= super::super::step::LARGEST);
    }

    #[test]
    fn light_that_grows_grows_alike() {
        let grown = |bits: u16| f16::from_f32(f16::from_bits(bits).to_f32() * 1.2).to_bits();
        for bits in (0x3000..0x5000).step_by(7) {
            let difference = log_of(grown(bits)) - log_of(bits);
            assert!((268..=271).contains(&difference), "{bits}: {difference}");
        }
    }
}

//! How exactly light is sent.
//!
//! The bits of a half float that is not negative, read as an integer, are nearly its logarithm:
//! 1024 to the octave. Texels are sent as multiples of an odd *step* of that integer, so the error is
//! at most `(step - 1) / 2` units in the last place, each of which is 2^-11 to 2^-10 of the value
//! (below 6.1e-5 halves get coarser, and so do we).

use farlight_gi_solver::session::Quality;

/// Bits of the largest finite half.
pub(super) const LARGEST: u16 = 0x7bff;
/// Relative error that is always fine: 2^-10, 0.098 %. Halves are rounded by up to half of it
/// before they get here, and changes below 0.3 % are not published.
const FINE: f32 = 1.0 / 1024.0;
/// And this part of the error that the solver estimates for its own light. Errors that don't depend
/// on each other add as squares, and rounding is off by 1/√3 of its largest error on average, so
/// 1/5 makes the total less than 1 % larger.
const SHARE: f32 = 1.0 / 5.0;
/// The largest step; an error of 0.4 % at most.
const COARSEST: u16 = 9;

/// A step between the levels of texels: 3, 5, 7 or 9.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Step(u16);

impl Step {
    /// The step for light of this quality. Both sides know the quality, so the step is not sent.
    pub(super) fn of(quality: &Quality) -> Self {
        // A NaN becomes 0 here.
        let units = (quality.relative_error * SHARE / FINE) as u16;
        Self(2 * units.clamp(1, COARSEST / 2) + 1)
    }

    /// The largest level.
    pub(super) fn top(self) -> i32 {
        i32::from(LARGEST / self.0)
    }

    /// The level of a half's bits. Negative values are sent as 0, values that aren't finite as the
    /// largest.
    pub(super) fn level(self, bits: u16) -> i32 {
        if bits >= 0x8000 {
            return 0;
        }
        i32::from((bits.min(LARGEST) + self.0 / 2) / self.0).min(self.top())
    }

    /// The bits of a level, which is clamped to what there is.
    pub(super) fn bits(self, level: i32) -> u16 {
        level.clamp(0, self.top()) as u16 * self.0
    }

    /// The largest error, in units in the last place: 1 to 4.
    pub(super) fn units(self) -> u16 {
        self.0 / 2
    }

    /// Relative error of values above 6.1e-5.
    #[cfg(test)]
    pub(super) fn error(self) -> f32 {
        f32::from(self.units()) * FINE
    }
}

#[cfg(test)]
mod tests {
    use half::f16;

    use super::*;

    fn step(relative_error: f32) -> Step {
        Step::of(&Quality { relative_error, ..Quality::default() })
    }

    #[test]
    fn exactness_follows_the_quality() {
        for fine in [0.0, 0.001, 0.0097, -1.0, f32::NAN] {
            assert_eq!(step(fine), Step(3), "{fine}");
        }
        assert_eq!(step(0.012), Step(5));
        assert_eq!(step(0.016), Step(7));
        for coarse in [0.02, 1.0, f32::MAX, f32::INFINITY] {
            assert_eq!(step(coarse), Step(9), "{coarse}");
        }
    }

    #[test]
    fn errors_are_bounded() {
        for step in [Step(3), Step(5), Step(7), Step(9)] {
            let mut worst = 0.0_f32;
            for bits in 0..=LARGEST {
                let level = step.level(bits);
                assert!((0..=step.top()).contains(&level));
                let back = step.bits(level);
                assert_eq!(step.level(back), level, "stays when it is sent again");
                assert!(back <= LARGEST);
                let (value, back) = (f16::from_bits(bits).to_f32(), f16::from_bits(back).to_f32());
                if value >= 6.2e-5 {
                    worst = worst.max((back / value - 1.0).abs());
                } else {
                    assert!((back - value).abs() <= step.error() * 6.2e-5);
                }
            }
            assert!(worst <= step.error() * 1.0001, "{step:?}: {worst}");
            assert!(worst > step.error() * 0.9, "{step:?}: {worst}");
        }
        assert!(Step(3).error() < 0.001);
    }

    #[test]
    fn what_is_no_radiance_is_replaced() {
        assert_eq!(Step(3).bits(Step(3).level(0x8001)), 0, "a negative one");
        assert_eq!(Step(3).bits(Step(3).level(0xffff)), 0, "NaN with a sign");
        assert!(Step(3).bits(Step(3).level(0x7c00)) >= LARGEST - 2, "infinity");
        assert!(f16::from_bits(Step(9).bits(i32::MAX)).is_finite());
        assert_eq!(Step(9).bits(-5), 0);
    }
}

//! Vectors of the processor: all unsafe code of the evaluator.
//!
//! Values of these types exist only where a token was made, and a token is made only after a look at
//! the processor: that is why their operations are safe. Reads from memory cut every index to the
//! length of the slice first, which costs one instruction beside the dozens of a gather: no damaged
//! material and no mistake in the kernel can read elsewhere.

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Mul, Shl, Shr, Sub};

/// A vector of floats.
pub(super) trait Float:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    type Int: Int;
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask>;
    /// `self * a + b`, rounded once.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// `b - self * a`, rounded once.
    fn neg_mul_add(self, a: Self, b: Self) -> Self;
    fn div(self, other: Self) -> Self;
    /// The second where one is not a number.
    fn min(self, other: Self) -> Self;
    /// The second where one is not a number.
    fn max(self, other: Self) -> Self;
    fn sqrt(self) -> Self;
    fn floor(self) -> Self;
    /// To the nearest whole number.
    fn round(self) -> Self;
    /// Towards 0.
    fn to_int(self) -> Self::Int;
    fn bits(self) -> Self::Int;
    fn less(self, other: Self) -> Self::Mask;
    fn at_most(self, other: Self) -> Self::Mask;
    /// `self` where the mask is set, else `other`.
    fn select(self, mask: Self::Mask, other: Self) -> Self;
}

/// A vector of 32-bit integers; arithmetic wraps.
pub(super) trait Int:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitAnd<Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    type Float: Float<Int = Self>;
    /// Of signed numbers.
    fn to_float(self) -> Self::Float;
    fn as_float(self) -> Self::Float;
    /// Of unsigned numbers.
    fn min(self, other: Self) -> Self;
    fn equals(self, other: Self) -> <Self::Float as Float>::Mask;
    fn xor(self, other: Self) -> Self;
    /// `self` where the mask is set, else `other`.
    fn select(self, mask: <Self::Float as Float>::Mask, other: Self) -> Self;
}

/// A token: the processor has these vectors.
pub(super) trait Lanes: Copy {
    type Float: Float<Int = Self::Int>;
    type Int: Int<Float = Self::Float>;
    /// Lanes in a vector, at most [`MOST`].
    const COUNT: usize;
    fn float(self, value: f32) -> Self::Float;
    fn int(self, value: u32) -> Self::Int;
    fn load(self, values: &[f32; MOST]) -> Self::Float;
    fn load_int(self, values: &[u32; MOST]) -> Self::Int;
    fn store(self, value: Self::Float, to: &mut [f32; MOST]);
    fn word(self, words: Words<'_>, at: Self::Int) -> Self::Int;
    /// Two neighbouring words each.
    fn pair(self, words: Words<'_>, at: Self::Int) -> [Self::Int; 2];
    /// As [`Lanes::pair`], but `at` counts half words.
    fn pair_at_half(self, words: Words<'_>, at: Self::Int) -> [Self::Int; 2];
}

/// The most lanes of a vector.
pub(super) const MOST: usize = 16;

/// Words to gather from.
#[derive(Clone, Copy)]
pub(super) struct Words<'a>(&'a [u32]);

impl<'a> Words<'a> {
    /// Fails for fewer than two words, or so many that a signed index can't reach them all.
    pub(super) fn new(words: &'a [u32]) -> Option<Self> {
        (2..1 << 29).contains(&words.len()).then_some(Self(words))
    }

    fn last(self) -> u32 {
        self.0.len() as u32 - 1
    }
}

macro_rules! operators {
    ($name:ident: $($operator:ident $function:ident $intrinsic:ident),*) => {
        $(impl $operator for $name {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                // SAFETY: a value exists only where its processor does.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        })*
    };
}

macro_rules! shifts {
    ($name:ident, $left:ident, $right:ident) => {
        impl Shl<u32> for $name {
            type Output = Self;
            #[inline(always)]
            fn shl(self, bits: u32) -> Self {
                // SAFETY: a value exists only where its processor does.
                Self(unsafe { $left(self.0, _mm_cvtsi32_si128(bits as i32)) })
            }
        }
        impl Shr<u32> for $name {
            type Output = Self;
            #[inline(always)]
            fn shr(self, bits: u32) -> Self {
                // SAFETY: a value exists only where its processor does.
                Self(unsafe { $right(self.0, _mm_cvtsi32_si128(bits as i32)) })
            }
        }
    };
}

/// Eight lanes: AVX2 and FMA.
#[derive(Clone, Copy)]
pub(super) struct Avx2(());

impl Avx2 {
    pub(super) fn new() -> Option<Self> {
        (is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")).then_some(Self(()))
    }

    /// Calls `work` so that it is compiled for this processor.
    #[inline]
    pub(super) fn run(self, work: impl Work) {
        #[target_feature(enable = "avx2,fma")]
        fn inside(lanes: Avx2, work: impl Work) {
            work.run(lanes);
        }
        // SAFETY: the token says that the processor has both.
        unsafe { inside(self, work) }
    }
}

/// What is to be compiled for several processors; `run` must be inlined.
pub(super) trait Work {
    fn run<L: Lanes>(self, lanes: L);
}

#[derive(Clone, Copy)]
pub(super) struct F8(__m256);
#[derive(Clone, Copy)]
pub(super) struct I8(__m256i);
#[derive(Clone, Copy)]
pub(super) struct M8(__m256);

operators!(F8: Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps);
operators!(I8: Add add _mm256_add_epi32, Sub sub _mm256_sub_epi32, Mul mul _mm256_mullo_epi32,
    BitAnd bitand _mm256_and_si256);
operators!(M8: BitAnd bitand _mm256_and_ps, BitOr bitor _mm256_or_ps);
shifts!(I8, _mm256_sll_epi32, _mm256_srl_epi32);

macro_rules! functions {
    ($($(#[$doc:meta])* fn $name:ident($($arg:ident: $kind:ty),*) -> $out:ty = $body:expr;)*) => {
        $(#[inline(always)]
        fn $name($($arg: $kind),*) -> $out {
            // SAFETY: the values exist only where their processor does; nothing reads memory.
            unsafe { $body }
        })*
    };
}

impl Float for F8 {
    type Int = I8;
    type Mask = M8;
    functions! {
        fn mul_add(self: Self, a: Self, b: Self) -> Self = Self(_mm256_fmadd_ps(self.0, a.0, b.0));
        fn neg_mul_add(self: Self, a: Self, b: Self) -> Self = Self(_mm256_fnmadd_ps(self.0, a.0, b.0));
        fn div(self: Self, other: Self) -> Self = Self(_mm256_div_ps(self.0, other.0));
        fn min(self: Self, other: Self) -> Self = Self(_mm256_min_ps(self.0, other.0));
        fn max(self: Self, other: Self) -> Self = Self(_mm256_max_ps(self.0, other.0));
        fn sqrt(self: Self) -> Self = Self(_mm256_sqrt_ps(self.0));
        fn floor(self: Self) -> Self = Self(_mm256_floor_ps(self.0));
        fn round(self: Self) -> Self = Self(_mm256_round_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0));
        fn to_int(self: Self) -> I8 = I8(_mm256_cvttps_epi32(self.0));
        fn bits(self: Self) -> I8 = I8(_mm256_castps_si256(self.0));
        fn less(self: Self, other: Self) -> M8 = M8(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0));
        fn at_most(self: Self, other: Self) -> M8 = M8(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0));
        fn select(self: Self, mask: M8, other: Self) -> Self = Self(_mm256_blendv_ps(other.0, self.0, mask.0));
    }
}

impl Int for I8 {
    type Float = F8;
    functions! {
        fn to_float(self: Self) -> F8 = F8(_mm256_cvtepi32_ps(self.0));
        fn as_float(self: Self) -> F8 = F8(_mm256_castsi256_ps(self.0));
        fn min(self: Self, other: Self) -> Self = Self(_mm256_min_epu32(self.0, other.0));
        fn equals(self: Self, other: Self) -> M8 = M8(_mm256_castsi256_ps(_mm256_cmpeq_epi32(self.0, other.0)));
        fn xor(self: Self, other: Self) -> Self = Self(_mm256_xor_si256(self.0, other.0));
        fn select(self: Self, mask: M8, other: Self) -> Self = Self(_mm256_blendv_epi8(other.0, self.0, _mm256_castps_si256(mask.0)));
    }
}

impl Avx2 {
    /// 64 bits each from indices in units of `SCALE` bytes.
    ///
    /// # Safety
    /// All eight bytes at every index lie in `words`.
    #[inline(always)]
    unsafe fn gather_pairs<const SCALE: i32>(words: Words<'_>, at: I8) -> [I8; 2] {
        // SAFETY: the caller's promise; the processor's by `at`.
        unsafe {
            // The shuffle below works on halves of the vectors: lanes 0 1 4 5 first, then 2 3 6 7.
            let order = _mm256_permute4x64_epi64::<0b11_01_10_00>(at.0);
            let base = words.0.as_ptr().cast();
            let a = _mm256_i32gather_epi64::<SCALE>(base, _mm256_castsi256_si128(order));
            let b = _mm256_i32gather_epi64::<SCALE>(base, _mm256_extracti128_si256::<1>(order));
            let (a, b) = (_mm256_castsi256_ps(a), _mm256_castsi256_ps(b));
            let low = _mm256_shuffle_ps::<0b10_00_10_00>(a, b);
            let high = _mm256_shuffle_ps::<0b11_01_11_01>(a, b);
            [I8(_mm256_castps_si256(low)), I8(_mm256_castps_si256(high))]
        }
    }
}

impl Lanes for Avx2 {
    type Float = F8;
    type Int = I8;
    const COUNT: usize = 8;

    functions! {
        fn float(self: Self, value: f32) -> F8 = F8(_mm256_set1_ps(value));
        fn int(self: Self, value: u32) -> I8 = I8(_mm256_set1_epi32(value as i32));
    }

    #[inline(always)]
    fn load(self, values: &[f32; MOST]) -> F8 {
        // SAFETY: eight lanes lie in sixteen numbers.
        F8(unsafe { _mm256_loadu_ps(values.as_ptr()) })
    }

    #[inline(always)]
    fn load_int(self, values: &[u32; MOST]) -> I8 {
        // SAFETY: eight lanes lie in sixteen numbers.
        I8(unsafe { _mm256_loadu_si256(values.as_ptr().cast()) })
    }

    #[inline(always)]
    fn store(self, value: F8, to: &mut [f32; MOST]) {
        // SAFETY: eight lanes lie in sixteen numbers.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), value.0) }
    }

    #[inline(always)]
    fn word(self, words: Words<'_>, at: I8) -> I8 {
        let at = at.min(self.int(words.last()));
        // SAFETY: no index is above the last word's.
        I8(unsafe { _mm256_i32gather_epi32::<4>(words.0.as_ptr().cast(), at.0) })
    }

    #[inline(always)]
    fn pair(self, words: Words<'_>, at: I8) -> [I8; 2] {
        let at = at.min(self.int(words.last() - 1));
        // SAFETY: no index is above that of the last but one word.
        unsafe { Self::gather_pairs::<4>(words, at) }
    }

    #[inline(always)]
    fn pair_at_half(self, words: Words<'_>, at: I8) -> [I8; 2] {
        let at = at.min(self.int(2 * (words.last() - 1)));
        // SAFETY: no index is above that of the last but one word.
        unsafe { Self::gather_pairs::<2>(words, at) }
    }
}

/// Sixteen lanes: AVX-512.
#[derive(Clone, Copy)]
pub(super) struct Avx512(());

impl Avx512 {
    pub(super) fn new() -> Option<Self> {
        (is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq"))
            .then_some(Self(()))
    }

    /// Calls `work` so that it is compiled for this processor.
    #[inline]
    pub(super) fn run(self, work: impl Work) {
        #[target_feature(enable = "avx512f,avx512dq")]
        fn inside(lanes: Avx512, work: impl Work) {
            work.run(lanes);
        }
        // SAFETY: the token says that the processor has both.
        unsafe { inside(self, work) }
    }
}

#[derive(Clone, Copy)]
pub(super) struct F16(__m512);
#[derive(Clone, Copy)]
pub(super) struct I16(__m512i);
#[derive(Clone, Copy)]
pub(super) struct M16(__mmask16);

operators!(F16: Add add _mm512_add_ps, Sub sub _mm512_sub_ps, Mul mul _mm512_mul_ps);
operators!(I16: Add add _mm512_add_epi32, Sub sub _mm512_sub_epi32, Mul mul _mm512_mullo_epi32,
    BitAnd bitand _mm512_and_si512);
shifts!(I16, _mm512_sll_epi32, _mm512_srl_epi32);

impl BitAnd for M16 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for M16 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Float for F16 {
    type Int = I16;
    type Mask = M16;
    functions! {
        fn mul_add(self: Self, a: Self, b: Self) -> Self = Self(_mm512_fmadd_ps(self.0, a.0, b.0));
        fn neg_mul_add(self: Self, a: Self, b: Self) -> Self = Self(_mm512_fnmadd_ps(self.0, a.0, b.0));
        fn div(self: Self, other: Self) -> Self = Self(_mm512_div_ps(self.0, other.0));
        fn min(self: Self, other: Self) -> Self = Self(_mm512_min_ps(self.0, other.0));
        fn max(self: Self, other: Self) -> Self = Self(_mm512_max_ps(self.0, other.0));
        fn sqrt(self: Self) -> Self = Self(_mm512_sqrt_ps(self.0));
        fn floor(self: Self) -> Self = Self(_mm512_roundscale_ps::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0));
        fn round(self: Self) -> Self = Self(_mm512_roundscale_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0));
        fn to_int(self: Self) -> I16 = I16(_mm512_cvttps_epi32(self.0));
        fn bits(self: Self) -> I16 = I16(_mm512_castps_si512(self.0));
        fn less(self: Self, other: Self) -> M16 = M16(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0));
        fn at_most(self: Self, other: Self) -> M16 = M16(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0));
        fn select(self: Self, mask: M16, other: Self) -> Self = Self(_mm512_mask_blend_ps(mask.0, other.0, self.0));
    }
}

impl Int for I16 {
    type Float = F16;
    functions! {
        fn to_float(self: Self) -> F16 = F16(_mm512_cvtepi32_ps(self.0));
        fn as_float(self: Self) -> F16 = F16(_mm512_castsi512_ps(self.0));
        fn min(self: Self, other: Self) -> Self = Self(_mm512_min_epu32(self.0, other.0));
        fn equals(self: Self, other: Self) -> M16 = M16(_mm512_cmpeq_epi32_mask(self.0, other.0));
        fn xor(self: Self, other: Self) -> Self = Self(_mm512_xor_si512(self.0, other.0));
        fn select(self: Self, mask: M16, other: Self) -> Self = Self(_mm512_mask_blend_epi32(mask.0, other.0, self.0));
    }
}

impl Avx512 {
    /// 64 bits each from indices in units of `SCALE` bytes.
    ///
    /// # Safety
    /// All eight bytes at every index lie in `words`.
    #[inline(always)]
    unsafe fn gather_pairs<const SCALE: i32>(words: Words<'_>, at: I16) -> [I16; 2] {
        // SAFETY: the caller's promise; the processor's by `at`.
        unsafe {
            let base = words.0.as_ptr().cast();
            let a = _mm512_i32gather_epi64::<SCALE>(_mm512_castsi512_si256(at.0), base);
            let b = _mm512_i32gather_epi64::<SCALE>(_mm512_extracti64x4_epi64::<1>(at.0), base);
            let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            let odd = _mm512_add_epi32(even, _mm512_set1_epi32(1));
            [I16(_mm512_permutex2var_epi32(a, even, b)), I16(_mm512_permutex2var_epi32(a, odd, b))]
        }
    }
}

impl Lanes for Avx512 {
    type Float = F16;
    type Int = I16;
    const COUNT: usize = 16;

    functions! {
        fn float(self: Self, value: f32) -> F16 = F16(_mm512_set1_ps(value));
        fn int(self: Self, value: u32) -> I16 = I16(_mm512_set1_epi32(value as i32));
    }

    #[inline(always)]
    fn load(self, values: &[f32; MOST]) -> F16 {
        // SAFETY: sixteen lanes from sixteen numbers.
        F16(unsafe { _mm512_loadu_ps(values.as_ptr()) })
    }

    #[inline(always)]
    fn load_int(self, values: &[u32; MOST]) -> I16 {
        // SAFETY: sixteen lanes from sixteen numbers.
        I16(unsafe { _mm512_loadu_si512(values.as_ptr().cast()) })
    }

    #[inline(always)]
    fn store(self, value: F16, to: &mut [f32; MOST]) {
        // SAFETY: sixteen lanes into sixteen numbers.
        unsafe { _mm512_storeu_ps(to.as_mut_ptr(), value.0) }
    }

    #[inline(always)]
    fn word(self, words: Words<'_>, at: I16) -> I16 {
        let at = at.min(self.int(words.last()));
        // SAFETY: no index is above the last word's.
        I16(unsafe { _mm512_i32gather_epi32::<4>(at.0, words.0.as_ptr().cast()) })
    }

    #[inline(always)]
    fn pair(self, words: Words<'_>, at: I16) -> [I16; 2] {
        let at = at.min(self.int(words.last() - 1));
        // SAFETY: no index is above that of the last but one word.
        unsafe { Self::gather_pairs::<4>(words, at) }
    }

    #[inline(always)]
    fn pair_at_half(self, words: Words<'_>, at: I16) -> [I16; 2] {
        let at = at.min(self.int(2 * (words.last() - 1)));
        // SAFETY: no index is above that of the last but one word.
        unsafe { Self::gather_pairs::<2>(words, at) }
    }
}

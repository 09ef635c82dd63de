//! A small deterministic mutational fuzzer: valid encodings, changed at random.
//!
//! Also a module of the crate's own unit tests, which reach what is not public.

use std::{
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    time::{Duration, Instant},
};

/// Seconds of a long run.
const SECONDS: &str = "FARLIGHT_FUZZ_SECONDS";
/// Another seed, a number.
const SEED: &str = "FARLIGHT_FUZZ_SEED";
/// Accepted inputs that are kept and changed further.
const KEPT: usize = 200;
/// Longest input.
const LONGEST: usize = 1 << 20;

/// Repeatable random numbers (SplitMix64, Steele et al. 2014).
#[derive(Clone)]
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`; 0 for none.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        if end == 0 { 0 } else { (self.next() % end as u64) as usize }
    }

    /// True once in `n` times.
    pub(crate) fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// A number that is often at the edge of something.
    fn interesting(&mut self) -> u64 {
        let edge = 1_u64.checked_shl(self.below(65) as u32).unwrap_or(0);
        match self.below(5) {
            0 => edge,
            1 => edge.wrapping_sub(1),
            2 => edge.wrapping_neg(),
            3 => self.next() % 300,
            _ => self.next(),
        }
    }
}

/// Changes an input in one to eight ways; `other` is spliced in sometimes.
pub(crate) fn mutate(random: &mut Random, bytes: &mut Vec<u8>, other: &[u8]) {
    for _ in 0..=random.below(8) {
        let at = random.below(bytes.len());
        let size = (1 + random.below(16)).min(bytes.len() - at);
        match random.below(11) {
            0 | 1 if size > 0 => bytes[at] ^= 1 << random.below(8),
            2 if size > 0 => bytes[at] = random.interesting() as u8,
            3 => {
                let more: Vec<u8> =
                    (0..1 + random.below(16)).map(|_| random.next() as u8).collect();
                bytes.splice(at..at, more);
            }
            4 => drop(bytes.drain(at..at + size)),
            5 => bytes.truncate(at),
            6 => {
                let again = bytes[at..at + size].to_vec();
                bytes.splice(at..at, again);
            }
            // Fixed and LEB128 numbers: lengths, counts, ids.
            7 => {
                let number = random.interesting().to_le_bytes();
                let width = [2, 4, 8][random.below(3)].min(bytes.len() - at);
                bytes[at..at + width].copy_from_slice(&number[..width]);
            }
            8 => {
                let mut number = random.interesting();
                let mut leb = Vec::new();
                while number >= 0x80 {
                    leb.push(number as u8 | 0x80);
                    number >>= 7;
                }
                leb.push(number as u8);
                let end = bytes.len().min(at + 1 + random.below(3));
                bytes.splice(at..end, leb);
            }
            9 if !other.is_empty() => {
                let from = random.below(other.len());
                let to = from + random.below(other.len() - from) + 1;
                let end = at + random.below(bytes.len() - at + 1);
                bytes.splice(at..end, other[from..to].iter().copied());
            }
            _ if size > 0 => {
                let value = random.next() as u8;
                bytes[at..at + size].fill(value);
            }
            _ => {}
        }
    }
    bytes.truncate(LONGEST);
}

/// Runs `target` on inputs made of `corpus`; it says whether it accepted the input. `brief` inputs,
/// or as long as the environment says. What makes it panic is shown.
pub(crate) fn fuzz(
    name: &str,
    brief: u64,
    mut corpus: Vec<Vec<u8>>,
    mut target: impl FnMut(&mut Random, &[u8]) -> bool,
) {
    let setting = |name: &str| std::env::var(name).ok().and_then(|v| v.parse::<u64>().ok());
    let seed = setting(SEED).unwrap_or(1);
    let time = setting(SECONDS).map(Duration::from_secs);
    let (mut random, start) = (Random(seed), Instant::now());
    let (mut inputs, mut accepted) = (0_u64, 0_u64);
    let seeds = corpus.len();
    let go_on = |inputs: u64| match time {
        // A brief run is bounded by time too, for slow machines.
        None => inputs < brief && start.elapsed() < Duration::from_secs(3),
        Some(time) => start.elapsed() < time,
    };
    while go_on(inputs) {
        let input = if (inputs as usize) < seeds {
            corpus[inputs as usize].clone()
        } else if random.once_in(40) {
            (0..random.below(200)).map(|_| random.next() as u8).collect()
        } else {
            let mut input = corpus[random.below(corpus.len())].clone();
            let other = random.below(corpus.len());
            mutate(&mut random, &mut input, &corpus[other]);
            input
        };
        inputs += 1;
        match catch_unwind(AssertUnwindSafe(|| target(&mut random, &input))) {
            Ok(true) => {
                accepted += 1;
                if corpus.len() < seeds + KEPT {
                    corpus.push(input);
                } else {
                    // The first ones stay: they are valid and varied.
                    let place = seeds + random.below(KEPT);
                    corpus[place] = input;
                }
            }
            Ok(false) => {}
            Err(panic) => {
                let hex: String = input.iter().take(4096).map(|b| format!("{b:02x}")).collect();
                eprintln!(
                    "fuzz_{name}, seed {seed}, input {inputs} of {} bytes: {hex}",
                    input.len()
                );
                resume_unwind(panic);
            }
        }
    }
    println!("fuzz_{name}: {inputs} inputs, {accepted} accepted, {:.1?}", start.elapsed());
    assert!(inputs > seeds as u64, "not even the valid inputs were reached in time");
    assert!(accepted > 0, "nothing was accepted: the corpus is stale");
}

#[test]
#[should_panic(expected = "found it")]
fn what_fails_is_found() {
    let corpus = vec![b"some valid input".to_vec()];
    fuzz("what_fails", 30_000, corpus, |_, input| {
        // A length that lies.
        assert!(!input.windows(2).any(|pair| pair == [0xff, 0xff]), "found it");
        true
    });
}

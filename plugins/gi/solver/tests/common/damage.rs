//! Damage to glTF files; the baker's tests do the same to theirs.

use serde_json::Value;

/// SplitMix64.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// The number of values in a tree.
pub(crate) fn count(value: &Value) -> usize {
    1 + match value {
        Value::Array(list) => list.iter().map(count).sum(),
        Value::Object(map) => map.values().map(count).sum(),
        _ => 0,
    }
}

/// Replaces the value with number `target` in depth-first order.
pub(crate) fn replace(value: &mut Value, target: &mut usize, by: &Value) {
    if *target == 0 {
        *value = by.clone();
        *target = usize::MAX;
        return;
    }
    *target -= 1;
    match value {
        Value::Array(list) => list.iter_mut().for_each(|v| replace(v, target, by)),
        Value::Object(map) => map.values_mut().for_each(|v| replace(v, target, by)),
        _ => {}
    }
}

/// A value of a kind that breaks readers.
pub(crate) fn replacement(random: &mut Random) -> Value {
    match random.below(13) {
        0..4 => (random.next() % 12).into(),
        4 => u64::MAX.into(),
        5 => (1_u64 << random.below(64)).into(),
        6 => (-1).into(),
        7 => Value::from([1e38, -1e38, 1e-30, 0.5][random.below(4)]),
        8 => [5120, 5121, 5122, 5123, 5125, 5126][random.below(6)].into(),
        9 => Value::from(["SCALAR", "VEC2", "VEC3", "MAT4", "", "spot", "BLEND"][random.below(7)]),
        10 => Value::Null,
        11 => serde_json::json!([0, 1, 2]),
        _ => Value::Array(Vec::new()),
    }
}

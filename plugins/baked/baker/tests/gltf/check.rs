//! What holds for every file that is written.

use std::collections::BTreeSet;

use serde_json::Value;

/// A file taken apart.
pub(crate) struct Parts {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

/// Takes a file apart and checks it: the `gltf` crate's validation, chunks, alignment, ranges, bounds, and
/// that nothing is left over.
pub(crate) fn valid(bytes: &[u8]) -> Parts {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(word(8), bytes.len());
    assert_eq!(&bytes[16..20], b"JSON");
    let end = 20 + word(12);
    assert_eq!(end % 4, 0);
    let bin = match bytes.get(end..) {
        None | Some([]) => Vec::new(),
        Some(chunk) => {
            assert_eq!(&chunk[4..8], b"BIN\0");
            chunk[8..].to_vec()
        }
    };
    let json: Value = serde_json::from_slice(&bytes[20..end]).unwrap();
    gltf::Gltf::from_slice(bytes).unwrap_or_else(|error| panic!("{error}: {json:#}"));
    let parts = Parts { json, bin };
    for i in 0..list(&parts.json, "bufferViews").len() {
        let view = &parts.json["bufferViews"][i];
        assert_eq!(view["buffer"], 0);
        assert!(view["byteLength"].as_u64().unwrap() > 0);
        parts.view(i);
    }
    for i in 0..list(&parts.json, "accessors").len() {
        let accessor = &parts.json["accessors"][i];
        if accessor.get("bufferView").is_some() && accessor["componentType"] == 5126 {
            let components = parts.floats(i);
            for (k, bound) in list(accessor, "min").iter().enumerate() {
                let low = components.iter().map(|e| e[k]).filter(|v| v.is_finite());
                let low = low.fold(f32::INFINITY, f32::min);
                assert_eq!(bound.as_f64().unwrap() as f32, low, "accessor {i}: {accessor}");
            }
        }
    }
    parts
}

impl Parts {
    pub(crate) fn view(&self, i: usize) -> &[u8] {
        let view = &self.json["bufferViews"][i];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        assert_eq!(start % 4, 0, "view {i}");
        &self.bin[start..][..view["byteLength"].as_u64().unwrap() as usize]
    }

    /// The elements of an accessor as bytes, dense or strided.
    pub(crate) fn elements(&self, i: usize) -> Vec<&[u8]> {
        let accessor = &self.json["accessors"][i];
        let number = |v: &Value, default| v.as_u64().unwrap_or(default) as usize;
        let component = [1, 1, 2, 2, 0, 4, 4][number(&accessor["componentType"], 0) - 5120];
        let kinds = ["", "SCALAR", "VEC2", "VEC3", "VEC4"];
        let size = component * kinds.iter().position(|k| accessor["type"] == *k).unwrap();
        let view = number(&accessor["bufferView"], 0);
        let stride = number(&self.json["bufferViews"][view]["byteStride"], size as u64);
        let offset = number(&accessor["byteOffset"], 0);
        assert_eq!(offset % component, 0);
        let bytes = &self.view(view)[offset..];
        (0..number(&accessor["count"], 0)).map(|i| &bytes[i * stride..][..size]).collect()
    }

    pub(crate) fn floats(&self, i: usize) -> Vec<Vec<f32>> {
        let float = |b: &[u8; 4]| f32::from_le_bytes(*b);
        self.elements(i).iter().map(|e| e.as_chunks().0.iter().map(float).collect()).collect()
    }

    /// The number of buffer views and accessors that nothing names.
    pub(crate) fn left_over(&self) -> (usize, usize) {
        let mut views = BTreeSet::new();
        let mut accessors = BTreeSet::new();
        let mut stack = vec![(String::new(), &self.json)];
        while let Some((key, value)) = stack.pop() {
            match value {
                Value::Array(list) => stack.extend(list.iter().map(|v| (key.clone(), v))),
                Value::Object(object) => {
                    let inside = ["attributes", "targets"].contains(&key.as_str());
                    stack.extend(
                        object
                            .iter()
                            .map(|(name, v)| (if inside { key.clone() } else { name.clone() }, v)),
                    );
                }
                Value::Number(n) => {
                    let n = n.as_u64().unwrap_or(u64::MAX) as usize;
                    match key.as_str() {
                        "bufferView" => drop(views.insert(n)),
                        "attributes"
                        | "targets"
                        | "indices"
                        | "input"
                        | "output"
                        | "inverseBindMatrices" => drop(accessors.insert(n)),
                        _ => {}
                    }
                }
                _ => {}
            }
        }
        let left = |key: &str, used: &BTreeSet<usize>| {
            (0..list(&self.json, key).len()).filter(|i| !used.contains(i)).count()
        };
        (left("bufferViews", &views), left("accessors", &accessors))
    }
}

pub(crate) fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

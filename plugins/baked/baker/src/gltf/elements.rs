//! The elements of accessors as bytes, every bound checked first.

use std::collections::HashMap;

use serde_json::Value;

use super::{
    Source,
    values::{list, number},
};

impl Source {
    /// The bytes of a buffer view.
    pub(super) fn view(&self, index: usize) -> Result<&[u8], String> {
        let views = list(&self.json, "bufferViews");
        let Some(view) = views.get(index) else {
            return Err(format!("buffer view {index} does not exist (there are {})", views.len()));
        };
        let buffer = number(view, "buffer").unwrap_or(usize::MAX);
        let Some(data) = self.package.buffers.get(buffer) else {
            return Err(format!("buffer view {index} names buffer {buffer}, which does not exist"));
        };
        let start = number(view, "byteOffset").unwrap_or(0);
        let length = number(view, "byteLength").unwrap_or(0);
        start.checked_add(length).and_then(|end| data.get(start..end)).ok_or_else(|| {
            format!(
                "buffer view {index} wants {length} bytes from byte {start} of buffer {buffer}, \
                 which has {}",
                data.len()
            )
        })
    }
}

/// An accessor's elements.
pub(super) struct Elements<'a> {
    /// `None`: zeros.
    bytes: Option<&'a [u8]>,
    stride: usize,
    zero: Vec<u8>,
    /// Bytes of an element; the columns of matrices are aligned to 4.
    pub(super) size: usize,
    pub(super) count: usize,
    /// Type of the components, as in the file.
    pub(super) component: Component,
    /// Components of an element.
    pub(super) components: usize,
    /// Elements that a sparse accessor replaces.
    replaced: HashMap<usize, &'a [u8]>,
}

/// Types of components.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn parse(value: &Value) -> Option<Self> {
        Some(match number(value, "componentType")? {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// A component without normalization.
    pub(super) fn read(self, b: &[u8]) -> f64 {
        match (self, b) {
            (Self::I8, &[a, ..]) => f64::from(a as i8),
            (Self::U8, &[a, ..]) => f64::from(a),
            (Self::I16, &[a, b, ..]) => f64::from(i16::from_le_bytes([a, b])),
            (Self::U16, &[a, b, ..]) => f64::from(u16::from_le_bytes([a, b])),
            (Self::U32, &[a, b, c, d, ..]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            (Self::F32, &[a, b, c, d, ..]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => 0.0,
        }
    }
}

impl<'a> Elements<'a> {
    /// Finds and checks an accessor.
    pub(super) fn find(source: &'a Source, index: usize) -> Result<Self, String> {
        let accessors = list(&source.json, "accessors");
        let Some(accessor) = accessors.get(index) else {
            return Err(format!("accessor {index} does not exist (there are {})", accessors.len()));
        };
        let kind = accessor.get("type").and_then(Value::as_str).unwrap_or_default();
        let (columns, rows) = match kind {
            "SCALAR" => (1, 1),
            "VEC2" => (1, 2),
            "VEC3" => (1, 3),
            "VEC4" => (1, 4),
            "MAT2" => (2, 2),
            "MAT3" => (3, 3),
            "MAT4" => (4, 4),
            _ => return Err(format!("accessor {index} has an unknown type")),
        };
        let Some(component) = Component::parse(accessor) else {
            return Err(format!("accessor {index} has an unknown component type"));
        };
        let column = rows * component.size();
        let size = if columns == 1 { column } else { columns * column.next_multiple_of(4) };
        let count = number(accessor, "count").unwrap_or(0);
        let mut elements = Self {
            bytes: None,
            stride: size,
            zero: vec![0; size],
            size,
            count,
            component,
            components: columns * rows,
            replaced: HashMap::new(),
        };
        if accessor.get("bufferView").is_some() {
            (elements.bytes, elements.stride) = {
                let (bytes, stride) = part(source, accessor, size, count)?;
                (Some(bytes), stride)
            };
        }
        if let Some(sparse) = accessor.get("sparse") {
            let missing = Value::Null;
            let [places, values] =
                ["indices", "values"].map(|key| sparse.get(key).unwrap_or(&missing));
            let changes = number(sparse, "count").unwrap_or(0);
            let Some(place) = Component::parse(places) else {
                return Err(format!("accessor {index}: its sparse indices have an unknown type"));
            };
            let (places, place_stride) = part(source, places, place.size(), changes)?;
            let (values, stride) = part(source, values, size, changes)?;
            for i in 0..changes {
                let at = place.read(&places[i * place_stride..]) as usize;
                elements.replaced.insert(at, &values[i * stride..][..size]);
            }
        }
        Ok(elements)
    }

    /// The bytes of an element; zeros beyond the end.
    pub(super) fn get(&self, i: usize) -> &[u8] {
        if let Some(bytes) = self.replaced.get(&i) {
            return bytes;
        }
        let bytes = if i < self.count { self.bytes } else { None };
        bytes.map_or(&self.zero, |bytes| &bytes[i * self.stride..][..self.size])
    }
}

/// Bytes and stride of `count` elements of `size` bytes where an object says.
fn part<'a>(
    source: &'a Source,
    object: &Value,
    size: usize,
    count: usize,
) -> Result<(&'a [u8], usize), String> {
    let Some(index) = number(object, "bufferView") else {
        return Err("a buffer view is missing".into());
    };
    let bytes = source.view(index)?;
    let view = &list(&source.json, "bufferViews")[index];
    let stride = number(view, "byteStride").unwrap_or(size);
    let offset = number(object, "byteOffset").unwrap_or(0);
    let length = match count {
        0 => Some(0),
        _ => (count - 1).checked_mul(stride).and_then(|n| n.checked_add(size)),
    };
    let inside = length
        .and_then(|length| offset.checked_add(length))
        .is_some_and(|end| stride >= size && end <= bytes.len());
    if !inside {
        return Err(format!(
            "{count} elements of {size} bytes, {stride} apart, from byte {offset} do not fit into \
             buffer view {index} of {} bytes",
            bytes.len()
        ));
    }
    Ok((&bytes[offset..], stride))
}

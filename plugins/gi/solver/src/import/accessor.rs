//! Typed reads from buffer views, with every bound checked first.
//!
//! The `gltf` crate's iterators are not used: on malformed accessors (an empty or overflowing count,
//! a stride below the element's size, a component type that does not fit) they panic.

use gltf::json::{
    Accessor, Index,
    accessor::{ComponentType, Type},
    buffer,
    validation::Checked,
};

use super::container::File;

/// Elements of one component type at a stride.
#[derive(Clone, Copy)]
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    component: ComponentType,
    normalized: bool,
}

impl Elements<'_> {
    /// Component `k` of element `i`; both were checked.
    fn float(&self, i: usize, k: usize) -> f32 {
        let size = self.component.size();
        let at = i * self.stride + k * size;
        let b = &self.bytes[at..at + size];
        let scaled =
            |value: f32, max: f32| if self.normalized { (value / max).max(-1.0) } else { value };
        match self.component {
            ComponentType::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            ComponentType::U8 => scaled(f32::from(b[0]), 255.0),
            ComponentType::I8 => scaled(f32::from(b[0] as i8), 127.0),
            ComponentType::U16 => scaled(f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            ComponentType::I16 => scaled(f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            ComponentType::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
        }
    }

    fn unsigned(&self, i: usize) -> u32 {
        let size = self.component.size();
        let at = i * self.stride;
        let b = &self.bytes[at..at + size];
        match self.component {
            ComponentType::U8 => u32::from(b[0]),
            ComponentType::U16 => u32::from(u16::from_le_bytes([b[0], b[1]])),
            _ => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        }
    }
}

/// Vertex indices, read one by one so that long lists are not held twice.
pub(super) enum Indices<'a> {
    /// 0, 1, 2, ...
    Implicit(usize),
    /// In the file.
    File(IndexList<'a>),
    /// Put together from a sparse accessor.
    Sparse(Vec<u32>),
}

/// Indices in a buffer view.
pub(super) struct IndexList<'a>(Elements<'a>);

impl Indices<'_> {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Implicit(count) => *count,
            Self::File(list) => list.0.count,
            Self::Sparse(list) => list.len(),
        }
    }

    pub(super) fn get(&self, i: usize) -> u32 {
        match self {
            Self::Implicit(_) => i as u32,
            Self::File(list) => list.0.unsigned(i),
            Self::Sparse(list) => list[i],
        }
    }
}

/// The number of elements an accessor claims to have.
pub(super) fn count(file: &File<'_>, index: Index<Accessor>) -> Result<u64, String> {
    Ok(find(file, index)?.count.0)
}

/// Reads `N` components an element as floats; integers become 0..1 or -1..1 if they are normalized
/// and plain numbers if not (`KHR_mesh_quantization`).
pub(super) fn floats<const N: usize>(
    file: &File<'_>,
    index: Index<Accessor>,
) -> Result<Vec<[f32; N]>, String> {
    let accessor = find(file, index)?;
    let (component, kind) = types(index, accessor)?;
    let wanted = if N == 2 { Type::Vec2 } else { Type::Vec3 };
    if kind != wanted || component == ComponentType::U32 {
        return Err(format!(
            "accessor {index} holds {component:?} {kind:?}, not {wanted:?} floats"
        ));
    }
    let count = accessor.count.0 as usize;
    let read = |elements: &Elements<'_>, i| std::array::from_fn(|k| elements.float(i, k));
    let mut values = match accessor.buffer_view {
        Some(view) => {
            let offset = accessor.byte_offset.map_or(0, |o| o.0);
            let elements =
                elements(file, view, offset, accessor.count.0, component, N, accessor.normalized)?;
            (0..count).map(|i| read(&elements, i)).collect()
        }
        None => vec![[0.0; N]; count],
    };
    sparse(file, accessor, component, N, |i, elements, j| values[i] = read(elements, j))?;
    Ok(values)
}

/// Vertex indices.
pub(super) fn indices<'a>(
    file: &'a File<'_>,
    index: Index<Accessor>,
) -> Result<Indices<'a>, String> {
    let accessor = find(file, index)?;
    let (component, kind) = types(index, accessor)?;
    let unsigned = matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
    if kind != Type::Scalar || !unsigned {
        return Err(format!("accessor {index} holds {component:?} {kind:?}, not indices"));
    }
    let base = match accessor.buffer_view {
        Some(view) => {
            let offset = accessor.byte_offset.map_or(0, |o| o.0);
            Some(elements(file, view, offset, accessor.count.0, component, 1, false)?)
        }
        None => None,
    };
    match base {
        Some(elements) if accessor.sparse.is_none() => Ok(Indices::File(IndexList(elements))),
        base => {
            let count = accessor.count.0 as usize;
            let mut values = match base {
                Some(elements) => (0..count).map(|i| elements.unsigned(i)).collect(),
                None => vec![0; count],
            };
            sparse(file, accessor, component, 1, |i, elements, j| {
                values[i] = elements.unsigned(j);
            })?;
            Ok(Indices::Sparse(values))
        }
    }
}

fn find<'a>(file: &'a File<'_>, index: Index<Accessor>) -> Result<&'a Accessor, String> {
    file.root.get(index).ok_or_else(|| {
        format!("accessor {index} does not exist (there are {})", file.root.accessors.len())
    })
}

fn types(index: Index<Accessor>, accessor: &Accessor) -> Result<(ComponentType, Type), String> {
    match (accessor.component_type, accessor.type_) {
        (Checked::Valid(component), Checked::Valid(kind)) => Ok((component.0, kind)),
        _ => Err(format!("accessor {index} has an unknown component type or type")),
    }
}

/// Checks that `count` elements lie within a view.
fn elements<'a>(
    file: &'a File<'_>,
    view: Index<buffer::View>,
    offset: u64,
    count: u64,
    component: ComponentType,
    components: usize,
    normalized: bool,
) -> Result<Elements<'a>, String> {
    let (bytes, stride) = file.view(view)?;
    let size = component.size() * components;
    let stride = stride.unwrap_or(size);
    if stride < size {
        return Err(format!("buffer view {view} has a stride of {stride} bytes for {size} each"));
    }
    let needed = match count {
        0 => Some(0),
        _ => (count - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(size as u64)),
    };
    let inside = needed
        .and_then(|needed| offset.checked_add(needed))
        .is_some_and(|end| end <= bytes.len() as u64);
    if !inside {
        return Err(format!(
            "{count} elements of {size} bytes, {stride} apart, from byte {offset} do not fit into \
             buffer view {view} of {} bytes",
            bytes.len()
        ));
    }
    let bytes = &bytes[offset as usize..];
    Ok(Elements { bytes, stride, count: count as usize, component, normalized })
}

/// Calls `set(element, values, value index)` for each element that a sparse accessor replaces.
fn sparse(
    file: &File<'_>,
    accessor: &Accessor,
    component: ComponentType,
    components: usize,
    mut set: impl FnMut(usize, &Elements<'_>, usize),
) -> Result<(), String> {
    let Some(sparse) = &accessor.sparse else { return Ok(()) };
    let Checked::Valid(index_type) = sparse.indices.component_type else {
        return Err("the sparse indices have an unknown component type".into());
    };
    let count = sparse.count.0;
    let places = elements(
        file,
        sparse.indices.buffer_view,
        sparse.indices.byte_offset.0,
        count,
        index_type.0,
        1,
        false,
    )?;
    let values = elements(
        file,
        sparse.values.buffer_view,
        sparse.values.byte_offset.0,
        count,
        component,
        components,
        accessor.normalized,
    )?;
    for j in 0..places.count {
        let i = places.unsigned(j);
        if u64::from(i) >= accessor.count.0 {
            return Err(format!(
                "a sparse index is {i}, but there are {} elements",
                accessor.count.0
            ));
        }
        set(i as usize, &values, j);
    }
    Ok(())
}

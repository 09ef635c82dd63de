//! Short ways into JSON that may be anything.

use serde_json::Value;

/// The elements of a list; none if it is missing or no list.
pub(crate) fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// As [`list`].
pub(super) fn list_mut<'a>(value: &'a mut Value, key: &str) -> &'a mut [Value] {
    value.get_mut(key).and_then(Value::as_array_mut).map_or(&mut [], Vec::as_mut_slice)
}

/// A number that can be an index, a count or a number of bytes.
pub(crate) fn number(value: &Value, key: &str) -> Option<usize> {
    value.get(key).and_then(Value::as_u64).and_then(|n| usize::try_from(n).ok())
}

/// Appends to a top-level list, which is made if need be; the element's index.
pub(super) fn push(root: &mut Value, key: &str, element: Value) -> usize {
    let Some(root) = root.as_object_mut() else { return 0 };
    let list = root.entry(key).or_insert(Value::Null);
    match list {
        Value::Array(list) => {
            list.push(element);
            list.len() - 1
        }
        _ => {
            *list = Value::Array(vec![element]);
            0
        }
    }
}

/// Sets a member of an object; of what is no object nothing.
pub(super) fn set(value: &mut Value, key: &str, to: impl Into<Value>) {
    if let Some(object) = value.as_object_mut() {
        object.insert(key.to_owned(), to.into());
    }
}

/// An extension of an object.
pub(crate) fn extension<'a>(value: &'a Value, name: &str) -> Option<&'a Value> {
    value.get("extensions").and_then(|extensions| extensions.get(name))
}

/// As [`extension`].
pub(super) fn extension_mut<'a>(value: &'a mut Value, name: &str) -> Option<&'a mut Value> {
    value.get_mut("extensions").and_then(|extensions| extensions.get_mut(name))
}

/// Takes an extension away from an object.
pub(super) fn remove_extension(value: &mut Value, name: &str) {
    let Some(object) = value.as_object_mut() else { return };
    let Some(extensions) = object.get_mut("extensions").and_then(Value::as_object_mut) else {
        return;
    };
    extensions.remove(name);
    if extensions.is_empty() {
        object.remove("extensions");
    }
}

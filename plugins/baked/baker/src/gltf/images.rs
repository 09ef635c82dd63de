//! Images move into the file.

use std::collections::{BTreeSet, HashMap};

use serde_json::{Value, json};

use super::{
    GltfError, Source,
    primitives::Added,
    values::{list, list_mut},
};

/// Puts images that are data URIs or files into buffer views. Images that could not be read keep their
/// URI.
pub(super) fn embed(root: &mut Value, source: &Source, added: &mut Added) -> Result<(), GltfError> {
    let mut views: HashMap<&[u8], usize> = HashMap::new();
    for i in 0..list(root, "images").len() {
        let Some(Some(bytes)) = source.package.images.get(i) else { continue };
        let view = match views.get(bytes.as_slice()) {
            Some(&view) => view,
            None => added.view(root, json!({"buffer": 0}), bytes.clone())?,
        };
        views.insert(bytes, view);
        let Some(image) = list_mut(root, "images")[i].as_object_mut() else { continue };
        let uri = image.remove("uri");
        let uri = uri.as_ref().and_then(Value::as_str).unwrap_or_default();
        let kind = sniff(bytes).or(media_type(uri)).map(str::to_owned);
        if let Some(kind) = kind {
            image.insert("mimeType".into(), kind.into());
        } else if !image.contains_key("mimeType") {
            image.insert("mimeType".into(), "application/octet-stream".into());
        }
        image.insert("bufferView".into(), view.into());
    }
    Ok(())
}

impl Source {
    /// Features of Bevy that are off by default and without which it can't load the scene, for the sake of
    /// its images: `jpeg`, `webp`, `dds`.
    #[must_use]
    pub fn bevy_features(&self) -> BTreeSet<&'static str> {
        let images = self.package.images.iter().flatten();
        images
            .filter_map(|bytes| match sniff(bytes)? {
                "image/jpeg" => Some("jpeg"),
                "image/webp" => Some("webp"),
                "image/vnd-ms.dds" => Some("dds"),
                _ => None,
            })
            .collect()
    }
}

/// The type of an image by its first bytes.
fn sniff(bytes: &[u8]) -> Option<&'static str> {
    let is = |at: usize, magic: &[u8]| bytes.get(at..at + magic.len()) == Some(magic);
    Some(match () {
        () if is(0, b"\x89PNG") => "image/png",
        () if is(0, b"\xff\xd8\xff") => "image/jpeg",
        () if is(0, b"\xabKTX 20") => "image/ktx2",
        () if is(0, b"RIFF") && is(8, b"WEBP") => "image/webp",
        () if is(4, b"ftypavif") => "image/avif",
        () if is(0, b"DDS ") => "image/vnd-ms.dds",
        () => return None,
    })
}

/// What a data URI says of itself.
fn media_type(uri: &str) -> Option<&str> {
    let (kind, _) = uri.strip_prefix("data:")?.split_once(';')?;
    kind.starts_with("image/").then_some(kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jpeg_needs_a_feature_of_the_engine() {
        let file = |uris: [&str; 2]| {
            let [a, b] = uris.map(|uri| json!({"uri": format!("data:image/png;base64,{uri}")}));
            let file = json!({"asset": {"version": "2.0"}, "images": [a, b]}).to_string();
            Source::from_slice(file.as_bytes(), &Default::default()).unwrap().bevy_features()
        };
        // The first bytes of PNG and of JPEG files; what they are said to be doesn't count.
        let (png, jpeg) = ("iVBORw0KGgo=", "/9j/4AAQ");
        assert_eq!(file([png, png]), BTreeSet::new());
        assert_eq!(file([png, jpeg]), BTreeSet::from(["jpeg"]));
    }
}

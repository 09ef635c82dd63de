//! The file itself: GLB chunks, JSON, buffers inside and outside.

use std::{
    borrow::Cow,
    cell::RefCell,
    io::Read,
    path::{Component, Path, PathBuf},
};

use gltf::json::{Index, Root, buffer};

use super::{
    ImportLimits, ImportOptions, ImportProblem, Package,
    error::{Warnings, shorten},
};

/// Bytes that may still be read.
pub(super) struct FileBudget {
    limit: u64,
    used: u64,
}

impl FileBudget {
    pub(super) fn new(limits: &ImportLimits) -> Self {
        Self { limit: limits.file_bytes, used: 0 }
    }

    pub(super) fn take(&mut self, bytes: u64) -> Result<(), ImportProblem> {
        self.used = self.used.saturating_add(bytes);
        if self.used > self.limit {
            return Err(ImportProblem::Limit {
                what: "bytes (with the files it refers to)",
                found: self.used,
                limit: self.limit,
                field: "file_bytes",
            });
        }
        Ok(())
    }

    /// Reads a file whose size may lie (a pipe, one that grows).
    pub(super) fn read(&mut self, path: &Path) -> Result<Vec<u8>, ImportProblem> {
        let file = std::fs::File::open(path)?;
        let length = file.metadata()?.len();
        self.take(length)?;
        let left = self.limit - self.used;
        let mut bytes = Vec::with_capacity(length as usize);
        file.take(length + left + 1).read_to_end(&mut bytes)?;
        self.take((bytes.len() as u64).saturating_sub(length))?;
        Ok(bytes)
    }
}

/// An open file: its JSON and its buffers.
pub(super) struct File<'a> {
    pub(super) root: Root,
    pub(super) json: &'a [u8],
    buffers: Vec<Cow<'a, [u8]>>,
    folder: Option<PathBuf>,
    budget: RefCell<FileBudget>,
    /// Files beside it that were read.
    pub(super) read: RefCell<Vec<PathBuf>>,
    /// Images with a URI that were read before.
    package: Option<&'a Package>,
}

impl<'a> File<'a> {
    pub(super) fn open(
        bytes: &'a [u8],
        folder: Option<&Path>,
        budget: FileBudget,
        options: &ImportOptions,
        warnings: &mut Warnings,
    ) -> Result<Self, ImportProblem> {
        let (json, bin) = split(bytes)?;
        let mut file = Self::parse(json, folder, budget, options, warnings)?;
        for index in 0..file.root.buffers.len() {
            let data = file.buffer(index, bin)?;
            file.buffers.push(data);
        }
        Ok(file)
    }

    /// A file whose parts were read before.
    pub(super) fn of_package(
        package: &'a Package,
        options: &ImportOptions,
        warnings: &mut Warnings,
    ) -> Result<Self, ImportProblem> {
        let budget = FileBudget::new(&options.limits);
        let mut file = Self::parse(&package.json, None, budget, options, warnings)?;
        file.buffers = package.buffers.iter().map(|data| Cow::from(data.as_slice())).collect();
        file.package = Some(package);
        Ok(file)
    }

    fn parse(
        json: &'a [u8],
        folder: Option<&Path>,
        budget: FileBudget,
        options: &ImportOptions,
        warnings: &mut Warnings,
    ) -> Result<Self, ImportProblem> {
        check_json_size(json, &options.limits)?;
        let root = Root::from_slice(json).map_err(|e| ImportProblem::NotGltf(e.to_string()))?;
        if !root.asset.version.starts_with("2.") {
            return Err(ImportProblem::NotGltf(format!(
                "its version is {:?}; export it as glTF 2.0",
                shorten(&root.asset.version)
            )));
        }
        check_extensions(&root, warnings)?;
        Ok(Self {
            root,
            json,
            buffers: Vec::new(),
            folder: folder.map(Path::to_path_buf),
            budget: RefCell::new(budget),
            read: RefCell::default(),
            package: None,
        })
    }

    fn buffer(&self, index: usize, bin: Option<&'a [u8]>) -> Result<Cow<'a, [u8]>, ImportProblem> {
        let buffer = &self.root.buffers[index];
        let data: Cow<'a, [u8]> = match (&buffer.uri, bin) {
            (Some(uri), _) => self.uri(uri)?.into(),
            (None, Some(bin)) if index == 0 => bin.into(),
            // Only fallbacks of compressed views may have neither; views into it fail on their own.
            (None, _) => return Ok(Cow::Borrowed(&[])),
        };
        if (data.len() as u64) < buffer.byte_length.0 {
            return Err(ImportProblem::Damaged(format!(
                "buffer {index} should have {} bytes but there are {}",
                buffer.byte_length.0,
                data.len()
            )));
        }
        Ok(data)
    }

    /// The bytes of an image that has a URI.
    pub(super) fn image(&self, index: usize, uri: &str) -> Result<Cow<'a, [u8]>, ImportProblem> {
        let Some(package) = self.package else { return self.uri(uri).map(Cow::from) };
        match package.images.get(index) {
            Some(Some(bytes)) => Ok(bytes.as_slice().into()),
            _ => Err(ImportProblem::External {
                uri: shorten(uri),
                what: "it could not be read".into(),
            }),
        }
    }

    /// The bytes behind a data URI or a relative path.
    fn uri(&self, uri: &str) -> Result<Vec<u8>, ImportProblem> {
        let external = |what: String| ImportProblem::External { uri: shorten(uri), what };
        if let Some(data) = uri.strip_prefix("data:") {
            let Some((_, encoded)) = data.split_once(";base64,") else {
                return Err(external("only base64 data URIs are supported".into()));
            };
            self.budget.borrow_mut().take(encoded.len() as u64 / 4 * 3)?;
            return base64(encoded.as_bytes())
                .ok_or_else(|| external("this is not valid base64".into()));
        }
        let Some(folder) = &self.folder else {
            return Err(external("data in memory cannot refer to files".into()));
        };
        let relative = percent_decode(uri)
            .ok_or_else(|| external("this is not a valid relative path".into()))?;
        let relative = Path::new(&relative);
        let below =
            relative.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if !below || uri.contains(['\\', ':', '\0']) {
            return Err(external("only files below the folder of the glTF file are read".into()));
        }
        let path = folder.join(relative);
        // Symbolic links may still lead elsewhere.
        let inside = |path: &Path| {
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            Ok::<_, std::io::Error>(path.canonicalize()?.starts_with(folder.canonicalize()?))
        };
        match inside(&path) {
            Ok(true) => {
                let bytes =
                    self.budget.borrow_mut().read(&path).map_err(|problem| match problem {
                        ImportProblem::Io(error) => external(error.to_string()),
                        other => other,
                    })?;
                self.read.borrow_mut().push(path);
                Ok(bytes)
            }
            Ok(false) => Err(external("the link leads out of the folder of the glTF file".into())),
            Err(error) => Err(external(format!("{error} (looked for {})", path.display()))),
        }
    }

    /// The data of all buffers.
    pub(super) fn into_buffers(self) -> Vec<Vec<u8>> {
        self.buffers.into_iter().map(Cow::into_owned).collect()
    }

    /// The bytes and the stride of a buffer view.
    pub(super) fn view(
        &self,
        index: Index<buffer::View>,
    ) -> Result<(&[u8], Option<usize>), String> {
        let Some(view) = self.root.get(index) else {
            return Err(format!(
                "buffer view {index} does not exist (there are {})",
                self.root.buffer_views.len()
            ));
        };
        let Some(data) = self.buffers.get(view.buffer.value()) else {
            return Err(format!(
                "buffer view {index} names buffer {}, but there are {}",
                view.buffer,
                self.buffers.len()
            ));
        };
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        let range = start
            .checked_add(view.byte_length.0)
            .and_then(|end| Some(usize::try_from(start).ok()?..usize::try_from(end).ok()?));
        let Some(bytes) = range.and_then(|range| data.get(range)) else {
            return Err(format!(
                "buffer view {index} wants {} bytes from byte {start} of buffer {}, which has {}",
                view.byte_length.0,
                view.buffer,
                data.len()
            ));
        };
        Ok((bytes, view.byte_stride.map(|stride| stride.0)))
    }
}

/// JSON and binary chunk of a GLB, or the bytes as JSON.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), ImportProblem> {
    if !bytes.starts_with(b"glTF") {
        return if bytes.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'{') {
            Ok((bytes, None))
        } else {
            Err(ImportProblem::NotGltf("it starts neither with \"glTF\" nor with \"{\"".into()))
        };
    }
    let damaged = |what: String| ImportProblem::Damaged(what);
    let word = |at: usize| {
        let bytes = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(damaged("the header is cut off".into()));
    };
    if version != 2 {
        return Err(ImportProblem::NotGltf(format!("its version is {version}; export it as 2.0")));
    }
    if length as usize > bytes.len() {
        return Err(damaged(format!(
            "the header says {length} bytes but there are {}",
            bytes.len()
        )));
    }
    let mut at = 12;
    let mut chunk = |kind: &str| {
        let (Some(length), Some(tag)) = (word(at), word(at + 4)) else { return Ok(None) };
        let start = at + 8;
        let Some(data) = start.checked_add(length as usize).and_then(|end| bytes.get(start..end))
        else {
            return Err(damaged(format!(
                "the {kind} chunk says {length} bytes but there are {}",
                bytes.len().saturating_sub(start)
            )));
        };
        at = start + (length as usize).next_multiple_of(4);
        Ok(Some((tag, data)))
    };
    let json = match chunk("JSON")? {
        Some((tag, data)) if &tag.to_le_bytes() == b"JSON" => data,
        _ => return Err(damaged("the first chunk is not JSON".into())),
    };
    let mut bin = None;
    // Chunks of unknown kinds are skipped, as the specification asks.
    while let Some((tag, data)) = chunk("binary")? {
        if bin.is_none() && &tag.to_le_bytes() == b"BIN\0" {
            bin = Some(data);
        }
    }
    Ok((json, bin))
}

/// Three bytes of JSON can become a structure of hundreds: bounds their number before parsing.
fn check_json_size(json: &[u8], limits: &ImportLimits) -> Result<(), ImportProblem> {
    let values = json.iter().filter(|b| matches!(b, b',' | b'{' | b'[')).count() as u64;
    if values > limits.json_values {
        return Err(ImportProblem::Limit {
            what: "JSON values",
            found: values,
            limit: limits.json_values,
            field: "json_values",
        });
    }
    Ok(())
}

fn check_extensions(root: &Root, warnings: &mut Warnings) -> Result<(), ImportProblem> {
    for extension in &root.extensions_required {
        let fix = match extension.as_str() {
            "KHR_draco_mesh_compression" | "EXT_meshopt_compression" => {
                "export the scene without mesh compression"
            }
            "KHR_mesh_quantization"
            | "KHR_lights_punctual"
            | "KHR_texture_transform"
            | "KHR_texture_basisu"
            | "EXT_texture_webp" => continue,
            // Looks, not shapes: the plain factors remain.
            name if name.starts_with("KHR_materials_") => continue,
            _ => "export the scene without it",
        };
        return Err(ImportProblem::Extension { extension: shorten(extension), fix });
    }
    for extension in &root.extensions_used {
        if extension == "EXT_mesh_gpu_instancing" {
            warnings.push(|| format!("{extension} is not supported: its copies are left out"));
        }
    }
    Ok(())
}

/// RFC 4648, with or without padding; white space is not allowed.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let text = text.strip_suffix(b"==").or_else(|| text.strip_suffix(b"=")).unwrap_or(text);
    if text.len() % 4 == 1 {
        return None;
    }
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    let (mut buffer, mut bits) = (0_u32, 0);
    for &c in text {
        let six = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        buffer = buffer << 6 | u32::from(six);
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            bytes.push((buffer >> bits) as u8);
        }
    }
    Some(bytes)
}

fn percent_decode(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        if *first == b'%' {
            let (digits, tail) = tail.split_at_checked(2)?;
            bytes.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
            rest = tail;
        } else {
            bytes.push(*first);
        }
    }
    let decoded = String::from_utf8(bytes).ok()?;
    (!decoded.contains(['\\', '\0', ':'])).then_some(decoded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_follows_the_rfc() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg", "foob"),
            ("Zm9vYmE=", "fooba"),
            ("Zm9vYmFy", "foobar"),
        ] {
            assert_eq!(base64(text.as_bytes()).as_deref(), Some(bytes.as_bytes()), "{text}");
        }
        assert_eq!(base64(b"Zm9v!"), None);
        assert_eq!(base64(b"Z"), None);
    }

    #[test]
    fn percent_encoding_cannot_smuggle_separators() {
        assert_eq!(percent_decode("a%20b.bin").as_deref(), Some("a b.bin"));
        for bad in ["%", "%g0", "%5C", "c%3A", "%00"] {
            assert_eq!(percent_decode(bad), None, "{bad}");
        }
    }
}

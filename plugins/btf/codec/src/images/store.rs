//! Pictures that are decoded when they are asked for, and some of which stay in memory.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use image::{ImageReader, Limits};
use zip::ZipArchive;

use crate::BtfError;

/// The longest picture file.
const LONGEST_FILE: u64 = 64 << 20;
/// Widest and highest picture.
const LARGEST: u32 = 8192;
/// What decoding a picture may take.
const DECODER_BYTES: u64 = 512 << 20;
/// Decoded pictures that stay in memory.
const CACHE_BYTES: usize = 256 << 20;

type Result<T> = std::result::Result<T, BtfError>;

/// A decoded picture.
#[derive(Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width and height.
    pub size: [u32; 2],
    /// Red, green and blue of each texel, row after row, gamma-encoded.
    pub texels: Vec<[u8; 3]>,
}

/// Where pictures come from.
pub(crate) enum Source {
    /// Files in a folder.
    Folder(Vec<PathBuf>),
    /// Entries of an archive, by their numbers.
    Archive {
        path: PathBuf,
        archive: Mutex<ZipArchive<BufReader<File>>>,
        /// Number in the archive, and name.
        entries: Vec<(usize, String)>,
    },
}

pub(super) struct Store {
    source: Source,
    /// Size that all must have.
    size: [u32; 2],
    cache: Mutex<Cache>,
}

#[derive(Default)]
struct Cache {
    /// Pictures, and when they were used last.
    pictures: HashMap<u32, (Arc<Picture>, u64)>,
    bytes: usize,
    clock: u64,
}

impl Store {
    /// Takes the size of all pictures from the first one.
    pub(super) fn new(source: Source) -> Result<Self> {
        let mut store = Self { source, size: [0; 2], cache: Mutex::default() };
        store.size = store.decode(0)?.size;
        Ok(store)
    }

    pub(super) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// A picture, from memory if it is there.
    pub(super) fn picture(&self, number: u32) -> Result<Arc<Picture>> {
        // A panic elsewhere leaves nothing half done in here.
        let lock = || self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(picture) = lock().get(number) {
            return Ok(picture);
        }
        let picture = Arc::new(self.read(number)?);
        lock().keep(number, picture.clone());
        Ok(picture)
    }

    /// A picture, past the memory.
    pub(super) fn read(&self, number: u32) -> Result<Picture> {
        let picture = self.decode(number)?;
        if picture.size == self.size {
            return Ok(picture);
        }
        let ([width, height], [first_width, first_height]) = (picture.size, self.size);
        Err(self.wrong(
            number,
            &format!("{width} x {height} texels, others {first_width} x {first_height}"),
        ))
    }

    fn decode(&self, number: u32) -> Result<Picture> {
        let bytes = self.bytes(number)?;
        let wrong = |error: &dyn std::fmt::Display| self.wrong(number, &error.to_string());
        let mut reader = ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|error| wrong(&error))?;
        let mut limits = Limits::default();
        limits.max_image_width = Some(LARGEST);
        limits.max_image_height = Some(LARGEST);
        limits.max_alloc = Some(DECODER_BYTES);
        reader.limits(limits);
        let picture = reader.decode().map_err(|error| wrong(&error))?.into_rgb8();
        let size = picture.dimensions().into();
        if size == [0, 0] {
            return Err(wrong(&"no texels"));
        }
        Ok(Picture { size, texels: picture.pixels().map(|texel| texel.0).collect() })
    }

    fn bytes(&self, number: u32) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let read = |source: &mut dyn Read, bytes: &mut Vec<u8>| {
            // One more, so that too long a file is noticed.
            source.take(LONGEST_FILE + 1).read_to_end(bytes)
        };
        match &self.source {
            Source::Folder(files) => {
                let path =
                    files.get(number as usize).map(PathBuf::as_path).unwrap_or(Path::new(""));
                let io = |error| BtfError::io(path, error);
                read(&mut File::open(path).map_err(io)?, &mut bytes).map_err(io)?;
            }
            Source::Archive { archive, entries, .. } => {
                let wrong = |error: &dyn std::fmt::Display| self.wrong(number, &error.to_string());
                let entry = entries.get(number as usize).map_or(usize::MAX, |entry| entry.0);
                let mut archive = archive.lock().unwrap_or_else(PoisonError::into_inner);
                let mut entry = archive.by_index(entry).map_err(|error| wrong(&error))?;
                read(&mut entry, &mut bytes).map_err(|error| wrong(&error))?;
            }
        }
        if bytes.len() as u64 > LONGEST_FILE {
            return Err(self.wrong(number, &format!("longer than {LONGEST_FILE} bytes")));
        }
        Ok(bytes)
    }

    fn wrong(&self, number: u32, what: &str) -> BtfError {
        match &self.source {
            Source::Folder(files) => {
                BtfError::format(files.get(number as usize).cloned().unwrap_or_default(), what)
            }
            Source::Archive { path, entries, .. } => {
                let name = entries.get(number as usize).map_or("", |entry| &entry.1);
                BtfError::format(path, format!("{name:?}: {what}"))
            }
        }
    }
}

impl Cache {
    fn get(&mut self, number: u32) -> Option<Arc<Picture>> {
        self.clock += 1;
        let (picture, used) = self.pictures.get_mut(&number)?;
        *used = self.clock;
        Some(picture.clone())
    }

    fn keep(&mut self, number: u32, picture: Arc<Picture>) {
        let bytes = |picture: &Picture| 3 * picture.texels.len();
        let new = bytes(&picture);
        while self.bytes + new > CACHE_BYTES
            && let Some(oldest) =
                self.pictures.iter().min_by_key(|(_, (_, used))| *used).map(|(number, _)| *number)
        {
            if let Some((picture, _)) = self.pictures.remove(&oldest) {
                self.bytes -= bytes(&picture);
            }
        }
        self.bytes += new;
        if let Some((other, _)) = self.pictures.insert(number, (picture, self.clock)) {
            self.bytes -= bytes(&other);
        }
    }
}

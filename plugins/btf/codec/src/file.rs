//! The suite's own file: tables as the evaluators and the GPU want them, ready to be mapped.
//!
//! All numbers are little-endian.
//!
//! | bytes | what |
//! |---|---|
//! | 0..8 | `FBTF\r\n\x1a\n` |
//! | 8..12 | version, 1 |
//! | 12..16 | bytes of the [`Layout`], L |
//! | 16..24 | bytes of the description, D |
//! | 24..32 | number of words, W |
//! | 32..64 | BLAKE3 of bytes 0..32 and of all from 64 on |
//! | 64.. | the [`Layout`], L bytes |
//! | | the description, D bytes: an [`Info`] in RON, UTF-8 |
//! | | zeros up to a multiple of 64 |
//! | | W words of 4 bytes, up to the end of the file |

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

use bytemuck::{Zeroable, cast_slice, cast_slice_mut};
use memmap2::Mmap;

use crate::words::Words;
use crate::{Btf, BtfError, Info, Layout, read};

const MAGIC: [u8; 8] = *b"FBTF\r\n\x1a\n";
const VERSION: u32 = 1;
/// Bytes before the layout.
const HEAD: usize = 64;
/// Words begin at a multiple of this.
const ALIGNMENT: usize = 64;
/// The longest description.
const LONGEST_INFO: u64 = 1 << 20;

type Result<T> = std::result::Result<T, BtfError>;

/// Whether bytes begin as an own file does.
pub(crate) fn is_own(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// What stands before the words.
struct Head {
    info: Info,
    layout: Layout,
    /// Byte where the words begin.
    words_from: usize,
}

/// Reads all but the words, and checks the sum of everything.
fn head(bytes: &[u8]) -> Result<Head> {
    let damaged = |what: String| BtfError::Tables(what);
    let fixed = bytes.get(..HEAD).ok_or_else(|| {
        damaged(format!("{} bytes: cut off within the first {HEAD}", bytes.len()))
    })?;
    if !is_own(fixed) {
        return Err(damaged("no material file of Farlight".to_owned()));
    }
    let u32_at = |at: usize| u32::from_le_bytes(fixed[at..at + 4].try_into().unwrap_or_default());
    let u64_at = |at: usize| u64::from_le_bytes(fixed[at..at + 8].try_into().unwrap_or_default());
    let version = u32_at(8);
    if version != VERSION {
        return Err(BtfError::Unsupported(format!(
            "version {version} of the file; this program knows version {VERSION}"
        )));
    }
    let (layout_bytes, info_bytes, words) = (u32_at(12), u64_at(16), u64_at(24));
    if layout_bytes as usize != size_of::<Layout>() {
        return Err(damaged(format!("a layout of {layout_bytes} bytes")));
    }
    if info_bytes > LONGEST_INFO {
        return Err(damaged(format!("a description of {info_bytes} bytes")));
    }
    let info_from = HEAD + size_of::<Layout>();
    let info_to = info_from + info_bytes as usize;
    let words_from = info_to.next_multiple_of(ALIGNMENT);
    let length = words.checked_mul(4).and_then(|bytes| bytes.checked_add(words_from as u64));
    if length != Some(bytes.len() as u64) {
        return Err(damaged(format!(
            "{} bytes where {words} words and a description of {info_bytes} bytes are announced: \
             cut off, or not whole",
            bytes.len()
        )));
    }
    if hash(&fixed[..32], &bytes[HEAD..]) != fixed[32..] {
        return Err(damaged("the checksum is wrong".to_owned()));
    }
    let mut layout = Layout::zeroed();
    let fields = cast_slice_mut::<_, u32>(std::slice::from_mut(&mut layout));
    for (field, bytes) in fields.iter_mut().zip(bytes[HEAD..info_from].as_chunks().0) {
        *field = u32::from_le_bytes(*bytes);
    }
    let info = str::from_utf8(&bytes[info_from..info_to])
        .map_err(|_| damaged("the description is no UTF-8 text".to_owned()))?;
    let info = ron::from_str(info).map_err(|error| damaged(format!("the description: {error}")))?;
    Ok(Head { info, layout, words_from })
}

fn hash(first: &[u8], second: &[u8]) -> blake3::Hash {
    blake3::Hasher::new().update(first).update(second).finalize()
}

impl Btf {
    /// Reads a material from the bytes of a file: an own file (`.fbtf`) or a BTFbase binary with
    /// the default [`read::Options`], told by its content. The bytes are copied.
    ///
    /// # Errors
    ///
    /// Bytes of another kind; files that are damaged, cut off, or of a version that is not known.
    pub fn from_bytes(bytes: impl AsRef<[u8]>) -> Result<Self> {
        let bytes = bytes.as_ref();
        if is_own(bytes) {
            let Head { info, layout, words_from } = head(bytes)?;
            Self::from_parts(info, layout, Words::from_bytes(&bytes[words_from..]))
        } else if read::is_binary(bytes) {
            read::binary_from_bytes(bytes, &read::Options::default())
        } else {
            Err(BtfError::Unsupported(
                "bytes that are neither a material file of Farlight (.fbtf) nor a BTFbase binary"
                    .to_owned(),
            ))
        }
    }

    /// Opens an own file (`.fbtf`) in place: its words stay in the file and are paged in when they
    /// are needed.
    ///
    /// The file must not be changed while it is open; replace it ([`Btf::write`] does).
    ///
    /// # Errors
    ///
    /// Files that can't be read, are no own files, are damaged, cut off, or of a version that is
    /// not known.
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(|error| BtfError::io(path, error))?;
        // SAFETY: the map is only read; whoever opens a file takes care that nobody writes to it,
        // as the documentation of this function asks.
        let map = unsafe { Mmap::map(&file) }.map_err(|error| BtfError::io(path, error))?;
        let Head { info, layout, words_from } = head(&map).map_err(|e| e.in_file(path))?;
        Self::from_parts(info, layout, Words::mapped(Arc::new(map), words_from))
            .map_err(|error| error.in_file(path))
    }

    /// Writes an own file: into a file beside it that then takes its place, so that neither a
    /// reader nor a crash meets half a material.
    ///
    /// # Errors
    ///
    /// A folder that can't be written to, a description that is longer than a mebibyte.
    pub fn write(&self, path: &Path) -> Result<()> {
        let info = ron::to_string(self.info())
            .map_err(|error| BtfError::Unsupported(format!("a description: {error}")))?;
        if info.len() as u64 > LONGEST_INFO {
            return Err(BtfError::Unsupported(format!("a description of {} bytes", info.len())));
        }
        let mut part = path.as_os_str().to_owned();
        part.push(format!(".part{}", std::process::id()));
        let part = Path::new(&part);
        let written = self.write_to(&info, part).and_then(|()| fs::rename(part, path));
        written.map_err(|error| {
            // Best effort: the error that matters is the first one.
            _ = fs::remove_file(part);
            BtfError::io(path, error)
        })
    }

    fn write_to(&self, info: &str, path: &Path) -> std::io::Result<()> {
        let mut first = [0; 32];
        first[..8].copy_from_slice(&MAGIC);
        first[8..12].copy_from_slice(&VERSION.to_le_bytes());
        first[12..16].copy_from_slice(&(size_of::<Layout>() as u32).to_le_bytes());
        first[16..24].copy_from_slice(&(info.len() as u64).to_le_bytes());
        first[24..].copy_from_slice(&(self.words().len() as u64).to_le_bytes());

        let mut second = Vec::with_capacity(HEAD + info.len() + ALIGNMENT + 4 * self.words().len());
        let layout = cast_slice::<_, u32>(std::slice::from_ref(self.layout()));
        second.extend(layout.iter().flat_map(|field| field.to_le_bytes()));
        second.extend(info.as_bytes());
        second.resize((HEAD + second.len()).next_multiple_of(ALIGNMENT) - HEAD, 0);
        second.extend(self.words().iter().flat_map(|word| word.to_le_bytes()));

        let mut file = BufWriter::new(File::create(path)?);
        file.write_all(&first)?;
        file.write_all(hash(&first, &second).as_bytes())?;
        file.write_all(&second)?;
        file.into_inner().map_err(std::io::IntoInnerError::into_error)?.sync_all()
    }
}

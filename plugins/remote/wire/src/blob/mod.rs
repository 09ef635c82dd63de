//! Heavy data by content: meshes, textures and sky images.
//!
//! # Format
//! The *canonical encoding* is what the hash is made of: the kind (1 mesh, 2 texture, 3 sky), its
//! head (the counts of the arrays as `u64`, for images width and height as `u32`, for textures a
//! byte that is 1 for sRGB), then the arrays. Everything is little-endian, floats are their IEEE bits, so that a
//! remote solver gets exactly what a local one would.
//!
//! What travels is the same head and then every array in pieces, each compressed by itself: see
//! [`mod@column`].

mod check;
mod column;
#[cfg(test)]
mod tests;

use std::{fmt, sync::Arc};

use farlight_gi_solver::scene::{Mesh, SkyImage, Texture};

use crate::{
    WireError,
    codec::{Reader, Writer},
};
use column::{Column, Element, Packer, Unpacker};

/// BLAKE3 hash of a blob's encoding before compression.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BlobHash(pub [u8; 32]);

impl fmt::Debug for BlobHash {
    /// The first bytes, enough to tell two apart.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("BlobHash(")?;
        self.0[..6].iter().try_for_each(|byte| write!(f, "{byte:02x}"))?;
        f.write_str("..)")
    }
}

/// Heavy data, shared.
#[derive(Clone, Debug)]
pub enum Blob {
    /// Triangles.
    Mesh(Arc<Mesh>),
    /// An image of a material.
    Texture(Arc<Texture>),
    /// An image of the sky.
    Sky(Arc<SkyImage>),
}

/// The kinds' bytes.
const MESH: u8 = 1;
const TEXTURE: u8 = 2;
const SKY: u8 = 3;

/// What errors call it.
const WHAT: &str = "a blob";

/// Takes the arrays of a blob, one after the other.
trait Columns {
    fn column<E: Element>(&mut self, values: &[E]);
}

impl Blob {
    /// Names it.
    #[must_use]
    pub fn hash(&self) -> BlobHash {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.head());
        self.columns(&mut Hashing { hasher: &mut hasher, buffer: Vec::new() });
        BlobHash(*hasher.finalize().as_bytes())
    }

    /// Its encoding, compressed: what travels, in chunks. Takes little memory beside the result.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut packer = Packer::new(self.head());
        self.columns(&mut packer);
        packer.finish()
    }

    /// Back from [`encode`](Self::encode). Takes memory only for what the bytes can really hold
    /// (LZ4 expands by 255 at most).
    ///
    /// # Errors
    /// It is not an encoding, has another hash than `expected`, is not valid (see
    /// [`check`](Self::check)), or would take more than `limit` bytes of memory.
    pub fn decode(bytes: &[u8], expected: BlobHash, limit: usize) -> Result<Self, WireError> {
        let (blob, hash) = Self::decode_any(bytes, limit)?;
        if hash == expected { Ok(blob) } else { Err(WireError::WrongHash) }
    }

    /// As [`decode`](Self::decode) where no hash was announced; says which it is.
    ///
    /// # Errors
    /// See [`decode`](Self::decode).
    pub fn decode_any(bytes: &[u8], limit: usize) -> Result<(Self, BlobHash), WireError> {
        let mut reader = Reader::new(WHAT, bytes);
        let blob = match reader.u8()? {
            MESH => Self::Mesh(Arc::new(decode_mesh(reader, limit)?)),
            TEXTURE => Self::Texture(Arc::new(decode_texture(reader, limit)?)),
            SKY => Self::Sky(Arc::new(decode_sky(reader, limit)?)),
            other => return Err(reader.invalid(format_args!("there is no kind {other}"))),
        };
        let hash = blob.hash();
        blob.check()?;
        Ok((blob, hash))
    }

    /// Bytes of memory that it takes.
    #[must_use]
    pub fn memory(&self) -> usize {
        let mut bytes = Counting(0);
        self.columns(&mut bytes);
        bytes.0
    }

    /// What stands before the arrays.
    fn head(&self) -> Vec<u8> {
        let mut head = Writer::default();
        match self {
            Self::Mesh(mesh) => {
                head.u8(MESH);
                for count in [
                    mesh.positions.len(),
                    mesh.normals.len(),
                    mesh.uv0.len(),
                    mesh.uv1.len(),
                    mesh.triangles.len(),
                ] {
                    head.u64(count as u64);
                }
            }
            Self::Texture(texture) => {
                head.u8(TEXTURE);
                head.u32(texture.width);
                head.u32(texture.height);
                head.u64(texture.texels.len() as u64);
                head.u8(texture.srgb.into());
            }
            Self::Sky(sky) => {
                head.u8(SKY);
                head.u32(sky.width);
                head.u32(sky.height);
                head.u64(sky.texels.len() as u64);
            }
        }
        head.finish()
    }

    fn columns(&self, columns: &mut impl Columns) {
        match self {
            Self::Mesh(mesh) => {
                columns.column(&mesh.positions);
                columns.column(&mesh.normals);
                columns.column(&mesh.uv0);
                columns.column(&mesh.uv1);
                columns.column(&mesh.triangles);
            }
            Self::Texture(texture) => columns.column(&texture.texels),
            Self::Sky(sky) => columns.column(&sky.texels),
        }
    }
}

fn decode_mesh(mut reader: Reader<'_>, limit: usize) -> Result<Mesh, WireError> {
    let mut unpacker = Unpacker::new(WHAT, limit);
    let positions = unpacker.column(reader.u64()?)?;
    let normals = unpacker.column(reader.u64()?)?;
    let uv0 = unpacker.column(reader.u64()?)?;
    let uv1 = unpacker.column(reader.u64()?)?;
    let triangles = unpacker.column(reader.u64()?)?;
    unpacker.start(&reader)?;
    let mesh = Mesh {
        positions: unpacker.read(&mut reader, positions)?,
        normals: unpacker.read(&mut reader, normals)?,
        uv0: unpacker.read(&mut reader, uv0)?,
        uv1: unpacker.read(&mut reader, uv1)?,
        triangles: unpacker.read(&mut reader, triangles)?,
    };
    reader.end()?;
    Ok(mesh)
}

fn decode_texture(mut reader: Reader<'_>, limit: usize) -> Result<Texture, WireError> {
    let (width, height) = (reader.u32()?, reader.u32()?);
    let mut unpacker = Unpacker::new(WHAT, limit);
    let texels: Column<[u8; 4]> = unpacker.column(reader.u64()?)?;
    check::dimensions(width, height, texels.len())?;
    let srgb = reader.flag()?;
    unpacker.start(&reader)?;
    let texels = unpacker.read(&mut reader, texels)?;
    reader.end()?;
    Ok(Texture { width, height, texels, srgb })
}

fn decode_sky(mut reader: Reader<'_>, limit: usize) -> Result<SkyImage, WireError> {
    let (width, height) = (reader.u32()?, reader.u32()?);
    let mut unpacker = Unpacker::new(WHAT, limit);
    let texels = unpacker.column(reader.u64()?)?;
    check::dimensions(width, height, texels.len())?;
    unpacker.start(&reader)?;
    let texels = unpacker.read(&mut reader, texels)?;
    reader.end()?;
    Ok(SkyImage { width, height, texels })
}

struct Counting(usize);

impl Columns for Counting {
    fn column<E: Element>(&mut self, values: &[E]) {
        self.0 += size_of_val(values);
    }
}

struct Hashing<'a> {
    hasher: &'a mut blake3::Hasher,
    buffer: Vec<u8>,
}

impl Columns for Hashing<'_> {
    fn column<E: Element>(&mut self, values: &[E]) {
        for piece in values.chunks(column::piece::<E>()) {
            self.buffer.clear();
            column::plain(piece, &mut self.buffer);
            self.hasher.update(&self.buffer);
        }
    }
}

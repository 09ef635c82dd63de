//! The suite's own file.

mod common;

use std::path::Path;

use common::small;
use farlight_btf_codec::{Angles, Btf, Rules};

fn written(folder: &Path) -> Vec<u8> {
    let path = folder.join("small.fbtf");
    small().write(&path).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn what_is_written_is_read_in_memory_and_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let (btf, bytes) = (small(), written(folder.path()));
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().flatten().collect();
    assert_eq!(names.len(), 1, "no part is left behind");
    let mapped = Btf::open(&folder.path().join("small.fbtf")).unwrap();
    for read in [Btf::from_bytes(&bytes).unwrap(), mapped] {
        assert_eq!(read.info(), btf.info());
        assert_eq!(read.layout(), btf.layout());
        assert_eq!(read.words(), btf.words());
        let angles = Angles::from_degrees(30.0, 40.0, 50.0, 60.0);
        let value = read.evaluate(1, 1, angles, Rules::SHADING);
        assert_eq!(value, btf.evaluate(1, 1, angles, Rules::SHADING));
        assert_ne!(value, glam::Vec3::ZERO);
    }
    let words = bytes.len() - 4 * btf.words().len();
    assert_eq!(words % 64, 0, "words lie as a cache line wants them");
}

#[test]
fn every_damaged_byte_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = written(folder.path());
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        assert!(Btf::from_bytes(&damaged).is_err(), "byte {at}");
        assert!(Btf::from_bytes(&bytes[..at]).is_err(), "cut at {at}");
    }
    let mut long = bytes;
    long.push(0);
    assert!(Btf::from_bytes(&long).is_err());
}

#[test]
fn errors_name_the_file_and_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = written(folder.path());
    bytes[8] = 9;
    let path = folder.path().join("newer.fbtf");
    std::fs::write(&path, &bytes).unwrap();
    let error = Btf::open(&path).unwrap_err().to_string();
    assert!(error.contains("newer.fbtf") && error.contains("version 9"), "{error}");
    std::fs::write(&path, []).unwrap();
    assert!(Btf::open(&path).unwrap_err().to_string().contains("newer.fbtf"));
    let error = Btf::from_bytes(b"PK\x03\x04").unwrap_err().to_string();
    assert!(error.contains("neither"), "{error}");
}

/// A file with a right checksum round wrong content.
fn forged(bytes: &[u8], change: impl Fn(&mut [u8])) -> Result<Btf, farlight_btf_codec::BtfError> {
    let mut bytes = bytes.to_vec();
    change(&mut bytes[64..]);
    let hash = blake3::Hasher::new().update(&bytes[..32]).update(&bytes[64..]).finalize();
    bytes[32..64].copy_from_slice(hash.as_bytes());
    Btf::from_bytes(bytes)
}

#[test]
fn a_right_checksum_does_not_make_an_index_right() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = written(folder.path());
    let btf = small();
    assert!(forged(&bytes, |_| ()).is_ok());
    let words = bytes.len() - 4 * btf.words().len() - 64;
    let layout = btf.layout();
    // Rows of chromas and of colours that do not exist.
    for word in [layout.elevations.offset + 3, layout.chromas] {
        let at = words + 4 * word as usize;
        assert!(forged(&bytes, |body| body[at..at + 4].fill(0xff)).is_err(), "word {word}");
    }
    // Each field of the layout, at its largest.
    for field in 0..36 {
        let result = forged(&bytes, |body| body[4 * field..4 * field + 4].fill(0xff));
        assert!(result.is_err(), "field {field}");
    }
}

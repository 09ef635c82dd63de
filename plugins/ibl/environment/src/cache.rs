//! Lights that were chosen before, on disk.

use std::{
    fs, io,
    path::{Path, PathBuf},
    time::SystemTime,
};

use glam::Vec3;

use crate::{Environment, EnvironmentLight, LightRequest};

/// Of the folder's files the newest so many are kept: 25 MB, if all are of 4096 lights.
const FILES: usize = 256;
/// What the files start with. The number is part of every key: raise it when methods choose otherwise.
const MARK: [u8; 8] = *b"FLIGHT01";
/// Bytes before the lights (mark, key) and after them (hash of all before).
const HEAD: usize = 8 + 32;
const HASH: usize = 32;
/// Bytes of a light: six floats, little-endian.
const LIGHT: usize = 24;

/// A folder with lights that were chosen before, by the content of their map and the request.
///
/// Broken and foreign files are ignored and replaced, and where nothing can be written, nothing is
/// kept: whoever asks gets the same lights anyway.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightCache {
    folder: PathBuf,
}

impl LightCache {
    /// A cache in a folder, which is made when it is needed.
    #[must_use]
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// The cache in the user's folder for such (`~/.cache/farlight/lights` on Linux); `None` where
    /// the system has no such folder.
    #[must_use]
    pub fn of_user() -> Option<Self> {
        Some(Self::new(dirs::cache_dir()?.join("farlight").join("lights")))
    }

    /// The lights of [`Environment::lights`], from disk if they are there, else chosen and kept.
    #[must_use]
    pub fn lights(
        &self,
        environment: &Environment,
        request: &LightRequest,
    ) -> Vec<EnvironmentLight> {
        let key = key(environment, request);
        let path = self.folder.join(format!("{}.lights", &blake3::Hash::from(key).to_hex()[..32]));
        if let Some(lights) = fs::read(&path).ok().and_then(|bytes| decode(&bytes, &key)) {
            return lights;
        }
        let lights = environment.lights(request);
        // Without a cache everything goes on as well.
        let _ = self.keep(&path, &encode(&lights, &key));
        lights
    }

    fn keep(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        // A reader sees the whole file or none.
        let unfinished = path.with_extension(format!("{}.part", std::process::id()));
        let kept = fs::write(&unfinished, bytes).and_then(|()| fs::rename(&unfinished, path));
        if kept.is_err() {
            let _ = fs::remove_file(&unfinished);
        }
        kept?;
        self.forget_oldest()
    }

    fn forget_oldest(&self) -> io::Result<()> {
        let mut files: Vec<(SystemTime, PathBuf)> = fs::read_dir(&self.folder)?
            .filter_map(|entry| {
                let entry = entry.ok()?;
                let ours = ["lights", "part"];
                let path = entry.path();
                let is_ours = ours.iter().any(|e| path.extension().is_some_and(|p| p == *e));
                is_ours.then_some(())?;
                Some((entry.metadata().ok()?.modified().ok()?, path))
            })
            .collect();
        files.sort();
        for (_, path) in files.iter().rev().skip(FILES) {
            fs::remove_file(path)?;
        }
        Ok(())
    }
}

/// Tells maps and requests apart.
fn key(environment: &Environment, request: &LightRequest) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&MARK);
    hasher.update(request.method.to_string().as_bytes());
    hasher.update(&request.count.to_le_bytes());
    hasher.update(&request.seed.to_le_bytes());
    hasher.update(&environment.width().to_le_bytes());
    let mut row = Vec::new();
    for texels in environment.texels().chunks(environment.width().max(1) as usize) {
        row.clear();
        row.extend(texels.iter().flat_map(|texel| texel.to_array()).flat_map(f32::to_le_bytes));
        hasher.update(&row);
    }
    hasher.finalize().into()
}

fn encode(lights: &[EnvironmentLight], key: &[u8; 32]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEAD + lights.len() * LIGHT + HASH);
    bytes.extend(MARK);
    bytes.extend(key);
    for light in lights {
        let floats = light.direction.to_array().into_iter().chain(light.irradiance.to_array());
        bytes.extend(floats.flat_map(f32::to_le_bytes));
    }
    let hash = blake3::hash(&bytes);
    bytes.extend(hash.as_bytes());
    bytes
}

/// `None` for whatever [`encode`] did not write for this key.
fn decode(bytes: &[u8], key: &[u8; 32]) -> Option<Vec<EnvironmentLight>> {
    let (content, hash) = bytes.split_at_checked(bytes.len().checked_sub(HASH)?)?;
    let (head, lights) = content.split_at_checked(HEAD)?;
    let is_ours = head[..8] == MARK && head[8..] == *key;
    if !is_ours || !lights.len().is_multiple_of(LIGHT) || blake3::hash(content).as_bytes() != hash {
        return None;
    }
    let float = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let vector = |b: &[u8]| Vec3::new(float(b), float(&b[4..]), float(&b[8..]));
    let light = |b: &[u8]| EnvironmentLight { direction: vector(b), irradiance: vector(&b[12..]) };
    Some(lights.chunks_exact(LIGHT).map(light).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(value: f32) -> Environment {
        let texels = (0..32).map(|i| Vec3::splat(value + i as f32)).collect();
        Environment::from_equirect(8, 4, texels).unwrap()
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).map(|all| all.map(|entry| entry.unwrap().path()));
        let mut files: Vec<_> = entries.into_iter().flatten().collect();
        files.sort();
        files
    }

    #[test]
    fn lights_come_back_from_disk_and_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let cache = LightCache::new(folder.path().join("deep/lights"));
        let request = LightRequest { count: 20, ..LightRequest::default() };
        let lights = cache.lights(&map(1.0), &request);
        assert_eq!(lights, map(1.0).lights(&request));
        let [file] = &files(&cache.folder)[..] else { panic!("one file") };
        // What is on disk is what is answered: another content with a right hash shows.
        let key = key(&map(1.0), &request);
        let forged = [EnvironmentLight { direction: Vec3::Y, irradiance: Vec3::ONE }];
        fs::write(file, encode(&forged, &key)).unwrap();
        assert_eq!(cache.lights(&map(1.0), &request), forged);
        for (map, request) in [
            (map(2.0), request),
            (map(1.0), LightRequest { seed: 1, ..request }),
            (map(1.0), LightRequest { count: 21, ..request }),
            (map(1.0), LightRequest { method: crate::Method::Regions, ..request }),
        ] {
            assert_eq!(cache.lights(&map, &request), map.lights(&request));
        }
        assert_eq!(files(&cache.folder).len(), 5);
    }

    #[test]
    fn broken_files_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let cache = LightCache::new(folder.path());
        let request = LightRequest { count: 5, ..LightRequest::default() };
        let lights = cache.lights(&map(1.0), &request);
        let file = &files(folder.path())[0];
        let whole = fs::read(file).unwrap();
        for length in 0..whole.len() {
            assert_eq!(decode(&whole[..length], &key(&map(1.0), &request)), None);
        }
        for at in 0..whole.len() {
            let mut broken = whole.clone();
            broken[at] ^= 4;
            assert_eq!(decode(&broken, &key(&map(1.0), &request)), None, "byte {at}");
        }
        fs::write(file, b"nonsense").unwrap();
        assert_eq!(cache.lights(&map(1.0), &request), lights);
        assert_eq!(fs::read(file).unwrap(), whole);
    }

    #[test]
    fn a_folder_that_can_t_be_made_is_no_harm_and_old_files_go() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, b"").unwrap();
        let request = LightRequest { count: 2, ..LightRequest::default() };
        let cache = LightCache::new(&file);
        assert_eq!(cache.lights(&map(1.0), &request), map(1.0).lights(&request));

        let cache = LightCache::new(folder.path());
        for seed in 0..FILES as u64 + 5 {
            let _ = cache.lights(&map(1.0), &LightRequest { seed, ..request });
        }
        assert_eq!(files(folder.path()).len(), FILES + 1, "a foreign file stays");
        assert!(file.exists());
    }
}

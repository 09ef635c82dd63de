//! Result files.

use std::{
    fs,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
};

use farlight_gi_solver::{probe::ProbeLight, receiver::ReceiverLight, sh::ShRgb};
use serde::Serialize;

use crate::error::CliError;

/// Everything that was asked for, in the same order.
#[derive(Serialize)]
pub(crate) struct Output {
    surface: Vec<Surface>,
    probes: Vec<Probe>,
    visibility: Vec<u8>,
}

#[derive(Serialize)]
struct Surface {
    direct: [f32; 3],
    indirect: [f32; 3],
    indirect_se: [f32; 3],
    indirect_one_bounce: [f32; 3],
    indirect_one_bounce_se: [f32; 3],
}

#[derive(Serialize)]
struct Probe {
    sh: [[f32; 3]; 9],
    sh_se: [[f32; 3]; 9],
}

impl Output {
    /// Fails where a number is not finite: JSON can't hold it.
    pub(crate) fn new(
        receivers: &[ReceiverLight],
        probes: &[ProbeLight],
        visibility: Vec<bool>,
    ) -> Result<Self, CliError> {
        let not_finite = |what: &str, i: usize| {
            CliError::new(format!(
                "{what}[{i}]: the result is not a finite number: are the lights, the sky or the \
                 emission extremely bright, or is the point exactly on a light?"
            ))
        };
        let surface: Vec<_> = receivers
            .iter()
            .map(|r| Surface {
                direct: r.direct.mean.into(),
                indirect: r.indirect.mean.into(),
                indirect_se: r.indirect.se.into(),
                indirect_one_bounce: r.one_bounce.mean.into(),
                indirect_one_bounce_se: r.one_bounce.se.into(),
            })
            .collect();
        let finite = |v: &[f32; 3]| v.iter().all(|x| x.is_finite());
        if let Some(i) = surface.iter().position(|s| {
            ![s.direct, s.indirect, s.indirect_se, s.indirect_one_bounce, s.indirect_one_bounce_se]
                .iter()
                .all(finite)
        }) {
            return Err(not_finite("surface", i));
        }
        let coefficients = |sh: &ShRgb| sh.0.map(Into::into);
        let probes: Vec<_> = probes
            .iter()
            .map(|p| Probe { sh: coefficients(&p.indirect), sh_se: coefficients(&p.indirect_se) })
            .collect();
        if let Some(i) = probes.iter().position(|p| !p.sh.iter().chain(&p.sh_se).all(finite)) {
            return Err(not_finite("probes", i));
        }
        Ok(Self { surface, probes, visibility: visibility.into_iter().map(u8::from).collect() })
    }

    /// Finds out whether [`write`](Self::write) will be able to, before hours of work.
    pub(crate) fn check_writable(path: &Path) -> Result<(), CliError> {
        WholeFile::create(path).map(drop)
    }

    /// Writes the file whole or not at all.
    pub(crate) fn write(&self, path: &Path) -> Result<(), CliError> {
        let mut file = WholeFile::create(path)?;
        serde_json::to_writer(&mut file, self)
            .map_err(std::io::Error::from)
            .and_then(|()| file.write_all(b"\n"))
            .map_err(|error| CliError::io(path, "written", &error))?;
        file.finish()
    }
}

/// A file that appears whole or not at all: it is written beside its place and then renamed.
pub(crate) struct WholeFile {
    path: PathBuf,
    part: PathBuf,
    /// None once it is finished.
    file: Option<BufWriter<fs::File>>,
}

impl WholeFile {
    /// Begins to write.
    pub(crate) fn create(path: &Path) -> Result<Self, CliError> {
        if path.is_dir() {
            return Err(CliError::new(format!("{}: is a folder", path.display())));
        }
        if path.exists() && !path.is_file() {
            return Err(CliError::new(format!("{}: is not a file", path.display())));
        }
        let part = part_of(path)?;
        let file =
            fs::File::create(&part).map_err(|error| CliError::io(path, "written", &error))?;
        Ok(Self { path: path.to_owned(), part, file: Some(BufWriter::new(file)) })
    }

    /// Puts the file in its place.
    pub(crate) fn finish(mut self) -> Result<(), CliError> {
        let Some(file) = self.file.take() else { return Ok(()) };
        let written = file
            .into_inner()
            .map_err(std::io::IntoInnerError::into_error)
            .and_then(|file| file.sync_all())
            .and_then(|()| fs::rename(&self.part, &self.path));
        written.map_err(|error| {
            // Best effort: the error that matters is the first one.
            let _ = fs::remove_file(&self.part);
            CliError::io(&self.path, "written", &error)
        })
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.file.as_mut().map_or(Ok(0), |file| file.write(bytes))
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Drop for WholeFile {
    fn drop(&mut self) {
        if self.file.take().is_some() {
            let _ = fs::remove_file(&self.part);
        }
    }
}

/// The file beside `path` that a result is written into first.
fn part_of(path: &Path) -> Result<PathBuf, CliError> {
    let Some(name) = path.file_name() else {
        return Err(CliError::new(format!("{}: is not a file name", path.display())));
    };
    let mut part = name.to_owned();
    part.push(format!(".part{}", std::process::id()));
    Ok(path.with_file_name(part))
}

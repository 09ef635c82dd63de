//! The result file.

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
        if path.is_dir() {
            return Err(CliError::new(format!("{}: is a folder", path.display())));
        }
        let part = part_of(path)?;
        fs::File::create(&part)
            .and_then(|_| fs::remove_file(&part))
            .map_err(|error| CliError::io(path, "written", &error))
    }

    /// Writes the file whole or not at all: into a file beside it that is then renamed.
    pub(crate) fn write(&self, path: &Path) -> Result<(), CliError> {
        let part = part_of(path)?;
        let written = (|| {
            let mut file = BufWriter::new(fs::File::create(&part)?);
            serde_json::to_writer(&mut file, self)?;
            file.write_all(b"\n")?;
            file.into_inner().map_err(std::io::IntoInnerError::into_error)?.sync_all()?;
            fs::rename(&part, path)
        })();
        written.map_err(|error: std::io::Error| {
            // Best effort: the error that matters is the first one.
            let _ = fs::remove_file(&part);
            CliError::io(path, "written", &error)
        })
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

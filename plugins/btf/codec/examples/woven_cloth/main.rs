//! Makes the cloth of `assets/materials/cloth.fbtf`: a twill of indigo and ecru yarns, path-traced
//! and compressed.
//!
//! ```text
//! cargo run --release -p farlight_btf_codec --example woven_cloth -- --out cloth.fbtf
//! ```

mod fibre;
mod measure;
mod sheet;
mod transport;
mod weave;

use std::fmt::Display;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::str::FromStr;
use std::time::Instant;

use farlight_btf_codec::{
    Info,
    compress::{Grid, Quality, Settings, TexelSource, compress},
};
use glam::Vec3;

use measure::{Lights, Value};
use transport::Cloth;
use weave::{Mesh, Weave};

/// Texels on each side.
const TEXELS: usize = 64;
/// Linear albedos of the yarns: indigo and ecru.
const COLOURS: [Vec3; 2] = [Vec3::new(0.013, 0.036, 0.125), Vec3::new(0.72, 0.60, 0.42)];
const SEED: u64 = 7;

/// Width of the tile in metres: eight yarns.
const SIZE: f32 = 0.012;

const HELP: &str = "\
woven_cloth [OPTIONS]

  --out      the compressed cloth
  --sheet    a picture of the cloth from a few directions, before it is compressed
  --samples  lines of sight a texel and view (40)
  --error    root mean square error that a texel may have, in 1 of 255 (9.2)
  --bytes    instead of an error, the size of the compressed cloth
  --passes   passes of the compressor (4)
  --raw      keep what was traced in this file, and take it from there if it exists
";

struct Options {
    out: Option<PathBuf>,
    sheet: Option<PathBuf>,
    raw: Option<PathBuf>,
    samples: u32,
    quality: Quality,
    passes: u32,
}

impl Options {
    fn read(mut args: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut options = Self {
            out: None,
            sheet: None,
            raw: None,
            samples: 40,
            quality: Quality::Error(9.2),
            passes: 4,
        };
        while let Some(name) = args.next() {
            let value = match name.as_str() {
                "--out" | "--sheet" | "--raw" | "--samples" | "--bytes" | "--error"
                | "--passes" => args.next().ok_or_else(|| format!("{name} wants a value"))?,
                _ => return Err(format!("there is no option {name}\n\n{HELP}")),
            };
            match name.as_str() {
                "--out" => options.out = Some(value.into()),
                "--sheet" => options.sheet = Some(value.into()),
                "--raw" => options.raw = Some(value.into()),
                "--samples" => options.samples = number(&name, &value, 1, 4096)?,
                "--passes" => options.passes = number(&name, &value, 1, 8)?,
                "--error" => options.quality = Quality::Error(number(&name, &value, 0.1, 100.0)?),
                _ => options.quality = Quality::Bytes(number(&name, &value, 1, usize::MAX)?),
            }
        }
        Ok(options)
    }
}

fn number<T>(name: &str, value: &str, least: T, most: T) -> Result<T, String>
where
    T: FromStr + PartialOrd + Display,
{
    let parsed = value.parse().ok().filter(|number| (&least..=&most).contains(&number));
    parsed.ok_or_else(|| format!("{name} {value}: {least} to {most} are possible"))
}

fn main() -> ExitCode {
    if std::env::args().any(|arg| arg == "--help") {
        print!("{HELP}");
        return ExitCode::SUCCESS;
    }
    match Options::read(std::env::args().skip(1)).and_then(|options| run(&options)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("woven_cloth: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), String> {
    let start = Instant::now();
    let weave = Weave::new(SEED, COLOURS);
    let mesh = Mesh::new(&weave, 160, 28);
    let cloth = Cloth::new(weave, mesh, SEED);
    let grid = Grid::default();
    println!("yarns after {:.1?}", start.elapsed());
    if let Some(path) = &options.sheet {
        sheet::write(path, &cloth, &grid, TEXELS, options.samples)?;
        println!("{} after {:.1?}", path.display(), start.elapsed());
    }
    let values = match &options.raw {
        Some(path) if path.exists() => read(path, TEXELS * TEXELS * grid.samples())?,
        _ => trace(&cloth, &grid, options.samples, start),
    };
    if let Some(path) = options.raw.as_ref().filter(|path| !path.exists()) {
        std::fs::write(path, bytemuck::cast_slice(&values))
            .map_err(|error| format!("{}: {error}", path.display()))?;
    }
    let mut cloth = Traced { values, grid };
    let settings = Settings { quality: options.quality, passes: options.passes };
    let found = compress(&mut cloth, &settings, &mut |_| ControlFlow::Continue(()));
    let found = found.map_err(|error| error.to_string())?.ok_or("stopped")?;
    println!("compressed after {:.1?}: {:#?}", start.elapsed(), found.report);
    println!("{:.2} dB, 1 : {:.0}", found.report.psnr(), found.report.ratio());
    let info = Info {
        name: "cloth".to_owned(),
        source: "made: a path-traced twill of indigo and ecru yarns (examples/woven_cloth of farlight_btf_codec)".to_owned(),
        size: Some([SIZE; 2]),
        // Samples at 90 degrees hold what is at 84.
        light_limit: Some(84.0),
        ..Info::default()
    };
    let btf = found.into_btf(info).map_err(|error| error.to_string())?;
    if let Some(path) = &options.out {
        btf.write(path).map_err(|error| error.to_string())?;
        println!("{} after {:.1?}", path.display(), start.elapsed());
    }
    Ok(())
}

/// What was traced, as the compressor wants it.
struct Traced {
    values: Vec<Value>,
    grid: Grid,
}

impl TexelSource for Traced {
    fn size(&self) -> [u32; 2] {
        [TEXELS as u32; 2]
    }

    fn grid(&self) -> Grid {
        self.grid
    }

    fn texel(&self, x: u32, y: u32, samples: &mut [[f32; 3]]) {
        let at = (y as usize * TEXELS + x as usize) * samples.len();
        for (sample, value) in samples.iter_mut().zip(&self.values[at..]) {
            *sample = value.map(|channel| f32::from(channel) / measure::STEPS);
        }
    }
}

/// All views: for each texel its samples, in the order of the grid.
fn trace(cloth: &Cloth, grid: &Grid, samples: u32, start: Instant) -> Vec<Value> {
    let mut values = vec![Value::default(); TEXELS * TEXELS * grid.samples()];
    let slice = grid.alpha * grid.beta;
    let half = grid.phi / 2;
    for phi in 0..half {
        let mut lights = Lights::new(cloth, grid, phi);
        for phi in [phi, phi + half] {
            for theta in 0..grid.theta {
                let view = measure::view(cloth, grid, &lights, [phi, theta], TEXELS, samples);
                let at = grid.index(phi, theta, 0, 0);
                let texels = values.chunks_exact_mut(grid.samples());
                for (texel, view) in texels.zip(view.chunks_exact(slice)) {
                    texel[at..at + slice].copy_from_slice(view);
                }
            }
            lights = lights.opposite();
        }
        println!("{} of {half} azimuths after {:.1?}", phi + 1, start.elapsed());
    }
    values
}

fn read(path: &Path, count: usize) -> Result<Vec<Value>, String> {
    let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let values: Vec<Value> = bytemuck::pod_collect_to_vec(&bytes);
    (values.len() == count)
        .then_some(values)
        .ok_or_else(|| format!("{}: not as long as it should be", path.display()))
}

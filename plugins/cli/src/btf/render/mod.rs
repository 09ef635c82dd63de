//! `farlight btf render`: a picture of a material, without an engine.

mod environment;
mod object;
mod shade;

use std::io::{Cursor, Write};
use std::ops::Range;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use farlight_btf_codec::srgb_encode;
use glam::{Vec2, Vec3};

use self::environment::Environment;
use self::object::{Ray, Shape};
use self::shade::{Blocks, Shader, Sun};
use super::Source;
use crate::error::CliError;
use crate::output::WholeFile;
use crate::progress;

/// Render a picture of a material on an object
///
/// A pixel shows L = E / pi * linear(v) for each light, where E is the irradiance across the light's
/// direction, in units of pi: a white Lambertian surface that faces a light of strength 1 comes out
/// white. Texels are interpolated in linear light. The same seed gives the same picture on any number
/// of threads.
///
/// Azimuth 0 is in front of the object, 90 on its right; elevation 90 is above it.
#[derive(clap::Args)]
#[command(after_help = materials!())]
pub(crate) struct Args {
    #[command(flatten)]
    source: Source,
    /// The picture, sRGB
    #[arg(long, value_name = "X.png")]
    out: PathBuf,
    /// What carries the material
    #[arg(long, value_enum, default_value = "sphere")]
    object: Shape,
    /// Direction to a light in degrees and its strength (1 if not given); may be given several times.
    /// Without lights and environment there is one at 35,40
    #[arg(long = "light", value_name = "AZ,EL[,E]", value_parser = parse_sun, allow_hyphen_values = true)]
    lights: Vec<Sun>,
    /// Direction from the object to the camera, in degrees
    #[arg(long, value_name = "AZ,EL", default_value = "15,15", value_parser = parse_view, allow_hyphen_values = true)]
    view: Vec2,
    /// Light from everywhere: an equirectangular picture, .hdr, whose centre is behind the object
    #[arg(long, value_name = "FILE.hdr")]
    environment: Option<PathBuf>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "800x800", value_parser = parse_size)]
    size: [u32; 2],
    /// How often the picture of the material repeats over two units of length (the plane's side); if
    /// not given, so that a texel covers about a pixel. Objects that close on themselves round it
    #[arg(long, value_name = "N", value_parser = parse_repeat)]
    repeat: Option<f32>,
    /// Samples a pixel
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=1 << 16))]
    samples: u32,
    /// Exposure: the picture gets 2^EV times as bright
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = parse_number, allow_hyphen_values = true)]
    exposure: f32,
    /// Seed of all random numbers
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
}

/// Most pixels of a picture: 2^27.
const MOST_PIXELS: u64 = 1 << 27;

fn parse_number(text: &str) -> Result<f32, String> {
    let number: f32 = text.trim().parse().map_err(|_| format!("{text:?} is not a number"))?;
    if number.is_finite() { Ok(number) } else { Err(format!("{text:?} is not finite")) }
}

fn parse_numbers(text: &str) -> Result<Vec<f32>, String> {
    text.split(',').map(parse_number).collect()
}

fn parse_view(text: &str) -> Result<Vec2, String> {
    match parse_numbers(text)?[..] {
        [azimuth, elevation] if elevation.abs() <= 90.0 => Ok(Vec2::new(azimuth, elevation)),
        [_, _] => Err("the elevation must be -90 to 90 degrees".to_owned()),
        _ => Err("must be two numbers, AZ,EL".to_owned()),
    }
}

fn parse_sun(text: &str) -> Result<Sun, String> {
    let numbers = parse_numbers(text)?;
    let (azimuth, elevation, strength) = match numbers[..] {
        [azimuth, elevation] => (azimuth, elevation, 1.0),
        [azimuth, elevation, strength] => (azimuth, elevation, strength),
        _ => return Err("must be two or three numbers, AZ,EL[,E]".to_owned()),
    };
    if elevation.abs() > 90.0 {
        return Err("the elevation must be -90 to 90 degrees".to_owned());
    }
    if strength < 0.0 {
        return Err("the strength must not be negative".to_owned());
    }
    Ok(Sun { direction: direction(azimuth, elevation), strength })
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let error = || format!("{text:?} is not WxH, such as 800x600");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(error)?;
    let size = [width, height].map(|side| side.trim().parse::<u32>().unwrap_or(0));
    if size.contains(&0) {
        return Err(error());
    }
    if u64::from(size[0]) * u64::from(size[1]) > MOST_PIXELS {
        return Err(format!("more than {MOST_PIXELS} pixels"));
    }
    Ok(size)
}

fn parse_repeat(text: &str) -> Result<f32, String> {
    let repeat = parse_number(text)?;
    if (1e-3..=1e4).contains(&repeat) {
        Ok(repeat)
    } else {
        Err("must be 0.001 to 10000".to_owned())
    }
}

/// The unit vector of an azimuth and an elevation in degrees.
fn direction(azimuth: f32, elevation: f32) -> Vec3 {
    let (sin, cos) = azimuth.to_radians().sin_cos();
    let (up, out) = elevation.to_radians().sin_cos();
    Vec3::new(sin * out, up, cos * out)
}

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let start = Instant::now();
    let mut out = WholeFile::create(&args.out)?;
    let material = args.source.open()?;
    args.source.warn(material.info());
    let environment = args.environment.as_deref().map(Environment::read).transpose()?;
    let mut suns = args.lights.clone();
    if suns.is_empty() && environment.is_none() {
        suns.push(Sun { direction: direction(35.0, 40.0), strength: 1.0 });
    }
    let camera = Camera::new(args);
    let shader = Shader::new(material, args.object, environment, suns, |columns| {
        args.repeat.unwrap_or_else(|| camera.pixels_over_two_units() / columns).max(0.001)
    });

    let [width, height] = args.size.map(|side| side as usize);
    let bar = progress::bar(height as u64, "{human_pos} of {human_len} rows");
    let scale = args.exposure.exp2();
    let bytes = in_blocks(height, shader.block(&camera, args.samples), |rows| {
        let count = rows.len() as u64;
        let light = shader.rows(&camera, rows, args.samples, args.seed)?;
        bar.inc(count);
        Ok(light.into_iter().flat_map(|light| encoded(light * scale)).collect())
    })?;
    bar.finish_and_clear();
    let picture = image::RgbImage::from_raw(width as u32, height as u32, bytes)
        .ok_or_else(|| CliError::new("the picture is incomplete"))?;
    let mut png = Cursor::new(Vec::new());
    picture
        .write_to(&mut png, image::ImageFormat::Png)
        .map_err(|e| CliError::new(format!("{}: {e}", args.out.display())))?;
    out.write_all(png.get_ref()).map_err(|e| CliError::io(&args.out, "written", &e))?;
    out.finish()?;
    println!(
        "{}: {width} x {height} pixels, {} samples each; {:.1} s",
        args.out.display(),
        args.samples,
        start.elapsed().as_secs_f64()
    );
    Ok(())
}

/// Does `work` for blocks of so many rows on as many threads, and joins what it returns.
fn in_blocks(
    height: usize,
    Blocks { rows, threads }: Blocks,
    work: impl Fn(Range<usize>) -> Result<Vec<u8>, CliError> + Sync,
) -> Result<Vec<u8>, CliError> {
    let done = Mutex::new((0..height.div_ceil(rows)).map(|_| Ok(Vec::new())).collect::<Vec<_>>());
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let block = next.fetch_add(1, Ordering::Relaxed);
                    let from = block.saturating_mul(rows);
                    if from >= height {
                        return;
                    }
                    let bytes = work(from..(from + rows).min(height));
                    if bytes.is_err() {
                        // No one need begin another.
                        next.store(height, Ordering::Relaxed);
                    }
                    done.lock().unwrap_or_else(PoisonError::into_inner)[block] = bytes;
                }
            });
        }
    });
    let blocks = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(blocks.into_iter().collect::<Result<Vec<_>, _>>()?.concat())
}

/// Linear light as 8-bit sRGB.
fn encoded(light: Vec3) -> [u8; 3] {
    light.to_array().map(|channel| (srgb_encode(channel.clamp(0.0, 1.0)) * 255.0).round() as u8)
}

/// Looks at the origin.
struct Camera {
    origin: Vec3,
    forward: Vec3,
    /// To the right and upper edge of the picture at distance 1.
    right: Vec3,
    up: Vec3,
    size: Vec2,
}

impl Camera {
    /// Half of the field of view across the shorter side, as a tangent: 14 degrees.
    const HALF_FIELD: f32 = 0.249_328;

    fn new(args: &Args) -> Self {
        let back = direction(args.view.x, args.view.y);
        // Straight above and below, up is where azimuth 180 is.
        let (sin, cos) = args.view.x.to_radians().sin_cos();
        let right = Vec3::new(cos, 0.0, -sin);
        let up = back.cross(right);
        let size = Vec2::new(args.size[0] as f32, args.size[1] as f32);
        let half = size / size.min_element() * Self::HALF_FIELD;
        let sine = Self::HALF_FIELD / Self::HALF_FIELD.hypot(1.0);
        let distance = 1.1 * args.object.radius() / sine;
        let origin = distance * back;
        Self { origin, forward: -back, right: right * half.x, up: up * half.y, size }
    }

    /// Through a place in pixels from the upper left corner.
    fn ray(&self, place: Vec2) -> Ray {
        let at = 2.0 * place / self.size - 1.0;
        let direction = (self.forward + at.x * self.right - at.y * self.up).normalize();
        Ray { origin: self.origin, direction }
    }

    fn pixels_over_two_units(&self) -> f32 {
        self.size.min_element() / (self.origin.length() * Self::HALF_FIELD)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_understood_or_refused() {
        assert_eq!(parse_size("640x480"), Ok([640, 480]));
        assert_eq!(parse_view("-30, 20"), Ok(Vec2::new(-30.0, 20.0)));
        assert!(parse_sun("0,0,2").unwrap().direction.distance(Vec3::Z) < 1e-6);
        assert!(parse_sun("90,0").unwrap().direction.distance(Vec3::X) < 1e-6);
        assert!(parse_sun("0,90").unwrap().direction.distance(Vec3::Y) < 1e-6);
        for bad in ["0", "0,95", "0,0,-1", "a,b", "0,NaN", "1,2,3,4", ""] {
            assert!(parse_sun(bad).is_err(), "{bad}");
        }
        for bad in ["640", "0x3", "x", "99999x99999", "-1x5"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
        assert!(parse_repeat("0").is_err() && parse_repeat("inf").is_err());
    }
}

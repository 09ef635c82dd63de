//! The command line.

use std::path::PathBuf;

use bevy::prelude::*;

use super::program::size;

/// What `--help` prints.
pub const HELP: &str = "\
Shows what `farlight bake` made.

USAGE
    baked [MANIFEST] [OPTIONS]                       in a window; the keys are on screen
    baked [MANIFEST] --headless --out DIR [OPTIONS]  without a window: a picture of each scenario

    MANIFEST is a file NAME.baked.ron (default: the study of assets/baked)

OPTIONS
    --scenario NAME   only this one (default: the first in a window, each in pictures)
    --eye X,Y,Z       where the camera is, in metres (default: 1.6 m above the middle of the scene)
    --target X,Y,Z    what it looks at (default: along -z)
    --fov DEGREES     height of the view, 10 to 150 (default 60)
    --ev100 N         exposure of the camera, -10 to 20 (default 10; 1 more is half as bright)
    --bicubic         smoother lightmaps
    --size WxH        of the pictures (default 640x360) or the window (default 1280x720)
    --headless        no window
    --out DIR         where the pictures go; made if it is missing
    -h, --help        this text

EXIT STATUS
    0 done; 1 something could not be read or drawn; 2 the command line is wrong
";

/// What the program is asked to do.
#[derive(Resource, Clone, Debug)]
pub struct Args {
    /// Print [`HELP`].
    pub help: bool,
    /// Path of the manifest.
    pub manifest: String,
    /// What to show.
    pub scenario: Option<String>,
    /// Where the camera is.
    pub eye: Option<Vec3>,
    /// What it looks at.
    pub target: Option<Vec3>,
    /// Height of the view in degrees.
    pub fov: f32,
    /// Exposure.
    pub ev100: f32,
    /// Whether lightmaps are filtered by splines.
    pub bicubic: bool,
    /// Size of pictures or window.
    pub size: (u32, u32),
    /// Where pictures go; none opens a window.
    pub out: Option<PathBuf>,
}

impl Args {
    /// Reads the arguments, the program's name left out.
    pub fn parse(arguments: impl IntoIterator<Item = String>) -> Result<Self, String> {
        let mut args = Self {
            help: false,
            manifest: String::new(),
            scenario: None,
            eye: None,
            target: None,
            fov: 60.0,
            ev100: 10.0,
            bicubic: false,
            size: (0, 0),
            out: None,
        };
        let mut headless = false;
        let mut arguments = arguments.into_iter();
        while let Some(name) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{name} needs a value"));
            match name.as_str() {
                "-h" | "--help" => return Ok(Self { help: true, ..args }),
                "--scenario" => args.scenario = Some(value()?),
                "--eye" => args.eye = Some(point(&name, &value()?)?),
                "--target" => args.target = Some(point(&name, &value()?)?),
                "--fov" => args.fov = range(&name, &value()?, 10.0, 150.0)?,
                "--ev100" => args.ev100 = range(&name, &value()?, -10.0, 20.0)?,
                "--bicubic" => args.bicubic = true,
                "--size" => args.size = size(&value()?, 16..=4096)?,
                "--headless" => headless = true,
                "--out" => args.out = Some(PathBuf::from(value()?)),
                other if other.starts_with('-') || !args.manifest.is_empty() => {
                    return Err(format!("{other}: unknown; --help lists what there is"));
                }
                // The person at the keyboard names files from where they are.
                manifest => args.manifest = absolute(manifest),
            }
        }
        if args.manifest.is_empty() {
            args.manifest = "baked/study/study.baked.ron".into();
            args.eye = args.eye.or(Some(Vec3::new(2.25, 1.55, 1.75)));
            args.target = args.target.or(Some(Vec3::new(-0.7, 0.85, -1.0)));
        }
        if args.size == (0, 0) {
            args.size = if headless { (640, 360) } else { (1280, 720) };
        }
        match (headless, &args.out) {
            (true, None) => Err("--headless needs --out DIR".into()),
            (false, Some(_)) => Err("--out goes with --headless".into()),
            _ => Ok(args),
        }
    }
}

fn absolute(path: &str) -> String {
    std::path::absolute(path).map_or_else(|_| path.to_owned(), |path| path.display().to_string())
}

fn point(name: &str, text: &str) -> Result<Vec3, String> {
    let wrong = || format!("{name} {text}: not three numbers X,Y,Z");
    let numbers: Result<Vec<f32>, _> = text.split(',').map(str::parse).collect();
    match numbers.map_err(|_| wrong())?[..] {
        [x, y, z] if Vec3::new(x, y, z).is_finite() => Ok(Vec3::new(x, y, z)),
        _ => Err(wrong()),
    }
}

fn range(name: &str, text: &str, least: f32, most: f32) -> Result<f32, String> {
    let number = text.parse().ok().filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| format!("{name} {text}: not a number from {least} to {most}"))
}

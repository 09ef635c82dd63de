//! The command line.

use std::path::PathBuf;

use super::program::{number, size};

use super::shown::{self, Shown};

/// What `--help` prints.
pub const HELP: &str = "\
Environment light that refines itself, for every material, with shadows.

USAGE
    progressive_environment [OPTIONS]                       in a window; the keys are on screen
    progressive_environment --headless --out DIR [OPTIONS]  without a window: pictures as PNG files

OPTIONS
    --environment NAME  studio, sky, interior, overcast, evening, or a file (.hdr, .exr, .ktx2);
                        may be given several times (default: all five)
    --lights N          directional lights that stand for the map, 1 to 4096 (default 200)
    --per-frame K       how many of them shine in a frame, 1 to 10 (default 5)
    --method NAME       how they are chosen: independent, stratified, regions, centroids
    --no-shadows        without shadows
    --size WxH          of the pictures (default 640x360) or of the window, 16 to 4096 a side
    --headless          no window. Writes into DIR, for each environment:
                          NAME-refined.png      all its lights
                          NAME-image-based.png  Bevy's image-based light of the same map
                        and of the first one:
                          refining.png          1, 5, 20 and 40 frames beside each other
                          sway.png              a frame while the camera sways
                          dots.png              the lights on the sky, with ring and map
    --out DIR           where the pictures go; made if it is missing
    --turntable N       instead of these: N refined pictures round the scene, 1 to 1000, of the first
                        environment: turn_000.png, ...
    -h, --help          this text

EXAMPLES
    cargo run --example progressive_environment
    cargo run --example progressive_environment -- --headless --out pictures --lights 1000
    cargo run --example progressive_environment -- --headless --out turn --turntable 24 --environment sky

EXIT STATUS
    0 done; 1 something could not be read or drawn; 2 the command line is wrong
";

/// What the program is asked to do.
#[derive(Clone, Debug)]
pub struct Args {
    /// Print [`HELP`].
    pub help: bool,
    /// What is shown first.
    pub shown: Shown,
    /// Size of pictures or window.
    pub size: Option<(u32, u32)>,
    /// Where pictures go; none opens a window.
    pub out: Option<PathBuf>,
    /// Pictures of a turn.
    pub turntable: Option<u32>,
}

impl Args {
    /// Reads the arguments, the program's name left out.
    pub fn parse(arguments: impl IntoIterator<Item = String>) -> Result<Self, String> {
        let mut args =
            Self { help: false, shown: Shown::default(), size: None, out: None, turntable: None };
        let (mut headless, mut environments) = (false, Vec::new());
        let mut arguments = arguments.into_iter();
        while let Some(name) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{name} needs a value"));
            match name.as_str() {
                "-h" | "--help" => return Ok(Self { help: true, ..args }),
                "--environment" => environments.push(shown::environment(&value()?)?),
                "--lights" => args.shown.lights = number(&name, &value()?, 1, 4096)?,
                "--per-frame" => args.shown.per_frame = number(&name, &value()?, 1, 10)?,
                "--method" => {
                    args.shown.method = value()?.parse().map_err(|e| format!("--method: {e}"))?;
                }
                "--no-shadows" => args.shown.shadows = false,
                "--size" => args.size = Some(size(&value()?, 16..=4096)?),
                "--headless" => headless = true,
                "--out" => args.out = Some(PathBuf::from(value()?)),
                "--turntable" => args.turntable = Some(number(&name, &value()?, 1, 1000)?),
                other => return Err(format!("{other}: unknown; --help lists what there is")),
            }
        }
        if !environments.is_empty() {
            args.shown.environments = environments;
        }
        match (headless, &args.out, args.turntable) {
            (true, None, _) => Err("--headless needs --out DIR".into()),
            (false, Some(_), _) => Err("--out goes with --headless".into()),
            (false, None, Some(_)) => Err("--turntable goes with --headless --out DIR".into()),
            _ => Ok(args),
        }
    }
}

//! What the example programs do alike: command lines, windows.

#![allow(dead_code, reason = "every example uses its own part")]

use std::{
    fmt::Display,
    ops::RangeInclusive,
    path::{Path, PathBuf},
    process::ExitCode,
    str::FromStr,
};

use bevy::{
    app::PluginGroupBuilder, asset::UnapprovedPathMode, prelude::*, window::WindowResolution,
};

/// The repository's folder of all asset files.
pub fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets")
}

/// Bevy's plugins with a window; `outside` says whether files may lie outside of [`assets`].
pub fn in_window(
    title: &str,
    size: impl Into<WindowResolution>,
    outside: UnapprovedPathMode,
) -> PluginGroupBuilder {
    DefaultPlugins
        .set(AssetPlugin {
            file_path: assets().display().to_string(),
            unapproved_path_mode: outside,
            ..default()
        })
        .set(WindowPlugin {
            primary_window: Some(Window {
                title: title.into(),
                resolution: size.into(),
                ..default()
            }),
            ..default()
        })
}

/// Runs an app until it is closed.
pub fn until_closed(mut app: App) -> Result<(), String> {
    match app.run() {
        AppExit::Success => Ok(()),
        AppExit::Error(code) => Err(format!("the app exited with code {code}")),
    }
}

/// Runs a program: prints its help, or what was wrong with its command line (exit status 2) or went
/// wrong later (1).
pub fn run<A>(
    name: &str,
    args: Result<A, String>,
    wants_help: impl FnOnce(&A) -> bool,
    help: &str,
    run: impl FnOnce(A) -> Result<(), String>,
) -> ExitCode {
    let (message, status) = match args {
        Ok(args) if wants_help(&args) => {
            print!("{help}");
            return ExitCode::SUCCESS;
        }
        Ok(args) => match run(args) {
            Ok(()) => return ExitCode::SUCCESS,
            Err(message) => (message, ExitCode::FAILURE),
        },
        Err(message) => (message, ExitCode::from(2)),
    };
    eprintln!("{name}: {message}");
    status
}

/// A whole number.
pub fn number<T: FromStr + PartialOrd + Display>(
    name: &str,
    text: &str,
    min: T,
    max: T,
) -> Result<T, String> {
    match text.parse() {
        Ok(value) if (&min..=&max).contains(&&value) => Ok(value),
        _ => Err(format!("{name} {text}: not a whole number from {min} to {max}")),
    }
}

/// Width and height in pixels: `640x480`.
pub fn size(text: &str, sides: RangeInclusive<u32>) -> Result<(u32, u32), String> {
    let side = |text: &str| text.parse().ok().filter(|side| sides.contains(side));
    text.split_once('x').and_then(|(width, height)| Some((side(width)?, side(height)?))).ok_or_else(
        || {
            let (least, most) = (sides.start(), sides.end());
            format!("--size {text}: not WxH with {least} to {most} a side")
        },
    )
}

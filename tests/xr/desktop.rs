//! Without a runtime the program runs on the desktop, and says so once.

use std::process::Command;

use bevy::{prelude::*, render::pipelined_rendering::PipelinedRenderingPlugin, winit::WinitPlugin};
use farlight::{
    prelude::*,
    xr::{XrEye, XrFocus},
};

/// The variable that makes a test process the program.
const IS_PROGRAM: &str = "FARLIGHT_TEST_XR_PROGRAM";

/// The program, run by the test below in a process of its own: there is one log and one environment a
/// process.
#[test]
fn program() {
    if std::env::var_os(IS_PROGRAM).is_none() {
        return;
    }
    let mut app = App::new();
    let plugins = DefaultPlugins
        .build()
        .set(WindowPlugin {
            primary_window: None,
            exit_condition: bevy::window::ExitCondition::DontExit,
            ..default()
        })
        .disable::<WinitPlugin>()
        // A process that ends while another thread draws may crash in the driver.
        .disable::<PipelinedRenderingPlugin>();
    let xr = FarlightXr::default().switched_by(
        std::env::var("TEST_ARGUMENTS")
            .ok()
            .iter()
            .flat_map(|arguments| arguments.split(' ').map(str::to_owned).collect::<Vec<_>>()),
    );
    app.add_plugins(xr.wrap(plugins));
    app.finish();
    app.cleanup();
    (0..4).for_each(|_| app.update());
    let world = app.world_mut();
    assert_eq!(world.query::<&XrEye>().iter(world).count(), 0);
    assert_eq!(*world.resource::<XrFocus>(), XrFocus(false));
    assert!(world.get_resource::<AssetServer>().is_some(), "everything else is there");
    let XrStatus::Unavailable(reason) = world.resource::<XrStatus>() else {
        panic!("{:?}", world.resource::<XrStatus>());
    };
    println!("reason: {reason}");
}

fn run(environment: &[(&str, &str)]) -> String {
    let mut program = Command::new(std::env::current_exe().unwrap());
    program.args(["desktop::program", "--exact", "--nocapture"]).env(IS_PROGRAM, "1");
    program.env_remove("FARLIGHT_XR").env_remove("RUST_LOG").env("NO_COLOR", "1");
    program.env("XR_RUNTIME_JSON", "/nonexistent/runtime.json");
    program.envs(environment.iter().copied());
    let output = program.output().unwrap();
    let words = crate::support::example::words(&output);
    assert!(output.status.success(), "{words}");
    words
}

#[test]
fn without_a_runtime_it_says_so_once() {
    let words = run(&[]);
    assert_eq!(words.matches("no headset: ").count(), 1, "{words}");
    let complains = |line: &str| line.contains("ERROR") || line.contains("WARN");
    let of_xr = |line: &str| ["xr", "XR"].iter().any(|name| line.contains(name));
    assert!(!words.lines().any(|line| complains(line) && of_xr(line)), "{words}");
    #[cfg(target_os = "linux")]
    assert!(words.contains("reason: XR_RUNTIME_JSON names /nonexistent/runtime.json"), "{words}");
}

#[test]
fn it_can_be_switched_off() {
    let words = run(&[("FARLIGHT_XR", "off")]);
    assert!(words.contains("reason: it is switched off by FARLIGHT_XR=off"), "{words}");
    let words = run(&[("TEST_ARGUMENTS", "--window --xr off")]);
    assert!(words.contains("reason: it is switched off by --xr off"), "{words}");
    assert_eq!(words.matches("no headset: ").count(), 1, "{words}");
}

//! The network's plots, with a lighting server that answers.

use std::time::{Duration, Instant};

use bevy::prelude::*;
use farlight::{LinkHistory, controls::UserFile, panel::PanelSettings, prelude::*};
use farlight_wire::simulated::{LinkConditions, Network};

use crate::{
    clock::{Clock, TOKEN},
    game,
    stage::{Stage, controls},
    support::headless::Picture,
};

/// Where lines of plots are: for each plot, from above, in how many columns of pixels there is something
/// of it.
fn plots(picture: &Picture) -> Vec<usize> {
    let is_line = |pixel: [u8; 3]| {
        let [red, green, blue] = pixel.map(u32::from);
        // Thin lines are mixed with what is behind them.
        red > 90 && red > blue + 50 && red > green && green > blue
    };
    let row = |y: u32| {
        let pixels =
            (0..picture.width).map(move |x| (x, picture.pixels[(y * picture.width + x) as usize]));
        pixels.filter(move |(_, pixel)| is_line(*pixel)).map(|(x, _)| x)
    };
    let mut found: Vec<std::collections::BTreeSet<u32>> = Vec::new();
    let mut free = u32::MAX;
    for y in 0..picture.height {
        let columns: Vec<_> = row(y).collect();
        if columns.is_empty() {
            free = free.saturating_add(1);
            continue;
        }
        // A plot is 44 points high; between two are a title and more.
        if free > 25 {
            found.push(std::collections::BTreeSet::new());
        }
        free = 0;
        if let Some(plot) = found.last_mut() {
            plot.extend(columns);
        }
    }
    found.iter().map(std::collections::BTreeSet::len).collect()
}

#[test]
fn a_server_that_answers_is_plotted() {
    let network = Network::new(1);
    let delay = Duration::from_millis(4);
    network.set_conditions(LinkConditions { delay, ..Default::default() });
    let clock = Clock::new(&network);
    let server = clock.serve();
    let connector = network.connector();
    let gi = GiPlugin::with_backend(move |gi| {
        let (connector, remote) = (Box::new(connector.clone()), RemoteSettings::default());
        Box::new(RemoteBackend::new(connector, TOKEN, &remote, gi.session()))
    });
    let plugins = FarlightPlugins.set(controls(UserFile::Nowhere)).set(gi);
    let settings = PanelSettings { hint: false, ..default() };
    let mut stage = Stage::with(UVec2::new(960, 800), settings, plugins);
    stage.world().insert_resource(game::settings());
    let (_, lamp) = game::furnish(stage.world());
    let mut state = stage.world().resource_mut::<PanelState>();
    (state.menu, state.unfold) = (true, Some("Network"));

    let start = Instant::now();
    let mut frame = 0.0_f32;
    let known = |values: &mut dyn Iterator<Item = f64>| {
        values.filter(|value| value.is_finite() && *value > 0.0).count()
    };
    loop {
        // Light goes on coming.
        frame += 1.0;
        let place = Vec3::new(2.0 + (0.1 * frame).sin(), 1.5, 2.0);
        stage.world().get_mut::<Transform>(lamp).unwrap().translation = place;
        stage.frames(1);
        let history = stage.world().resource::<LinkHistory>();
        let counts = [
            known(&mut history.latency()),
            known(&mut history.bandwidth()),
            known(&mut history.error()),
        ];
        if counts.iter().all(|count| *count >= 12) {
            break;
        }
        assert!(start.elapsed() < Duration::from_secs(100), "{counts:?}: {history:?}");
    }
    let history = stage.world().resource::<LinkHistory>();
    let least = history.latency().filter(|value| value.is_finite()).fold(f64::MAX, f64::min);
    assert!(least >= 8.0, "{least} ms there and back, through two delays of 4 ms");
    let picture = stage.picture("network.png");
    let lines = plots(&picture);
    assert!(lines.len() == 3 && lines.iter().all(|columns| *columns >= 15), "{lines:?}");
    drop((stage, server));
}

//! Light comes back soon after the line was cut.

use std::time::Duration;

use farlight::gi::{BackendState, LightingBackend};
use farlight_wire::simulated::LinkConditions;

use crate::{
    scene::{Locals, lamp},
    stage::{MS, Stage, bad_line},
};

/// After this the light must be right again. One packet in twenty is lost, so nothing is certain:
/// one of 4500 outages took 1.48 s, one in a thousand over 1.2 s.
const DEADLINE: Duration = Duration::from_millis(1500);
/// After this it must be so without any exception.
const PATIENCE: Duration = Duration::from_secs(3);
/// What is right: mean difference from what a local session shows after it has converged.
const RIGHT: f32 = 0.05;
/// What is clearly wrong.
const WRONG: f32 = 0.25;

#[test]
fn light_is_what_a_local_session_shows() {
    let mut locals = Locals::default();
    assert!(locals.get(0.0).clone().error(locals.get(1.0)) > WRONG, "the lights differ");
    for conditions in [Default::default(), bad_line()] {
        let mut stage = Stage::new(1, conditions);
        stage.submit_room(0.25);
        stage.settle();
        let error = stage.picture.error(locals.get(0.25));
        assert!(error < 2e-3, "{error}");
    }
}

/// Cuts the line for a while, again and again, while the light moves. Answers how long it took each
/// time until the light was right again, and how often the connection was replaced.
fn outages(seed: u64, conditions: LinkConditions, locals: &mut Locals) -> (Vec<Duration>, u64) {
    let mut stage = Stage::new(seed, conditions);
    stage.submit_room(0.0);
    stage.settle();
    let (mut phase, mut all) = (0.0, Vec::new());
    for outage in [500 * MS, 2000 * MS, 5000 * MS] {
        // The light moves before, during and up to the end of the outage.
        let goal = 1.0 - phase;
        let (frames, frame) = (((outage + 300 * MS).as_millis() / 50) as u32, 50 * MS);
        let cut = stage.now() + 300 * MS;
        for i in 1..=frames {
            if stage.now() >= cut {
                stage.network.set_down(true);
            }
            let progress = i as f32 / frames as f32;
            stage.submit(vec![lamp(phase + (goal - phase) * progress)]);
            stage.run(frame);
        }
        phase = goal;
        let right = locals.get(phase);
        let before = stage.picture.error(right);
        assert!(before > 2.0 * RIGHT, "seed {seed}: the outage did no harm: {before}");
        stage.network.set_down(false);
        let mut took = Duration::ZERO;
        while stage.picture.error(right) > RIGHT {
            assert!(
                took <= PATIENCE,
                "seed {seed}, {outage:?} without a line: the error after {took:?} is {}: {stage:?}",
                stage.picture.error(right)
            );
            stage.run(10 * MS);
            took += 10 * MS;
        }
        println!("seed {seed}, {outage:?} without a line: right again after {took:?}");
        all.push(took);
        stage.settle();
        stage.run(Duration::from_secs(12));
        assert_eq!(stage.backend.state(), BackendState::Converged);
    }
    (all, stage.backend.link().unwrap().reconnects)
}

#[test]
fn light_is_right_again_soon_after_an_outage() {
    // More seeds on request, for a wider look.
    let seeds = std::env::var("FARLIGHT_SEEDS").map_or(6, |seeds| seeds.parse().expect("a number"));
    let mut locals = Locals::default();
    let all: Vec<_> =
        (0..seeds).flat_map(|seed| outages(seed, bad_line(), &mut locals).0).collect();
    let late = all.iter().filter(|took| **took > DEADLINE).count();
    println!("right again after {:?} at most", all.iter().max());
    assert!(late <= 1 + all.len() / 1000, "{late} of {} took longer than {DEADLINE:?}", all.len());
}

#[test]
fn a_connection_that_is_stuck_is_replaced() {
    // So little may be under way that nothing new leaves while the line is cut, not even pings: the
    // old connection wakes up late. No real line is so narrow; it may take longer than usual.
    let seeds = std::env::var("FARLIGHT_SEEDS").map_or(4, |seeds| seeds.parse().expect("a number"));
    let mut locals = Locals::default();
    let mut all = 0;
    for seed in 0..seeds {
        let conditions = LinkConditions { window: 3000, ..bad_line() };
        let (took, replaced) = outages(seed, conditions, &mut locals);
        println!("right again after {took:?}, the connection was replaced {replaced} times");
        all += replaced;
    }
    assert!(all > 0, "no connection was stuck");
}

#[test]
fn a_game_that_does_not_poll_misses_nothing_and_piles_nothing_up() {
    let mut locals = Locals::default();
    let mut stage = Stage::new(3, Default::default());
    stage.submit_room(0.0);
    stage.settle();
    stage.polls = false;
    for i in 1..=200 {
        stage.submit(vec![lamp(i as f32 / 200.0)]);
        stage.run(16 * MS);
    }
    stage.run(Duration::from_secs(5));
    stage.polls = true;
    stage.picture.updates = 0;
    stage.run(MS);
    assert!(stage.picture.updates <= 5, "{}", stage.picture.updates);
    assert!(stage.picture.error(locals.get(1.0)) < RIGHT);
    assert_eq!(stage.picture.snapshot, stage.snapshot);
}

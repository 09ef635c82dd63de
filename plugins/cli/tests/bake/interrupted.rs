//! Stopped, killed, two at once.

use std::{
    fs::{self, File},
    path::Path,
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

use crate::{
    folder::{SCENE, bake, baked, checked, command, contents, manifest_path},
    support::{Folder, refused},
};

fn start(out: &Path, more: &[&str]) -> Child {
    command(SCENE, out, more).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// A small generator of numbers below 2^32 (SplitMix).
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z >> 32
}

fn arguments(seed: &str) -> [&str; 10] {
    [
        "--size",
        "64",
        "--samples",
        "256",
        "--probe-spacing",
        "2",
        "--seed",
        seed,
        "--save-every",
        "0.01",
    ]
}

#[test]
fn killed_at_any_moment() {
    let folder = Folder::new("bake-killed");
    let (out, fresh) = (folder.at("out"), folder.at("fresh"));
    let start_of_all = Instant::now();
    baked(&fresh, &arguments("0"));
    // On a busy machine most are killed early, which is as good.
    let mut longest = start_of_all.elapsed().min(Duration::from_secs(2));

    let mut state = 7;
    let (mut seed, mut without, mut with, mut killed) = (0, 0, 0, 0);
    for _ in 0..1000 {
        let mut child = start(&out, &arguments(&seed.to_string()));
        std::thread::sleep(longest.mul_f64(random(&mut state) as f64 / f64::from(u32::MAX)));
        let late = child.try_wait().unwrap().is_some();
        child.kill().unwrap();
        child.wait().unwrap();
        match checked(&out) {
            None => without += 1,
            Some(_) => with += 1,
        }
        if late {
            // Other inputs, so that there is something to do, and to replace. The machine may be
            // faster now than it was.
            seed += 1;
            longest = longest.mul_f64(0.8);
        } else {
            killed += 1;
        }
        if killed == 30 {
            break;
        }
    }
    println!("{killed} killed, {without} without a manifest, {with} with one");
    assert_eq!(killed, 30);

    // In the end it is as if nothing had happened.
    baked(&out, &arguments("1000"));
    assert!(checked(&out).unwrap().complete);
    fs::remove_dir_all(&fresh).unwrap();
    baked(&fresh, &arguments("1000"));
    assert!(contents(&out) == contents(&fresh));
    // Nothing half written either.
    let cache = fs::read_dir(out.join(".bake")).unwrap();
    let parts =
        cache.filter(|e| e.as_ref().unwrap().file_name().to_string_lossy().contains("part"));
    assert_eq!(parts.count(), 0);
}

#[test]
fn stopped_and_taken_up_again() {
    let folder = Folder::new("bake-stopped");
    let (out, fresh) = (folder.at("out"), folder.at("fresh"));
    let long =
        ["--size", "64", "--samples", "65536", "--probe-spacing", "2", "--save-every", "0.01"];
    let mut child = start(&out, &long);
    // Once there are saved rays.
    let end = Instant::now() + Duration::from_secs(60);
    let saved = || {
        let Ok(files) = fs::read_dir(out.join(".bake")) else { return false };
        files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("gather-"))
    };
    while !saved() {
        assert!(Instant::now() < end && child.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(5));
    }
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let message = refused(&child.wait_with_output().unwrap());
    assert!(message.contains("goes on from there"), "{message}");
    let partial = checked(&out).unwrap();
    assert!(!partial.complete);
    let rays = partial.scenarios[0].samples;
    assert!(rays > 0 && rays < 65536 && rays.is_multiple_of(64), "{rays}");

    // The next whole multiple of a pass: quick, and the same as without a stop.
    let samples = (rays + 64).to_string();
    let more = ["--size", "64", "--samples", &samples, "--probe-spacing", "2"];
    // Probes depend on the samples that are asked for: they are compared as well.
    baked(&out, &more);
    assert!(checked(&out).unwrap().complete);
    baked(&fresh, &more);
    assert!(contents(&out) == contents(&fresh));
}

#[test]
fn one_bake_a_folder() {
    let folder = Folder::new("bake-lock");
    let out = folder.at("out");
    fs::create_dir_all(out.join(".bake")).unwrap();
    let lock = File::create(out.join(".bake/lock")).unwrap();
    lock.lock().unwrap();
    fs::write(out.join(".bake/lock"), "4711").unwrap();
    let message = refused(&bake(&out, &["--size", "64", "--samples", "2", "--no-probes"]));
    assert!(message.contains("another bake (process 4711)"), "{message}");
    assert!(!manifest_path(&out).exists());
    // What a dead process left is no lock.
    drop(lock);
    baked(&out, &["--size", "64", "--samples", "2", "--no-probes"]);
}

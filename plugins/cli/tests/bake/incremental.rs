//! What did not change is not baked again.

use std::{fs, time::SystemTime};

use crate::{
    folder::{bake, baked, checked, contents, page},
    support::Folder,
};

const QUICK: [&str; 6] = ["--size", "64", "--samples", "64", "--probe-spacing", "2"];

fn with<'a>(base: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [base, more].concat()
}

#[test]
fn the_second_run_changes_no_file() {
    let folder = Folder::new("bake-second");
    let out = folder.at("out");
    let said = baked(&out, &QUICK);
    assert!(said.contains("11 primitives on 1 page of 64 x 64"), "{said}");
    let manifest = checked(&out).unwrap();
    assert!(manifest.complete);
    assert_eq!(manifest.scenarios[0].samples, 64);
    assert!(manifest.left_out.is_empty());
    // The scene has one lamp, which the lightmap shows.
    let lights = &manifest.scenarios[0].lights;
    assert_eq!((lights.len(), lights[0].node, lights[0].range), (1, Some(4), 20.0));

    let times = || -> Vec<SystemTime> {
        contents(&out)
            .keys()
            .map(|name| fs::metadata(out.join(name)).unwrap().modified().unwrap())
            .collect()
    };
    let (before, when) = (contents(&out), times());
    // The lit scene, manifest, a page twice and a volume.
    assert_eq!(before.len(), 5, "{:?}", before.keys());
    let said = baked(&out, &QUICK);
    assert!(said.contains("nothing changed"), "{said}");
    assert!(contents(&out) == before && times() == when);

    // A file that is gone or damaged comes back as it was.
    let page = &manifest.scenarios[0].pages[0];
    fs::remove_file(out.join(&page.ktx2)).unwrap();
    fs::write(out.join(&page.exr), "damaged").unwrap();
    baked(&out, &QUICK);
    assert!(contents(&out) == before);
    // So does everything, without the cache, or with a damaged one.
    for entry in fs::read_dir(out.join(".bake")).unwrap() {
        fs::write(entry.unwrap().path(), "x").unwrap();
    }
    fs::remove_file(out.join(&page.ktx2)).unwrap();
    let output = bake(&out, &QUICK);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && message.contains("is damaged and ignored"), "{message}");
    assert!(contents(&out) == before);
    fs::remove_dir_all(out.join(".bake")).unwrap();
    baked(&out, &with(&QUICK, &["--force"]));
    assert!(contents(&out) == before);
}

#[test]
fn more_samples_go_on_from_there() {
    let folder = Folder::new("bake-more");
    let (out, fresh) = (folder.at("out"), folder.at("fresh"));
    baked(&out, &QUICK);
    let old = checked(&out).unwrap();
    let more = ["--size", "64", "--samples", "192", "--probe-spacing", "2"];
    baked(&out, &more);
    baked(&fresh, &more);
    assert!(contents(&out) == contents(&fresh));
    let new = checked(&out).unwrap();
    assert_eq!(new.scenarios[0].samples, 192);
    assert!(new.scenarios[0].relative_error < old.scenarios[0].relative_error);
    // Nothing of the old pages is left, nor of what is of no use any more.
    assert_eq!(contents(&out).len(), 5);
    baked(&out, &with(&more, &["--seed", "2"]));
    assert_eq!(contents(&out).len(), 5);
    let kept = |kind: &str| {
        let entries = fs::read_dir(out.join(".bake")).unwrap();
        entries
            .filter(|e| e.as_ref().unwrap().file_name().to_string_lossy().starts_with(kind))
            .count()
    };
    assert_eq!(["gather-", "direct-", "done-", "last-", "probes-"].map(kept), [1; 5]);
}

/// Which files are written and whether noise is filtered are no questions of light.
#[test]
fn what_needs_no_new_light_computes_none() {
    let folder = Folder::new("bake-same-light");
    let out = folder.at("out");
    let computed =
        |said: &str| said.contains("light between surfaces") || said.contains("indirect light");
    let said = baked(&out, &QUICK);
    assert!(computed(&said), "{said}");
    for more in [&["--no-exr"][..], &["--no-exr", "--no-denoise"]] {
        let said = baked(&out, &with(&QUICK, more));
        assert!(!computed(&said), "{said}");
    }
    assert_eq!(contents(&out).len(), 4);
}

#[test]
fn a_changed_scenario_leaves_the_others_alone() {
    let folder = Folder::new("bake-scenarios");
    let out = folder.at("out");
    let file = |lamp: f32| {
        folder.write(
            "rooms.lights.ron",
            &format!(
                "BakeLights(
                    add: [
                        (name: \"lamp\", position: (7, 2.5, 2), intensity: ({lamp}, 60, 50), radius: 0.1),
                        (name: \"torch\", kind: Spot(inner: 10, outer: 30), position: (3, 1.5, 2),
                            direction: (1, 0, 0), intensity: (50, 50, 50), direct: Realtime),
                    ],
                    realtime: [\"point0\"],
                    scenarios: [
                        (name: \"first\", lights: [\"point0\"]),
                        (name: \"lamp on\", lights: [\"lamp\"]),
                        (name: \"all of them\"),
                    ],
                )"
            ),
        )
    };
    let lights = file(70.0);
    let arguments = with(&QUICK, &["--lights", lights.to_str().unwrap(), "--no-denoise"]);
    baked(&out, &arguments);
    let old = checked(&out).unwrap();
    let names: Vec<_> = old.scenarios.iter().map(|scenario| scenario.name.as_str()).collect();
    assert_eq!(names, ["first", "lamp on", "all of them"]);
    let all = &old.scenarios[2].lights;
    assert_eq!(
        all.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(),
        ["point0", "lamp", "torch"]
    );
    assert_eq!((all[1].node, all[1].radius), (None, 0.1));

    file(80.0);
    let said = baked(&out, &arguments);
    let kept: Vec<_> = said.lines().filter(|line| line.contains("as it was")).collect();
    assert!(kept.len() == 1 && kept[0].contains("first"), "{said}");
    let new = checked(&out).unwrap();
    assert_eq!(old.scenarios[0], new.scenarios[0]);
    assert_ne!(old.scenarios[1].pages, new.scenarios[1].pages);

    // A single scenario; the others are up to date, or left out.
    file(90.0);
    baked(&out, &with(&arguments, &["--scenario", "lamp on"]));
    let new = checked(&out).unwrap();
    let names: Vec<_> = new.scenarios.iter().map(|scenario| scenario.name.as_str()).collect();
    assert_eq!(names, ["first", "lamp on"]);
    baked(&out, &arguments);
    assert_eq!(checked(&out).unwrap().scenarios.len(), 3);
}

/// Light adds: two scenarios of one light each make one of both.
#[test]
fn scenarios_are_those_of_their_lights() {
    let folder = Folder::new("bake-sum");
    let lights = folder.write(
        "rooms.lights.ron",
        "BakeLights(
            add: [(name: \"lamp\", position: (7, 2.5, 2), intensity: (70, 60, 50))],
            scenarios: [(name: \"first\", lights: [\"point0\"]), (name: \"lamp\", lights: [\"lamp\"]), (name: \"all\")],
        )",
    );
    let out = folder.at("out");
    baked(&out, &with(&QUICK, &["--lights", lights.to_str().unwrap(), "--no-denoise"]));
    let mut manifest = checked(&out).unwrap();
    let mut means = Vec::new();
    for _ in 0..3 {
        let texels = page(&out, &manifest, 0).texels;
        means.push(texels.iter().map(|texel| texel.y).sum::<f32>() / texels.len() as f32);
        manifest.scenarios.rotate_left(1);
    }
    let [first, lamp, all] = means[..] else { panic!() };
    assert!(first > 0.1 && lamp > 0.1, "{first} {lamp}");
    assert!(((first + lamp) / all - 1.0).abs() < 0.02, "{first} {lamp} {all}");
}

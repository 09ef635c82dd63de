//! Files of bindings and recordings, damaged and random: no panic, memory within bounds, and what is
//! accepted can be checked, explained, written and read again.
//!
//! A brief run of every target is part of the tests; `cargo xtask fuzz` runs longer.

#[path = "../../../../remote/wire/tests/fuzz/memory.rs"]
mod memory;
#[path = "../../../../remote/wire/tests/fuzz/mutate.rs"]
mod mutate;

use farlight_bindings::{
    ActionInfo, ActionKind, Binding, Bindings, Context, Device, Preset, RecordedEvent, Recording,
    defaults_ron, help_text, table,
};
use mutate::fuzz;

/// What a file of bindings and its errors may take: ten times its text, and something to start with.
fn bound(input: &[u8]) -> usize {
    (64 << 10) + 40 * input.len()
}

const OWN: ActionInfo = ActionInfo {
    name: "jump",
    label: "Jump",
    kind: ActionKind::Button,
    context: Context::Scene,
    unit: "",
};

#[test]
fn fuzz_bindings_file() {
    let small = "ControlsSettings(preset: Room, sensitivity: 2.0, invert_zoom: true, unused: [\"pan\", \"rise\"], bindings: {
        \"menu\": (keyboard_mouse: [\"Shift+KeyM\"], xr: [\"Left.Menu\"]), // mine
        \"orbit\": (gamepad: (input: \"LeftStick\", dead_zone: 0.2, curve: 2, scale: -9e1, invert_x: true)),
        \"jump\": (touch: [], xr_vive: [\"Left.TrackpadClick+Left.TrackpadUp\"]), /* own */
    })";
    let mut odd = Bindings::from_ron(small).unwrap();
    odd.set("a \"b\"\\\n", Device::Touch, vec!["Tap".parse().unwrap()]);
    let corpus = [small.to_owned(), odd.to_ron(), ron::to_string(&odd).unwrap()];
    let corpus = corpus.into_iter().map(String::into_bytes).collect();
    fuzz("bindings_file", 3_000, corpus, |random, input| {
        let text = String::from_utf8_lossy(input);
        let (read, peak) = memory::peak(|| Bindings::from_ron(&text));
        assert!(peak <= bound(text.as_bytes()), "{peak} bytes for {}", text.len());
        let bindings = match read {
            Ok(bindings) => bindings,
            Err(error) => {
                let lines = text.split('\n').count();
                assert!((1..=lines + 1).contains(&error.line), "{error}");
                assert!(error.to_string().len() < 2_000, "{error}");
                return false;
            }
        };
        for problem in bindings.check(&[OWN]) {
            // All that is wrong is somewhere.
            assert!(problem.place(&text).is_some(), "{problem}");
        }
        let device = Device::ALL[random.below(Device::ALL.len())];
        for conflict in bindings.conflicts(device, &[OWN]) {
            assert!(conflict.actions.len() > 1, "{conflict}");
        }
        let _ = help_text(&bindings, device, &[OWN]);
        let _ = table(&bindings, &[device], &[OWN]);
        let written = bindings.to_ron();
        let again = Bindings::from_ron(&written).unwrap_or_else(|e| panic!("{e}\n{written}"));
        // Numbers may be none, which equal nothing.
        assert_eq!(format!("{again:?}"), format!("{:?}", bindings.without_defaults()));
        true
    });
}

#[test]
fn fuzz_bindings_defaults() {
    let corpus = Preset::ALL.map(|preset| defaults_ron(preset).into_bytes()).to_vec();
    fuzz("bindings_defaults", 100, corpus, |_, input| {
        let text = String::from_utf8_lossy(input);
        let (read, peak) = memory::peak(|| Bindings::from_ron(&text));
        assert!(peak <= bound(text.as_bytes()), "{peak} bytes for {}", text.len());
        read.is_ok_and(|bindings| bindings.check(&[]).iter().all(|p| p.place(&text).is_some()))
    });
}

#[test]
fn fuzz_bindings_text() {
    let corpus =
        ["Shift+KeyA|KeyD|KeyS|KeyW", "Left.Trigger+Right.StickUp", "LeftDrag", "Ctrl+Alt+F1"];
    let corpus = corpus.map(|text| text.as_bytes().to_vec()).to_vec();
    fuzz("bindings_text", 3_000, corpus, |_, input| {
        let text = String::from_utf8_lossy(input);
        match text.parse::<Binding>() {
            Ok(binding) => {
                assert_eq!(binding.input_text().parse().as_ref(), Ok(&binding));
                assert!(
                    !binding.label_on(Device::Gamepad).is_empty()
                        && !binding.is_masked_by(&binding)
                );
                true
            }
            Err(error) => {
                assert!(error.to_string().len() < 1_000, "{error}");
                false
            }
        }
    });
}

#[test]
fn fuzz_recording() {
    let mut recording = Recording::new(["orbit", "menu", "zoom"]).unwrap();
    for frame in 0..20_u64 {
        let action = (frame % 3) as u16;
        let value = [frame as f32 * 0.37 - 2.0, -0.0];
        let held = frame % 2 == 0;
        let seconds = frame as f64 / 72.0;
        recording.push(RecordedEvent { frame, seconds, action, held, value }).unwrap();
    }
    recording.finish(30, 1.0).unwrap();
    let corpus = vec![
        recording.to_string().into_bytes(),
        b"farlight-recording 1\nactions\n# none\n\n3 0.5\n".to_vec(),
        b"farlight-recording 1\nactions a b\n12 0.2 0=3.5,-1 1=1\n13 0.2166667 0 1~1e9\n".to_vec(),
    ];
    fuzz("recording", 10_000, corpus, |_, input| {
        let text = String::from_utf8_lossy(input);
        let (read, peak) = memory::peak(|| text.parse::<Recording>());
        assert!(peak <= bound(text.as_bytes()), "{peak} bytes for {}", text.len());
        match read {
            Ok(recording) => {
                let written = recording.to_string();
                let again: Recording = written.parse().unwrap_or_else(|e| panic!("{e}: {written}"));
                assert_eq!(format!("{again:?}"), format!("{recording:?}"));
                let events: usize = recording.frames().map(|frame| frame.events.len()).sum();
                assert_eq!(events, recording.events().len());
                true
            }
            Err(error) => {
                assert!((1..=text.lines().count() + 2).contains(&error.line), "{error}");
                assert!(error.to_string().len() < 1_000, "{error}");
                false
            }
        }
    });
}

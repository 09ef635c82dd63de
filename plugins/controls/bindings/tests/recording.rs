//! Recordings: what was written is read again, and what is no recording says why.

use farlight_bindings::{MAX_RECORDED_ACTIONS, RecordedEvent, Recording, RecordingError};

fn event(frame: u64, action: u16, held: bool, value: [f32; 2]) -> RecordedEvent {
    RecordedEvent { frame, seconds: frame as f64 / 60.0, action, held, value }
}

fn recording() -> Recording {
    let mut recording = Recording::new(["orbit", "next_material", "zoom"]).unwrap();
    for event in [
        event(3, 0, true, [0.1, -7.25]),
        event(3, 1, true, [1.0, 0.0]),
        event(4, 0, true, [f32::MIN_POSITIVE, -0.0]),
        event(9, 1, false, [0.0, 0.0]),
        event(9, 0, false, [0.0, 0.0]),
        event(20, 2, false, [-0.0, 0.0]),
        event(21, 2, false, [0.0, 1e30]),
    ] {
        recording.push(event).unwrap();
    }
    recording.finish(240, 4.0).unwrap();
    recording
}

#[test]
fn what_is_written_is_read() {
    let recording = recording();
    let text = recording.to_string();
    let read: Recording = text.parse().unwrap();
    assert_eq!(read, recording);
    // Equal numbers may still differ: zero has a sign.
    assert_eq!(format!("{read:?}"), format!("{recording:?}"));
    assert_eq!(read.end(), (240, 4.0));
    assert_eq!(read.to_string(), text);
}

#[test]
fn the_text_is_what_the_documentation_says() {
    let text = "farlight-recording 1\nactions orbit next_material\n\
                12 0.2 0=3.5,-1 1=1\n13 0.2166667 0 1\n240 4\n";
    let read: Recording = text.parse().unwrap();
    assert_eq!(read.to_string(), text);
    assert_eq!(read.actions(), ["orbit", "next_material"]);
    assert_eq!(read.action("next_material"), Some(1));
    let frames: Vec<_> = read.frames().map(|f| (f.frame, f.seconds, f.events.len())).collect();
    assert_eq!(frames, [(12, 0.2, 2), (13, 0.216_666_7, 2)]);
    let RecordedEvent { held, value, .. } = read.events()[0];
    assert_eq!((held, value), (true, [3.5, -1.0]));
    let RecordedEvent { held, value, .. } = read.events()[3];
    assert_eq!((held, value), (false, [0.0, 0.0]));
    let commented: Recording = format!("# mine\n\n{text}# end\n").parse().unwrap();
    assert_eq!(commented, read);
}

#[test]
fn an_empty_recording_is_one() {
    let empty = Recording::new(Vec::<String>::new()).unwrap();
    assert_eq!(empty.to_string().parse(), Ok(empty));
    let mut first = Recording::new(["menu"]).unwrap();
    first.push(event(0, 0, true, [1.0, 0.0])).unwrap();
    assert_eq!(first.to_string().parse(), Ok(first));
}

#[test]
fn errors_name_line_and_reason() {
    use RecordingError as E;
    let head = "farlight-recording 1\nactions orbit menu\n";
    let number = |text: &str| E::Number(text.to_owned());
    for (text, line, error) in [
        ("", 1, E::Head),
        ("farlight-recording 2\n", 1, E::Head),
        ("farlight-recording 1\n", 2, E::Actions),
        ("farlight-recording 1\n1 0 0\n", 2, E::Actions),
        ("farlight-recording 1\n\nactions menu Menu", 3, E::Name("Menu".into())),
        ("farlight-recording 1\nactions menu menu", 2, E::Twice("menu".into())),
        (&format!("{head}1"), 3, number("")),
        (&format!("{head}-1 0"), 3, number("-1")),
        (&format!("{head}1 0 x=1"), 3, number("x")),
        (&format!("{head}1 0 0=1,2,3"), 3, number("2,3")),
        (&format!("{head}1 0 0="), 3, number("")),
        (&format!("{head}1 0 2=1"), 3, E::Action(2)),
        (&format!("{head}1 0 70000=1"), 3, E::Action(70_000)),
        (&format!("{head}1 0 0=inf"), 3, E::NotFinite),
        (&format!("{head}1 NaN 0=1"), 3, E::NotFinite),
        (&format!("{head}1 -1 0=1"), 3, E::NotFinite),
        (&format!("{head}1 0 0=1 0=2"), 3, E::TwiceInFrame(0)),
        (&format!("{head}2 0 0=1\n1 0 0=2"), 4, E::Order),
        (&format!("{head}2 0 0=1\n2 0 1=2"), 4, E::Order),
        (&format!("{head}2 1 0=1\n3 0.5 0=2"), 4, E::Order),
    ] {
        let wrong = text.parse::<Recording>().unwrap_err();
        assert_eq!((wrong.line, &wrong.error), (line, &error), "{text}");
        assert!(wrong.to_string().starts_with(&format!("line {line}: ")));
    }
    let names = (0..=MAX_RECORDED_ACTIONS).map(|n| format!("a{n}"));
    assert_eq!(Recording::new(names), Err(E::TooManyActions));
}

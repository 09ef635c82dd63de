//! The page and the files of the repository are what the code says.

use std::{fs, path::PathBuf};

use farlight_bindings::{ACTIONS, Bindings, Device, Preset, documentation};

fn file(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "../../..", name].iter().collect()
}

fn read(name: &str) -> String {
    fs::read_to_string(file(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

const BEGIN: &str = "<!-- table -->\n";
const END: &str = "<!-- end of table -->\n";

/// With `FARLIGHT_BLESS=1` the tables are written anew instead.
#[test]
fn the_page_has_the_tables_of_the_code() {
    let page = read("docs/controls.md");
    let (before, rest) = page.split_once(BEGIN).expect("a table begins");
    let (found, after) = rest.split_once(END).expect("a table ends");
    let made = format!("\n{}\n", documentation());
    if std::env::var_os("FARLIGHT_BLESS").is_some_and(|value| value == "1") {
        let page = format!("{before}{BEGIN}{made}{END}{after}");
        fs::write(file("docs/controls.md"), page).expect("docs/controls.md can be written");
        return;
    }
    let first = found.lines().zip(made.lines()).find(|(found, made)| found != made);
    assert!(
        found == made,
        "docs/controls.md is not what the code says; FARLIGHT_BLESS=1 writes it anew. {first:?}"
    );
}

#[test]
fn every_action_and_every_device_stands_in_the_page() {
    let page = read("docs/controls.md");
    for info in ACTIONS {
        assert!(page.contains(&format!("| `{}` |", info.name)), "{info}");
    }
    for device in Device::ALL {
        assert!(page.contains(device.label()) && page.contains(device.name()), "{device}");
    }
    assert!(page.contains("Wii Remote (unverified)"));
}

#[test]
fn examples_in_the_documentation_are_good_files() {
    let source = read("plugins/controls/bindings/src/lib.rs").replace("//! ", "");
    for page in [read("docs/controls.md"), source] {
        let (_, rest) = page.split_once("```ron\n").expect("an example");
        let (text, _) = rest.split_once("```").expect("its end");
        let bindings = Bindings::from_ron(text).unwrap_or_else(|error| panic!("{error}: {text}"));
        assert_eq!(bindings.check(&[]), []);
        assert!(bindings.bindings.contains_key("menu") && bindings.invert_zoom);
        for device in Device::ALL {
            assert_eq!(bindings.conflicts(device, &[]), []);
        }
    }
}

#[test]
fn the_examples_files_are_good_and_change_nothing() {
    for (name, preset) in [("controls.ron", Preset::Viewer), ("controls_room.ron", Preset::Room)] {
        let text = read(&format!("assets/config/{name}"));
        let bindings = Bindings::from_ron(&text).unwrap_or_else(|e| panic!("{name}:{e}"));
        assert_eq!(bindings.check(&[]), [], "{name}");
        for device in Device::ALL {
            assert_eq!(bindings.conflicts(device, &[]), [], "{name}");
        }
        // So that the page is right about the example programs.
        let defaults = Bindings { preset, ..Bindings::default() };
        assert_eq!(bindings.without_defaults(), defaults, "{name}");
    }
}

#[test]
fn the_gallery_has_what_it_needs_and_no_more() {
    let text = read("assets/config/gallery.controls.ron");
    let bindings = Bindings::from_ron(&text).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(bindings.check(&[]), []);
    for device in Device::ALL {
        assert_eq!(bindings.conflicts(device, &[]), [], "{device}");
        for action in &bindings.unused {
            assert_eq!(bindings.of(action, device), [], "{action} on {device}");
        }
        let help = farlight_bindings::help_text(&bindings, device, &[]);
        assert!(!help.contains("material") && !help.contains("Turn the"), "{help}");
    }
    let table = farlight_bindings::table(&bindings, &Device::ALL, &[]);
    let pan = table.lines().find(|line| line.contains("`pan`")).unwrap();
    assert!(pan.ends_with("`pan` | - | - | - | - | - | - | - | - | - |"), "{pan}");
}

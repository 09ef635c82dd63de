//! The default bindings: complete, well formed.

use farlight_bindings::{
    ACTIONS, APPENDIX_A, Binding, Bindings, Device, Input, Preset, Profile, action,
};

fn bindings(preset: Preset) -> Bindings {
    Bindings { preset, ..Bindings::default() }
}

#[test]
fn every_action_of_the_thesis_is_reached_directly() {
    let devices = [
        Device::KeyboardMouse,
        Device::Gamepad,
        Device::Xr(Profile::Touch),
        Device::Xr(Profile::Index),
        Device::Xr(Profile::Vive),
    ];
    assert_eq!(APPENDIX_A.len(), 26);
    for device in devices {
        for (name, _) in APPENDIX_A {
            assert!(action(name).is_some(), "{name}");
            assert!(!Bindings::default().of(name, device).is_empty(), "{device}: {name}");
        }
    }
}

#[test]
fn small_devices_reach_the_menu_and_turn_things() {
    for device in Device::ALL {
        let reached = |name| !Bindings::default().of(name, device).is_empty();
        for name in ["menu", "help", "orbit", "rotate_object", "rotate_environment", "panel_back"] {
            assert!(reached(name), "{device}: {name}");
        }
        // Panels on a touch screen are touched themselves.
        assert!(reached("panel_press") || device == Device::Touch, "{device}");
    }
}

#[test]
fn defaults_are_well_formed() {
    for preset in Preset::ALL {
        for device in Device::ALL {
            for info in ACTIONS {
                for binding in bindings(preset).of(info.name, device) {
                    assert_eq!(binding.fits(info.kind), Ok(()), "{device}: {info}");
                    let text = binding.input_text();
                    assert_eq!(text.parse().map(|b: Binding| b.held), Ok(binding.held));
                }
            }
        }
    }
}

#[test]
fn every_input_is_found_by_its_name_and_by_no_other() {
    let mut names = std::collections::BTreeSet::new();
    for input in Input::all() {
        let name = input.to_string();
        assert_eq!(name.parse(), Ok(input));
        assert!(!input.label().is_empty() && name.parse::<Binding>().is_ok(), "{name}");
        assert!(names.insert(name.clone()), "{name} is there twice");
        let devices = Device::ALL.into_iter().filter(|device| input.is_of(*device)).count();
        assert!(devices > 0, "{name}");
    }
    assert!("Right.".parse::<Input>().is_err() && "".parse::<Input>().is_err());
}

//! The default bindings: complete, well formed.

use farlight_bindings::{ACTIONS, Bindings, Device, Preset, Profile, action};

fn bindings(preset: Preset) -> Bindings {
    Bindings { preset, ..Bindings::default() }
}

/// What appendix A of Schiller 2022 has.
#[rustfmt::skip]
const APPENDIX_A: &[&str] = &[
    "orbit", "zoom", "rotate_object", "rotate_environment", "walk", "rise", "menu", "next_material",
    "previous_material", "next_model", "previous_model", "more_lights", "fewer_lights", "recentre",
    "evaluation_1", "evaluation_2", "evaluation_3", "coarser_picture", "finer_picture",
    "finer_material", "coarser_material", "toggle_progressive", "toggle_image_based", "screenshot",
    "xr_screenshot", "quit",
];

#[test]
fn every_action_of_the_thesis_is_reached_directly() {
    let devices = [
        Device::KeyboardMouse,
        Device::Gamepad,
        Device::Xr(Profile::Touch),
        Device::Xr(Profile::Index),
        Device::Xr(Profile::Vive),
    ];
    for device in devices {
        for name in APPENDIX_A {
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
                    assert_eq!(
                        text.parse().map(|b: farlight_bindings::Binding| b.held),
                        Ok(binding.held)
                    );
                }
            }
        }
    }
}

//! OpenXR's actions: each is one physical input of both hands ("trigger"). What it does is decided by
//! the app's bindings, so that files, rebinding and hot reload work in a headset too.

use bevy::prelude::*;
use bevy_mod_openxr::{resources::OxrInstance, session::OxrSession};
use bevy_mod_xr::spaces::XrSpace;
use farlight_bindings::{Hand, Profile, Shape, Xr};
use openxr::{Action, ActionSet, Haptic as Vibration, Path, Posef, Vector2f, sys};

/// The actions of a session.
#[derive(Resource)]
pub(super) struct Actions {
    pub(super) set: ActionSet,
    /// `/user/hand/left` and `/user/hand/right`.
    pub(super) hands: [Path; 2],
    inputs: Vec<(Xr, Kind)>,
    grip: Action<Posef>,
    aim: Action<Posef>,
    haptic: Action<Vibration>,
    /// Profiles that the runtime knows.
    pub(super) profiles: Vec<Profile>,
    /// Grip and aim of both hands.
    pub(super) spaces: [[Option<XrSpace>; 2]; 2],
}

/// An action by what it gives.
enum Kind {
    Button(Action<bool>),
    Analog(Action<f32>),
    Stick(Action<Vector2f>),
}

impl Kind {
    fn as_raw(&self) -> sys::Action {
        match self {
            Self::Button(action) => action.as_raw(),
            Self::Analog(action) => action.as_raw(),
            Self::Stick(action) => action.as_raw(),
        }
    }
}

/// The profile's poses and its motor, which `farlight_bindings` knows nothing of.
const GRIP: &str = "input/grip/pose";
const AIM: &str = "input/aim/pose";
const MOTOR: &str = "output/haptic";

impl Actions {
    /// Makes the actions, for the session that is the `count`th: names may be used once.
    pub(super) fn new(
        instance: &OxrInstance,
        count: u32,
        hand_interaction: bool,
    ) -> openxr::Result<Self> {
        let hands = [
            instance.string_to_path("/user/hand/left")?,
            instance.string_to_path("/user/hand/right")?,
        ];
        let set = instance.create_action_set(
            &format!("farlight_{count}"),
            &format!("Controllers {count}"),
            0,
        )?;
        let mut inputs = Vec::new();
        for input in physical() {
            let (name, label) = (identifier(input.name()), input.label());
            let kind = match input.shape() {
                Shape::Button => Kind::Button(set.create_action(&name, label, &hands)?),
                Shape::Analog => Kind::Analog(set.create_action(&name, label, &hands)?),
                Shape::Stick => Kind::Stick(set.create_action(&name, label, &hands)?),
                Shape::Delta | Shape::Delta2 => continue,
            };
            inputs.push((input, kind));
        }
        let grip = set.create_action("grip_pose", "hand", &hands)?;
        let aim = set.create_action("aim_pose", "pointing", &hands)?;
        let haptic = set.create_action("haptic", "shaking", &hands)?;
        let spaces = Default::default();
        let profiles = Vec::new();
        let mut all = Self { set, hands, inputs, grip, aim, haptic, profiles, spaces };
        for profile in Profile::ALL {
            if profile == Profile::Hands && !hand_interaction {
                continue;
            }
            match all.suggest(instance, profile) {
                Ok(()) => all.profiles.push(profile),
                Err(error) => {
                    info!("the OpenXR runtime doesn't know {}: {error}", profile.label());
                }
            }
        }
        Ok(all)
    }

    /// Every action with the paths that a profile has for it.
    pub(super) fn bindings(&self, profile: Profile) -> Vec<(sys::Action, Vec<String>)> {
        let of_hand =
            |hand: Hand, path: &str| format!("/user/hand/{}/{path}", hand.name().to_lowercase());
        let both = |path: &str| Hand::ALL.map(|hand| of_hand(hand, path)).to_vec();
        let mut all = vec![(self.grip.as_raw(), both(GRIP)), (self.aim.as_raw(), both(AIM))];
        if profile != Profile::Hands {
            all.push((self.haptic.as_raw(), both(MOTOR)));
        }
        for (input, kind) in &self.inputs {
            let paths: Vec<String> = Hand::ALL
                .into_iter()
                .filter_map(|hand| Some(of_hand(hand, profile.path(hand, *input)?)))
                .collect();
            if !paths.is_empty() {
                all.push((kind.as_raw(), paths));
            }
        }
        all
    }

    /// Suggests a profile's bindings by itself, to learn whether the runtime takes them.
    fn suggest(&self, instance: &OxrInstance, profile: Profile) -> openxr::Result<()> {
        let mut bindings = Vec::new();
        for (action, paths) in self.bindings(profile) {
            for path in paths {
                let binding = instance.string_to_path(&path)?;
                bindings.push(sys::ActionSuggestedBinding { action, binding });
            }
        }
        let suggestion = sys::InteractionProfileSuggestedBinding {
            ty: sys::InteractionProfileSuggestedBinding::TYPE,
            next: std::ptr::null(),
            interaction_profile: instance.string_to_path(profile.path_of_profile())?,
            count_suggested_bindings: bindings.len() as u32,
            suggested_bindings: bindings.as_ptr(),
        };
        // SAFETY: the instance and the actions are alive, and the list is as long as is said.
        let result = unsafe {
            (instance.fp().suggest_interaction_profile_bindings)(instance.as_raw(), &suggestion)
        };
        if result.into_raw() < 0 { Err(result) } else { Ok(()) }
    }

    /// Makes spaces of a session that follow the hands.
    pub(super) fn follow(&mut self, session: &OxrSession) {
        for (hand, path) in self.hands.into_iter().enumerate() {
            self.spaces[hand] = [&self.grip, &self.aim].map(|action| {
                let space = session.create_action_space(action, path, Isometry3d::IDENTITY);
                space.inspect_err(|error| warn!("a hand can't be followed: {error}")).ok()
            });
        }
    }

    /// What is pressed on a hand's controller, `None` for what it doesn't have.
    pub(super) fn read<'a>(
        &'a self,
        session: &'a OxrSession,
        hand: Hand,
    ) -> impl Iterator<Item = (Xr, Option<Vec2>)> + 'a {
        let path = self.hands[hand as usize];
        self.inputs.iter().map(move |(input, kind)| {
            let value = match kind {
                Kind::Button(action) => action.state(session, path).map(|state| {
                    let down = Vec2::new(f32::from(u8::from(state.current_state)), 0.0);
                    (state.is_active, down)
                }),
                Kind::Analog(action) => action
                    .state(session, path)
                    .map(|state| (state.is_active, Vec2::new(state.current_state, 0.0))),
                Kind::Stick(action) => action.state(session, path).map(|state| {
                    (state.is_active, Vec2::new(state.current_state.x, state.current_state.y))
                }),
            };
            let sound = |(is_active, value): (bool, Vec2)| {
                (is_active && value.is_finite()).then(|| value.clamp(Vec2::NEG_ONE, Vec2::ONE))
            };
            (*input, value.ok().and_then(sound))
        })
    }

    /// Which kind of controller a hand holds.
    pub(super) fn profile(&self, session: &OxrSession, hand: Hand) -> Option<Profile> {
        let path = session.current_interaction_profile(self.hands[hand as usize]).ok()?;
        if path == Path::NULL {
            return None;
        }
        let name = session.instance().path_to_string(path).ok()?;
        Profile::ALL.into_iter().find(|profile| profile.path_of_profile() == name)
    }

    /// Shakes a controller.
    pub(super) fn shake(&self, session: &OxrSession, haptic: &crate::Haptic) -> openxr::Result<()> {
        let path = self.hands[haptic.hand as usize];
        if haptic.amplitude.is_nan() || haptic.amplitude <= 0.0 {
            return self.haptic.stop_feedback(session, path);
        }
        let duration = if haptic.seconds > 0.0 {
            openxr::Duration::from_nanos((f64::from(haptic.seconds.min(10.0)) * 1e9) as i64)
        } else {
            openxr::Duration::MIN_HAPTIC
        };
        let vibration = openxr::HapticVibration::new()
            .amplitude(haptic.amplitude.min(1.0))
            .frequency(openxr::FREQUENCY_UNSPECIFIED)
            .duration(duration);
        self.haptic.apply_feedback(session, path, &vibration)
    }
}

/// What can be pressed; the others are made of it.
fn physical() -> impl Iterator<Item = Xr> {
    let has = |profile: &Profile, input: Xr| {
        Hand::ALL.into_iter().any(|hand| profile.path(hand, input).is_some())
    };
    Xr::ALL.iter().copied().filter(move |&input| Profile::ALL.iter().any(|p| has(p, input)))
}

/// `StickClick` as OpenXR has names: `stick_click`.
fn identifier(name: &str) -> String {
    let mut all = String::new();
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && !all.is_empty() {
            all.push('_');
        }
        all.push(letter.to_ascii_lowercase());
    }
    all
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn names_are_openxr_names() {
        assert_eq!(identifier("StickClick"), "stick_click");
        let names: HashSet<String> = Xr::ALL.iter().map(|x| identifier(x.name())).collect();
        assert_eq!(names.len(), Xr::ALL.len());
        let fits = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        assert!(names.iter().all(|name| name.chars().all(fits)), "{names:?}");
        // What is read out to people must be unique, too.
        let labels: HashSet<&str> = Xr::ALL.iter().map(|x| x.label()).collect();
        assert_eq!(labels.len(), Xr::ALL.len());
    }

    #[test]
    fn all_that_can_be_pressed_is_held() {
        // An action can't say what was moved in a frame.
        for input in physical() {
            let held = matches!(input.shape(), Shape::Button | Shape::Analog | Shape::Stick);
            assert!(held, "{}", input.name());
        }
        assert!(physical().any(|input| input == Xr::Trigger));
        assert!(!physical().any(|input| input == Xr::Swing), "it is read from the poses");
    }
}

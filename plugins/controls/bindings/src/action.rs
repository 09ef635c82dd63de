//! The actions of the suite: their names, what a value of theirs means, and when they are heard.

use std::fmt;

/// How many numbers an action gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ActionKind {
    /// Happens once when it is pressed.
    Button,
    /// One number: what was moved in this frame.
    Axis,
    /// Two numbers: what was moved in this frame, to the right and up.
    Axis2,
}

/// When an action is heard. Contexts above others take inputs away from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Context {
    /// While nothing else wants the inputs: looking at the scene and changing it.
    Scene,
    /// Always: the menu, help, pictures.
    Global,
    /// While a panel is open and has the focus.
    Panel,
}

/// What there is to know about an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActionInfo {
    /// What files call it: lower case with underscores.
    pub name: &'static str,
    /// What people read: a few words.
    pub label: &'static str,
    /// How many numbers.
    pub kind: ActionKind,
    /// When it is heard.
    pub context: Context,
    /// What a value of 1 is; empty for buttons.
    pub unit: &'static str,
}

impl fmt::Display for ActionInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// Calls a macro with the table of actions: `Type, "name", kind, context, "label", "unit";` a line.
/// One table makes the types of `farlight_controls`, the names of files, and the documentation.
#[macro_export]
macro_rules! with_actions {
    ($callback:ident) => {
        $callback! {
            Orbit, "orbit", Axis2, Scene, "Look around", "degrees";
            Pan, "pan", Axis2, Scene, "Move the view sideways", "thousandths of the distance";
            Zoom, "zoom", Axis, Scene, "Come closer, go back", "steps of a tenth of the distance, closer is positive";
            Walk, "walk", Axis2, Scene, "Walk", "metres";
            Rise, "rise", Axis, Scene, "Up, down", "metres";
            RotateObject, "rotate_object", Axis2, Scene, "Turn the object", "degrees";
            RotateEnvironment, "rotate_environment", Axis2, Scene, "Turn the light", "degrees";
            NextMaterial, "next_material", Button, Scene, "Next material", "";
            PreviousMaterial, "previous_material", Button, Scene, "Previous material", "";
            NextModel, "next_model", Button, Scene, "Next object", "";
            PreviousModel, "previous_model", Button, Scene, "Previous object", "";
            NextEnvironment, "next_environment", Button, Scene, "Next environment", "";
            PreviousEnvironment, "previous_environment", Button, Scene, "Previous environment", "";
            NextLamps, "next_lamps", Button, Scene, "Other lamps", "";
            MoreLights, "more_lights", Button, Scene, "More lights a frame", "";
            FewerLights, "fewer_lights", Button, Scene, "Fewer lights a frame", "";
            ToggleProgressive, "toggle_progressive", Button, Scene, "Progressive light on, off", "";
            ToggleImageBased, "toggle_image_based", Button, Scene, "Environment's light on, off", "";
            Evaluation1, "evaluation_1", Button, Scene, "First way to evaluate materials", "";
            Evaluation2, "evaluation_2", Button, Scene, "Second way to evaluate materials", "";
            Evaluation3, "evaluation_3", Button, Scene, "Third way to evaluate materials", "";
            FinerPicture, "finer_picture", Button, Scene, "Finer picture", "";
            CoarserPicture, "coarser_picture", Button, Scene, "Coarser picture", "";
            FinerMaterial, "finer_material", Button, Scene, "Finer material", "";
            CoarserMaterial, "coarser_material", Button, Scene, "Coarser material", "";
            Brighter, "brighter", Button, Scene, "Brighter", "";
            Darker, "darker", Button, Scene, "Darker", "";
            ToggleBackdrop, "toggle_backdrop", Button, Scene, "Backdrop on, off", "";
            ToggleFloor, "toggle_floor", Button, Scene, "Plinth on, off", "";
            ToggleTurning, "toggle_turning", Button, Scene, "Object turns by itself", "";
            Teleport, "teleport", Button, Scene, "Teleport: hold, aim, let go", "";
            TurnLeft, "turn_left", Button, Scene, "Turn yourself to the left, by a step", "";
            TurnRight, "turn_right", Button, Scene, "Turn yourself to the right, by a step", "";
            GrabLeft, "grab_left", Button, Scene, "Take hold with the left hand", "";
            GrabRight, "grab_right", Button, Scene, "Take hold with the right hand", "";
            Recentre, "recentre", Button, Scene, "Recentre the view", "";
            Reset, "reset", Button, Scene, "As at the start", "";
            Menu, "menu", Button, Global, "Menu", "";
            Help, "help", Button, Global, "Help: what does what", "";
            Screenshot, "screenshot", Button, Global, "Screenshot", "";
            XrScreenshot, "xr_screenshot", Button, Global, "Screenshot of both eyes", "";
            Quit, "quit", Button, Global, "Quit", "";
            PanelPress, "panel_press", Button, Panel, "Press what is pointed at", "";
            PanelNext, "panel_next", Button, Panel, "Next control", "";
            PanelPrevious, "panel_previous", Button, Panel, "Previous control", "";
            PanelMore, "panel_more", Button, Panel, "More, to the right", "";
            PanelLess, "panel_less", Button, Panel, "Less, to the left", "";
            PanelScroll, "panel_scroll", Axis, Panel, "Scroll", "lines, up is positive";
            PanelBack, "panel_back", Button, Panel, "Close", "";
        }
    };
}

macro_rules! table {
    ($($type:ident, $name:literal, $kind:ident, $context:ident, $label:literal, $unit:literal;)*) => {
        /// All actions of the suite, in the order in which help shows them.
        pub const ACTIONS: &[ActionInfo] = &[$(ActionInfo {
            name: $name,
            label: $label,
            kind: ActionKind::$kind,
            context: Context::$context,
            unit: $unit,
        }),*];
    };
}

with_actions!(table);

/// The action that files call `name`.
pub fn action(name: &str) -> Option<&'static ActionInfo> {
    ACTIONS.iter().find(|action| action.name == name)
}

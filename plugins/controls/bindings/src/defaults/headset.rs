//! Defaults of controllers and hands in a headset: the left hand moves you, the right hand things.

use super::Table;

/// Two controllers with a stick and two buttons each. Grips take hold, triggers press what a panel
/// shows. Away from panels a trigger held makes a layer: the left one moves you, the right one turns
/// the light and sets the picture, both set what is seldom set.
#[rustfmt::skip]
pub(super) const STICKS: Table = Table {
    rows: &[
        ("orbit", "Left.Stick", 90.0),
        ("rotate_object", "Right.Stick", 90.0),
        ("next_material", "Right.Primary", 1.0),
        ("previous_material", "Right.Secondary", 1.0),
        ("next_model", "Right.StickClick", 1.0),
        ("teleport", "Left.StickClick", 1.0),
        ("grab_left", "Left.Squeeze", 1.0),
        ("grab_right", "Right.Squeeze", 1.0),
        ("menu", "Left.Menu", 1.0),
        ("menu", "Left.Secondary", 1.0),
        ("help", "Left.Primary", 1.0),

        ("walk", "Left.Trigger+Left.Stick", 1.5),
        ("rise", "Left.Trigger+Left.Primary|Left.Secondary", 1.0),
        ("zoom", "Left.Trigger+Right.StickDown|Right.StickUp", 8.0),
        ("turn_left", "Left.Trigger+Right.StickLeft", 1.0),
        ("turn_right", "Left.Trigger+Right.StickRight", 1.0),
        ("previous_model", "Left.Trigger+Right.StickClick", 1.0),
        ("recentre", "Left.Trigger+Left.StickClick", 1.0),
        ("next_lamps", "Left.Trigger+Right.Primary", 1.0),
        ("toggle_turning", "Left.Trigger+Right.Secondary", 1.0),

        ("rotate_environment", "Right.Trigger+Right.Stick", 90.0),
        ("next_environment", "Right.Trigger+Right.Primary", 1.0),
        ("previous_environment", "Right.Trigger+Right.Secondary", 1.0),
        ("toggle_progressive", "Right.Trigger+Left.Primary", 1.0),
        ("toggle_image_based", "Right.Trigger+Left.Secondary", 1.0),
        ("coarser_picture", "Right.Trigger+Left.StickLeft", 1.0),
        ("finer_picture", "Right.Trigger+Left.StickRight", 1.0),
        ("fewer_lights", "Right.Trigger+Left.StickDown", 1.0),
        ("more_lights", "Right.Trigger+Left.StickUp", 1.0),
        ("screenshot", "Right.Trigger+Left.StickClick", 1.0),
        ("reset", "Right.Trigger+Right.StickClick", 1.0),

        ("coarser_material", "Left.Trigger+Right.Trigger+Left.StickLeft", 1.0),
        ("finer_material", "Left.Trigger+Right.Trigger+Left.StickRight", 1.0),
        ("darker", "Left.Trigger+Right.Trigger+Left.StickDown", 1.0),
        ("brighter", "Left.Trigger+Right.Trigger+Left.StickUp", 1.0),
        ("evaluation_1", "Left.Trigger+Right.Trigger+Right.StickLeft", 1.0),
        ("evaluation_2", "Left.Trigger+Right.Trigger+Right.StickUp", 1.0),
        ("evaluation_3", "Left.Trigger+Right.Trigger+Right.StickRight", 1.0),
        ("toggle_backdrop", "Left.Trigger+Right.Trigger+Right.Primary", 1.0),
        ("toggle_floor", "Left.Trigger+Right.Trigger+Right.Secondary", 1.0),
        ("xr_screenshot", "Left.Trigger+Right.Trigger+Left.StickClick", 1.0),
        ("quit", "Left.Trigger+Right.Trigger+Right.StickClick", 1.0),

        ("panel_press", "Left.Trigger", 1.0),
        ("panel_press", "Right.Trigger", 1.0),
        ("panel_press", "Right.Primary", 1.0),
        ("panel_next", "Left.StickDown", 1.0),
        ("panel_previous", "Left.StickUp", 1.0),
        ("panel_more", "Left.StickRight", 1.0),
        ("panel_less", "Left.StickLeft", 1.0),
        ("panel_scroll", "Right.StickDown|Right.StickUp", 20.0),
        ("panel_back", "Right.Secondary", 1.0),
    ],
    room: &[
        ("teleport", "Left.StickUp", 1.0),
        ("turn_left", "Left.StickLeft", 1.0),
        ("turn_right", "Left.StickRight", 1.0),
        ("orbit", "", 0.0),
        ("zoom", "", 0.0),
    ],
};

/// Wands: what a stick does elsewhere, a pressed trackpad does here. Triggers take hold; the grips,
/// which are hard to reach, make the layers.
#[rustfmt::skip]
pub(super) const VIVE: Table = Table {
    rows: &[
        ("orbit", "Left.TrackpadClick+Left.Trackpad", 90.0),
        ("rotate_object", "Right.TrackpadClick+Right.Trackpad", 90.0),
        ("grab_left", "Left.Trigger", 1.0),
        ("grab_right", "Right.Trigger", 1.0),
        ("menu", "Left.Menu", 1.0),
        ("help", "Right.Menu", 1.0),

        ("walk", "Left.Squeeze+Left.TrackpadClick+Left.Trackpad", 1.5),
        ("zoom", "Left.Squeeze+Right.TrackpadClick+Right.TrackpadDown|Right.TrackpadUp", 8.0),
        ("turn_left", "Left.Squeeze+Right.TrackpadClick+Right.TrackpadLeft", 1.0),
        ("turn_right", "Left.Squeeze+Right.TrackpadClick+Right.TrackpadRight", 1.0),
        ("rise", "Left.Squeeze+Left.Trigger|Right.Trigger", 1.0),
        ("recentre", "Left.Squeeze+Left.Menu", 1.0),
        ("reset", "Left.Squeeze+Right.Menu", 1.0),

        ("rotate_environment", "Right.Squeeze+Right.TrackpadClick+Right.Trackpad", 90.0),
        ("previous_material", "Right.Squeeze+Left.TrackpadClick+Left.TrackpadLeft", 1.0),
        ("next_material", "Right.Squeeze+Left.TrackpadClick+Left.TrackpadRight", 1.0),
        ("previous_model", "Right.Squeeze+Left.TrackpadClick+Left.TrackpadDown", 1.0),
        ("next_model", "Right.Squeeze+Left.TrackpadClick+Left.TrackpadUp", 1.0),
        ("toggle_image_based", "Right.Squeeze+Left.Trigger", 1.0),
        ("toggle_progressive", "Right.Squeeze+Right.Trigger", 1.0),
        ("previous_environment", "Right.Squeeze+Left.Menu", 1.0),
        ("next_environment", "Right.Squeeze+Right.Menu", 1.0),

        ("coarser_picture", "Left.Squeeze+Right.Squeeze+Left.TrackpadClick+Left.TrackpadLeft", 1.0),
        ("finer_picture", "Left.Squeeze+Right.Squeeze+Left.TrackpadClick+Left.TrackpadRight", 1.0),
        ("fewer_lights", "Left.Squeeze+Right.Squeeze+Left.TrackpadClick+Left.TrackpadDown", 1.0),
        ("more_lights", "Left.Squeeze+Right.Squeeze+Left.TrackpadClick+Left.TrackpadUp", 1.0),
        ("evaluation_1", "Left.Squeeze+Right.Squeeze+Right.TrackpadClick+Right.TrackpadLeft", 1.0),
        ("evaluation_2", "Left.Squeeze+Right.Squeeze+Right.TrackpadClick+Right.TrackpadUp", 1.0),
        ("evaluation_3", "Left.Squeeze+Right.Squeeze+Right.TrackpadClick+Right.TrackpadRight", 1.0),
        ("screenshot", "Left.Squeeze+Right.Squeeze+Right.TrackpadClick+Right.TrackpadDown", 1.0),
        ("coarser_material", "Left.Squeeze+Right.Squeeze+Left.Trigger", 1.0),
        ("finer_material", "Left.Squeeze+Right.Squeeze+Right.Trigger", 1.0),
        ("xr_screenshot", "Left.Squeeze+Right.Squeeze+Left.Menu", 1.0),
        ("quit", "Left.Squeeze+Right.Squeeze+Right.Menu", 1.0),

        ("panel_press", "Left.Trigger", 1.0),
        ("panel_press", "Right.Trigger", 1.0),
        ("panel_next", "Left.TrackpadClick+Left.TrackpadDown", 1.0),
        ("panel_previous", "Left.TrackpadClick+Left.TrackpadUp", 1.0),
        ("panel_more", "Left.TrackpadClick+Left.TrackpadRight", 1.0),
        ("panel_less", "Left.TrackpadClick+Left.TrackpadLeft", 1.0),
        ("panel_scroll", "Right.TrackpadClick+Right.TrackpadDown|Right.TrackpadUp", 20.0),
        ("panel_back", "Right.Squeeze", 1.0),
    ],
    room: &[
        ("teleport", "Left.TrackpadClick+Left.TrackpadUp", 1.0),
        ("turn_left", "Left.TrackpadClick+Left.TrackpadLeft", 1.0),
        ("turn_right", "Left.TrackpadClick+Left.TrackpadRight", 1.0),
        ("orbit", "", 0.0),
        ("zoom", "", 0.0),
    ],
};

/// One button to select and one for the menu on each: held, it makes the hand's swing turn things.
/// What is not here is in the menu.
#[rustfmt::skip]
pub(super) const SIMPLE: Table = Table {
    rows: &[
        ("orbit", "Left.Select+Left.Swing", 2.0),
        ("rotate_object", "Right.Select+Right.Swing", 2.0),
        ("rotate_environment", "Left.Select+Right.Select+Left.Swing", 1.0),
        ("rotate_environment", "Left.Select+Right.Select+Right.Swing", 1.0),
        ("menu", "Left.Menu", 1.0),
        ("help", "Right.Menu", 1.0),
        ("panel_press", "Left.Select", 1.0),
        ("panel_press", "Right.Select", 1.0),
        ("panel_back", "Left.Menu", 1.0),
    ],
    room: &[
        ("teleport", "Left.Select", 1.0),
        ("grab_right", "Right.Select", 1.0),
        ("orbit", "", 0.0),
        ("rotate_object", "", 0.0),
        ("rotate_environment", "", 0.0),
    ],
};

/// Bare hands, as simple controllers: a pinch selects, a fist is the menu's button.
#[rustfmt::skip]
pub(super) const HANDS: Table = Table {
    rows: &[
        ("orbit", "Left.Pinch+Left.Swing", 2.0),
        ("rotate_object", "Right.Pinch+Right.Swing", 2.0),
        ("rotate_environment", "Left.Pinch+Right.Pinch+Left.Swing", 1.0),
        ("rotate_environment", "Left.Pinch+Right.Pinch+Right.Swing", 1.0),
        ("menu", "Left.Grasp", 1.0),
        ("help", "Right.Grasp", 1.0),
        ("panel_press", "Left.Pinch", 1.0),
        ("panel_press", "Right.Pinch", 1.0),
        ("panel_back", "Left.Grasp", 1.0),
    ],
    room: &[
        ("teleport", "Left.Pinch", 1.0),
        ("grab_right", "Right.Pinch", 1.0),
        ("orbit", "", 0.0),
        ("rotate_object", "", 0.0),
        ("rotate_environment", "", 0.0),
    ],
};

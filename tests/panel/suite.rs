//! The suite's own sections, as they come with its plugins.

use bevy::prelude::*;
use farlight::{panel::PanelSettings, prelude::*};

use crate::stage::Stage;

#[test]
fn every_section_unfolds() {
    let mut stage = Stage::new(UVec2::new(960, 800), PanelSettings { hint: false, ..default() });
    let camera = stage.camera;
    stage.world().entity_mut(camera).insert(ProgressiveCamera::default());
    stage.world().resource_mut::<PanelState>().menu = true;
    stage.frames(4);
    stage.picture("suite.png");
    let titles = ["Environment light", "Progressive picture", "Global illumination", "Network"];
    for title in
        titles.into_iter().chain(["Measured materials", "Performance", "Controls", "Panel"])
    {
        stage.world().resource_mut::<PanelState>().unfold = Some(title);
        stage.frames(8);
        let name = title.to_lowercase().replace(' ', "_");
        assert_eq!(stage.picture(&format!("suite_{name}.png")).problem(), None);
    }
}

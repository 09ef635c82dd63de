//! A scene with a panel of a game's settings.

use std::time::Duration;

use bevy::{
    app::PluginGroupBuilder,
    camera::Exposure,
    input::{
        ButtonState,
        keyboard::{Key, KeyboardInput},
    },
    prelude::*,
    reflect::Reflect,
};
use farlight::{
    controls::UserFile,
    panel::{
        PanelCamera, PanelSettings,
        bevy_egui::{EguiContext, input::EguiInputEvent},
        egui,
        field::{Hidden, Logarithmic, Turn, Unit},
    },
    prelude::*,
};

use crate::support::{
    self,
    headless::{Headless, Picture},
};

/// What the panel shows.
#[derive(Resource, Reflect, Clone, Debug, PartialEq)]
#[reflect(Resource, Default)]
pub(crate) struct Lamp {
    /// Whether it shines.
    pub(crate) on: bool,
    /// How bright it is.
    #[reflect(@0.0..=1.0_f32, @Unit("%"))]
    pub(crate) brightness: f32,
    /// All light that it gives.
    #[reflect(@1.0..=10_000.0_f32, @Unit("lm"), @Logarithmic)]
    pub(crate) power: f32,
    /// Lamps of this kind.
    #[reflect(@1..=12_u32)]
    pub(crate) count: u32,
    /// What it is made of.
    pub(crate) shade: Shade,
    /// Its colour.
    pub(crate) colour: Color,
    /// Where it is.
    pub(crate) place: Vec3,
    /// Where it looks.
    #[reflect(@Turn)]
    pub(crate) turned: Quat,
    /// What it is called.
    pub(crate) name: String,
    /// How it flickers.
    pub(crate) flicker: Option<f32>,
    /// More of it.
    pub(crate) bulb: Bulb,
    #[reflect(@Hidden)]
    pub(crate) secret: u32,
}

impl Default for Lamp {
    fn default() -> Self {
        Self {
            on: true,
            brightness: 0.5,
            power: 800.0,
            count: 3,
            shade: Shade::Paper,
            colour: Color::srgb_u8(255, 180, 90),
            place: Vec3::new(0.5, 1.2, -3.0),
            turned: Quat::IDENTITY,
            name: "By the window".into(),
            flicker: None,
            bulb: Bulb { age: 120.0, warranty: true },
            secret: 7,
        }
    }
}

#[derive(Reflect, Clone, Debug, PartialEq, Default)]
#[reflect(Default)]
pub(crate) enum Shade {
    #[default]
    Paper,
    Glass,
    Bare {
        /// How hot it becomes.
        heat: f32,
    },
}

#[derive(Reflect, Clone, Debug, PartialEq, Default)]
#[reflect(Default)]
pub(crate) struct Bulb {
    /// How long it has been burning.
    #[reflect(@Unit("h"))]
    pub(crate) age: f32,
    pub(crate) warranty: bool,
}

/// Controls that hear no gamepads of the machine.
pub(crate) fn controls(user_file: UserFile) -> ControlsPlugin {
    ControlsPlugin { gamepads: false, user_file, ..default() }
}

/// An app without a window.
pub(crate) struct Stage {
    pub(crate) headless: Headless,
    pub(crate) camera: Entity,
}

impl Stage {
    /// With everything as it is by default, but for the user's own controls.
    pub(crate) fn new(size: UVec2, settings: PanelSettings) -> Self {
        Self::with(size, settings, FarlightPlugins.set(controls(UserFile::Nowhere)))
    }

    pub(crate) fn with(size: UVec2, settings: PanelSettings, plugins: PluginGroupBuilder) -> Self {
        let headless = Headless::new(size, &support::assets(), |app| {
            app.add_plugins(plugins)
                .init_resource::<Lamp>()
                .insert_resource(settings)
                .insert_resource(ClearColor(Color::srgb(0.45, 0.5, 0.55)))
                .add_panel_resource::<Lamp>("Lamp");
        });
        let mut headless = headless.unwrap_or_else(|problem| panic!("{problem}"));
        headless.set_frame_time(Duration::from_millis(20));
        let target = headless.target();
        let camera = headless
            .app
            .world_mut()
            .spawn((Camera3d::default(), PanelCamera, target, Msaa::Off, Exposure { ev100: 9.7 }))
            .id();
        let mut stage = Self { headless, camera };
        stage.frames(3);
        stage
    }

    pub(crate) fn world(&mut self) -> &mut World {
        self.headless.app.world_mut()
    }

    pub(crate) fn lamp(&mut self) -> Lamp {
        self.world().resource::<Lamp>().clone()
    }

    pub(crate) fn frames(&mut self, count: u32) {
        for _ in 0..count {
            self.headless.update().unwrap();
        }
    }

    pub(crate) fn picture(&mut self, name: &str) -> Picture {
        let picture = self.headless.capture().unwrap();
        picture.save(support::scratch("panel").join(name)).unwrap();
        picture
    }

    /// The mouse on the screen, as a window would report it.
    pub(crate) fn mouse(&mut self, event: egui::Event) {
        let context = self.camera;
        self.world().write_message(EguiInputEvent { context, event });
    }

    /// Presses a point of the screen with the mouse, in egui's points.
    pub(crate) fn click(&mut self, at: egui::Pos2) {
        self.mouse(egui::Event::PointerMoved(at));
        self.frames(1);
        for pressed in [true, false] {
            self.mouse(egui::Event::PointerButton {
                pos: at,
                button: egui::PointerButton::Primary,
                pressed,
                modifiers: egui::Modifiers::NONE,
            });
            self.frames(1);
        }
    }

    /// Presses and lets go of a key, a frame each.
    pub(crate) fn tap(&mut self, key_code: KeyCode) {
        for state in [ButtonState::Pressed, ButtonState::Released] {
            let logical_key = Key::Unidentified(bevy::input::keyboard::NativeKey::Unidentified);
            self.world().write_message(KeyboardInput {
                key_code,
                logical_key,
                state,
                text: None,
                repeat: false,
                window: Entity::PLACEHOLDER,
            });
            self.frames(1);
        }
    }
}

/// What can be pressed in a panel, by egui's own account.
impl Stage {
    fn context(&mut self, on_screen: bool) -> egui::Context {
        let mut contexts = self.world().query::<(&mut EguiContext, Has<Camera3d>)>();
        let world = self.headless.app.world_mut();
        let mut found = contexts.iter_mut(world).filter(|(_, screen)| *screen == on_screen);
        found.next().map(|(mut context, _)| context.get_mut().clone()).expect("a context")
    }

    /// The rectangles of all that can be pressed on the screen.
    pub(crate) fn all(&mut self) -> Vec<egui::Rect> {
        self.context(true).interactive_rects_last_pass()
    }

    /// The rectangles of wide buttons of the screen's menu, from above.
    pub(crate) fn buttons(&mut self) -> Vec<egui::Rect> {
        let rects = self.all();
        // Rows are no higher; those of text fields and sliders are not as wide.
        let wide = |rect: &egui::Rect| {
            (18.0..30.0).contains(&rect.height()) && (170.0..190.0).contains(&rect.width())
        };
        let mut rects: Vec<_> = rects.into_iter().filter(wide).collect();
        rects.sort_by(|a, b| a.top().total_cmp(&b.top()));
        rects
    }

    /// The rectangles of controls of a size, from above.
    pub(crate) fn controls(&mut self, on_screen: bool, size: egui::Vec2) -> Vec<egui::Rect> {
        let rects = self.context(on_screen).interactive_rects_last_pass();
        let near = |a: egui::Vec2| (a - size).abs().max_elem() < 1.0;
        let mut rects: Vec<_> = rects.into_iter().filter(|rect| near(rect.size())).collect();
        rects.sort_by(|a, b| a.top().total_cmp(&b.top()));
        rects
    }

    /// The switch of `Lamp::on`.
    pub(crate) fn switch(&mut self, on_screen: bool) -> egui::Rect {
        self.controls(on_screen, egui::vec2(36.0, 24.0))[0]
    }

    /// What has the focus.
    pub(crate) fn focused(&mut self, on_screen: bool) -> Option<egui::Rect> {
        let ctx = self.context(on_screen);
        let id = ctx.memory(|memory| memory.focused())?;
        ctx.read_response(id).map(|response| response.rect)
    }
}

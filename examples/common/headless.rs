//! Runs a Bevy app without a window: every camera draws into an image, frames are driven by hand,
//! pictures come back as pixels. Shared by the examples' `--headless` mode and the tests.
//!
//! Rendering needs a Vulkan device; Mesa's lavapipe will do.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use bevy::{
    app::PluginsState,
    asset::UnapprovedPathMode,
    camera::RenderTarget,
    log::LogPlugin,
    prelude::*,
    render::{
        RenderPlugin,
        error_handler::{RenderErrorHandler, RenderErrorPolicy},
        pipelined_rendering::PipelinedRenderingPlugin,
        render_resource::TextureFormat,
        renderer::RenderAdapterInfo,
        settings::{RenderCreation, WgpuSettings},
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
    time::TimeUpdateStrategy,
    window::ExitCondition,
    winit::WinitPlugin,
};

/// Frames after which a screenshot that did not arrive is given up.
const SCREENSHOT_FRAMES: u32 = 120;

/// An app without a window.
pub struct Headless {
    /// The app; [`Headless::update`] runs one frame of it.
    pub app: App,
    target: Handle<Image>,
    size: UVec2,
}

/// The image that all cameras draw into.
#[derive(Resource, Clone)]
struct HeadlessTarget(Handle<Image>);

/// A picture that was asked for.
pub struct Capture(Arc<Mutex<Option<Vec<u8>>>>);

/// What the renderer complained about; rendering has stopped for good.
#[derive(Resource)]
struct RenderFailure(String);

/// Eight-bit sRGB pixels, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` pixels.
    pub pixels: Vec<[u8; 3]>,
}

impl Headless {
    /// Builds the app: Bevy's default plugins for drawing into an image of `size` pixels, then
    /// whatever `configure` adds. `assets` is the folder of asset files.
    ///
    /// # Errors
    /// If there is no graphics adapter, or a plugin fails to start within 60 seconds.
    pub fn new(
        size: UVec2,
        assets: &Path,
        configure: impl FnOnce(&mut App),
    ) -> Result<Self, String> {
        Self::on(WgpuSettings::default(), size, assets, configure)
    }

    /// The same on a device that is asked for as `settings` say.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn on(
        settings: WgpuSettings,
        size: UVec2,
        assets: &Path,
        configure: impl FnOnce(&mut App),
    ) -> Result<Self, String> {
        let mut app = App::new();
        let mut plugins = DefaultPlugins
            .build()
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            .set(RenderPlugin {
                render_creation: RenderCreation::Automatic(Box::new(settings)),
                synchronous_pipeline_compilation: true,
                ..default()
            })
            .set(AssetPlugin {
                file_path: assets.display().to_string(),
                // Files of the person who runs it lie anywhere.
                unapproved_path_mode: UnapprovedPathMode::Allow,
                ..default()
            })
            .disable::<WinitPlugin>()
            .disable::<PipelinedRenderingPlugin>();
        // A process has one log, whereas tests have many apps: for a look at a single one.
        if std::env::var_os("FARLIGHT_LOG").is_none() {
            plugins = plugins.disable::<LogPlugin>();
        }
        app.add_plugins(plugins);
        let image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None);
        let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
        app.insert_resource(HeadlessTarget(target.clone()))
            .insert_resource(RenderErrorHandler(|error, main_world, _| {
                main_world.insert_resource(RenderFailure(error.description.clone()));
                RenderErrorPolicy::StopRendering
            }))
            .add_systems(First, redirect_cameras)
            .add_systems(PostStartup, redirect_cameras);
        configure(&mut app);

        let patience = Instant::now() + Duration::from_secs(60);
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
            if Instant::now() > patience {
                return Err("the renderer did not start within 60 s".into());
            }
        }
        app.finish();
        app.cleanup();
        let headless = Self { app, target, size };
        if headless.adapter().is_empty() {
            return Err("no graphics adapter was found; install Mesa's lavapipe \
                        (mesa-vulkan-drivers) to render on the CPU"
                .into());
        }
        Ok(headless)
    }

    /// Name and driver of the graphics adapter.
    #[must_use]
    pub fn adapter(&self) -> String {
        self.app
            .world()
            .get_resource::<RenderAdapterInfo>()
            .map(|info| format!("{} ({:?}, {})", info.name, info.backend, info.driver_info))
            .unwrap_or_default()
    }

    /// Makes every frame last `step` on the app's clock, whatever the real time.
    pub fn set_frame_time(&mut self, step: Duration) {
        self.app.insert_resource(TimeUpdateStrategy::ManualDuration(step));
    }

    /// Runs one frame.
    ///
    /// # Errors
    /// If the renderer failed or the app asked to exit with an error.
    pub fn update(&mut self) -> Result<(), String> {
        self.app.update();
        if let Some(RenderFailure(message)) = self.app.world().get_resource() {
            return Err(format!("rendering failed on {}: {message}", self.adapter()));
        }
        match self.app.should_exit() {
            Some(AppExit::Error(code)) => Err(format!("the app exited with code {code}")),
            _ => Ok(()),
        }
    }

    /// Runs frames until `done` says so.
    ///
    /// # Errors
    /// As [`update`](Self::update), or if `patience` ran out; `what` names what was waited for.
    pub fn update_until(
        &mut self,
        what: &str,
        patience: Duration,
        mut done: impl FnMut(&mut World) -> bool,
    ) -> Result<(), String> {
        let start = Instant::now();
        loop {
            self.update()?;
            if done(self.app.world_mut()) {
                return Ok(());
            }
            if start.elapsed() > patience {
                return Err(format!("waited {patience:?} in vain for {what}"));
            }
        }
    }

    /// The image that cameras draw into.
    #[must_use]
    pub fn target(&self) -> RenderTarget {
        RenderTarget::from(self.target.clone())
    }

    /// Renders further frames until a picture of one of them, the first, has come back.
    ///
    /// # Errors
    /// As [`update`](Self::update), or if no picture comes.
    pub fn capture(&mut self) -> Result<Picture, String> {
        let capture = self.begin_capture(Screenshot::image(self.target.clone()));
        for _ in 0..SCREENSHOT_FRAMES {
            self.update()?;
            if let Some(picture) = self.captured(&capture) {
                return picture;
            }
        }
        Err(format!("no screenshot within {SCREENSHOT_FRAMES} frames on {}", self.adapter()))
    }

    /// Asks for a picture of the image, by a `Screenshot` or what becomes one.
    pub fn begin_capture(&mut self, screenshot: impl Bundle) -> Capture {
        let slot = Arc::new(Mutex::new(None));
        let filled = slot.clone();
        self.app.world_mut().spawn(screenshot).observe(move |captured: On<ScreenshotCaptured>| {
            let pixels = captured.image.data.clone().unwrap_or_default();
            *filled.lock().unwrap_or_else(|e| e.into_inner()) = Some(pixels);
        });
        Capture(slot)
    }

    /// Runs frames until a picture that was asked for is there.
    ///
    /// # Errors
    /// As [`update`](Self::update), or if `patience` runs out.
    pub fn finish_capture(
        &mut self,
        capture: &Capture,
        patience: Duration,
    ) -> Result<Picture, String> {
        let start = Instant::now();
        loop {
            if let Some(picture) = self.captured(capture) {
                return picture;
            }
            if start.elapsed() > patience {
                return Err(format!("waited {patience:?} in vain for a picture"));
            }
            self.update()?;
        }
    }

    fn captured(&self, Capture(slot): &Capture) -> Option<Result<Picture, String>> {
        let data = slot.lock().unwrap_or_else(|e| e.into_inner()).take()?;
        Some(Picture::from_rgba(self.size, &data))
    }
}

impl Headless {
    /// A picture of a scene that stands still: captures until two pictures in a row are equal and
    /// show something, since the first frames lack what is still loading.
    ///
    /// # Errors
    /// As [`capture`](Self::capture), or if the picture does not come to rest within 30 tries.
    pub fn capture_still(&mut self) -> Result<Picture, String> {
        let mut last = self.capture()?;
        for _ in 0..30 {
            let next = self.capture()?;
            if next == last && next.problem().is_none() {
                return Ok(next);
            }
            last = next;
        }
        let problem = last.problem().unwrap_or("not at rest");
        Err(format!("the picture is {problem} on {}", self.adapter()))
    }
}

/// Makes cameras that would draw into a window draw into the image.
fn redirect_cameras(target: Res<HeadlessTarget>, mut cameras: Query<&mut RenderTarget>) {
    for mut camera in &mut cameras {
        if matches!(*camera, RenderTarget::Window(_)) {
            *camera = RenderTarget::from(target.0.clone());
        }
    }
}

impl Picture {
    /// Takes four bytes a pixel; alpha is dropped.
    fn from_rgba(size: UVec2, data: &[u8]) -> Result<Self, String> {
        let pixels: Vec<[u8; 3]> = data.chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect();
        if pixels.len() != size.element_product() as usize {
            return Err(format!("the screenshot has {} pixels, not {size}", pixels.len()));
        }
        Ok(Self { width: size.x, height: size.y, pixels })
    }

    /// Mean of the three channels over all pixels, 0..=255.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let sum: u64 = self.pixels.iter().flatten().map(|&v| u64::from(v)).sum();
        sum as f64 / (self.pixels.len() * 3).max(1) as f64
    }

    /// Why this cannot be a picture of anything: black, or one colour all over.
    #[must_use]
    pub fn problem(&self) -> Option<&'static str> {
        let first = self.pixels.first()?;
        if self.pixels.iter().flatten().all(|&v| v < 4) {
            Some("black")
        } else if self.pixels.iter().all(|p| p == first) {
            Some("one colour all over")
        } else {
            None
        }
    }

    /// Writes a PNG file, and the folder that it lies in.
    ///
    /// # Errors
    /// What the file system says, with the path.
    pub fn save(&self, path: impl Into<PathBuf>) -> Result<(), String> {
        let path = path.into();
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        }
        image::save_buffer(
            &path,
            self.pixels.as_flattened(),
            self.width,
            self.height,
            image::ColorType::Rgb8,
        )
        .map_err(|e| format!("{}: {e}", path.display()))
    }
}

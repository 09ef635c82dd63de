//! Pictures of what both eyes see, as files.

use std::{
    path::PathBuf,
    sync::{
        Arc, Mutex,
        atomic::{AtomicU32, Ordering},
        mpsc::{Receiver, Sender, channel},
    },
};

use bevy::{
    core_pipeline::{Core3d, Core3dSystems, FullscreenShader},
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        gpu_readback::{Readback, ReadbackComplete},
        render_asset::RenderAssets,
        render_resource::{PipelineCache, TextureFormat, TextureUsages},
        renderer::{RenderContext, ViewQuery},
        texture::GpuImage,
        view::ViewTarget,
    },
    tasks::IoTaskPool,
};

use crate::{XrEye, show::Shower};

/// What files have.
const FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;
/// The GPU gives rows of a multiple of so many bytes.
const ALIGNMENT: usize = 256;
/// Frames after which a picture that did not come is given up.
const PATIENCE: u32 = 240;

/// Writes what both eyes see into a PNG file, side by side, the left eye on the left. One at a time; a
/// further one waits. [`XrScreenshotSaved`] tells when it is there.
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub struct XrScreenshot(
    /// The file; its folder is made if need be.
    pub PathBuf,
);

/// What became of an [`XrScreenshot`].
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub struct XrScreenshotSaved {
    /// The file.
    pub path: PathBuf,
    /// Its size in pixels, or what went wrong.
    pub size: Result<UVec2, String>,
}

pub(crate) fn build(app: &mut App) {
    let (sender, receiver) = channel();
    app.add_message::<XrScreenshot>().add_message::<XrScreenshotSaved>().insert_resource(Shots {
        current: None,
        waiting: Vec::new(),
        sender,
        receiver: Mutex::new(receiver),
    });
    if app.get_sub_app(RenderApp).is_none() {
        return;
    }
    app.add_plugins(ExtractComponentPlugin::<CopyInto>::default()).add_systems(Last, take);
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app
            .add_systems(Render, prepare.in_set(RenderSystems::Prepare))
            .add_systems(Core3d, copy.after(Core3dSystems::PostProcess));
    }
}

#[derive(Resource)]
struct Shots {
    current: Option<Shot>,
    waiting: Vec<PathBuf>,
    sender: Sender<XrScreenshotSaved>,
    receiver: Mutex<Receiver<XrScreenshotSaved>>,
}

/// A picture that is being taken.
struct Shot {
    path: PathBuf,
    eyes: [Entity; 2],
    images: [Handle<Image>; 2],
    size: UVec2,
    /// Frames that each eye has copied.
    copied: Arc<[AtomicU32; 2]>,
    readers: Option<[Entity; 2]>,
    answers: Arc<Mutex<[Option<Vec<u8>>; 2]>>,
    frames: u32,
}

/// Where an eye's pictures go while one is being taken.
#[derive(Component, Clone, ExtractComponent)]
struct CopyInto {
    image: Handle<Image>,
    copied: Arc<[AtomicU32; 2]>,
}

fn take(
    mut wishes: MessageReader<XrScreenshot>,
    mut saved: MessageWriter<XrScreenshotSaved>,
    mut shots: ResMut<Shots>,
    mut images: ResMut<Assets<Image>>,
    cameras: Query<(Entity, &XrEye, &Camera)>,
    mut commands: Commands,
) {
    let done = shots.receiver.get_mut().map(|r| r.try_iter().collect()).unwrap_or_else(|_| vec![]);
    saved.write_batch(done);
    shots.waiting.extend(wishes.read().map(|XrScreenshot(path)| path.clone()));
    if shots.current.is_none() && !shots.waiting.is_empty() {
        let path = shots.waiting.remove(0);
        match begin(path.clone(), &cameras, &mut images, &mut commands) {
            Ok(shot) => shots.current = Some(shot),
            Err(reason) => {
                warn!("no picture of the headset: {reason}");
                saved.write(XrScreenshotSaved { path, size: Err(reason) });
            }
        }
    }
    let Shots { current, sender, .. } = &mut *shots;
    let Some(shot) = current else { return };
    shot.frames += 1;
    // Both are read in one frame, after both have been drawn at least once.
    if shot.readers.is_none() && shot.copied.iter().all(|n| n.load(Ordering::Relaxed) > 0) {
        shot.readers = Some(std::array::from_fn(|eye| {
            let answers = shot.answers.clone();
            let read = move |answer: On<ReadbackComplete>| {
                if let Ok(mut answers) = answers.lock() {
                    answers[eye].get_or_insert_with(|| answer.data.clone());
                }
            };
            commands.spawn(Readback::texture(shot.images[eye].clone())).observe(read).id()
        }));
    }
    let answers = shot.answers.lock().ok().and_then(|mut answers| {
        let complete = answers.iter().all(Option::is_some);
        complete.then(|| std::mem::take(&mut *answers).map(Option::unwrap_or_default))
    });
    if answers.is_none() && shot.frames < PATIENCE {
        return;
    }
    let Some(shot) = current.take() else { return };
    for reader in shot.readers.into_iter().flatten() {
        commands.entity(reader).try_despawn();
    }
    for (eye, image) in shot.eyes.into_iter().zip(&shot.images) {
        commands.entity(eye).try_remove::<CopyInto>();
        images.remove(image);
    }
    let (path, size) = (shot.path, shot.size);
    let Some(answers) = answers else {
        let size = Err(format!("no picture within {PATIENCE} frames"));
        saved.write(XrScreenshotSaved { path, size });
        return;
    };
    let sender = sender.clone();
    IoTaskPool::get()
        .spawn(async move {
            let size = save(&path, size, &answers);
            match &size {
                Ok(_) => info!("what the eyes see is in {}", path.display()),
                Err(problem) => warn!("{}: {problem}", path.display()),
            }
            // Nobody listens any more when the app has ended.
            let _ = sender.send(XrScreenshotSaved { path, size });
        })
        .detach();
}

fn begin(
    path: PathBuf,
    cameras: &Query<(Entity, &XrEye, &Camera)>,
    images: &mut Assets<Image>,
    commands: &mut Commands,
) -> Result<Shot, String> {
    let eye = |index: u32| {
        let found = cameras.iter().find(|(_, eye, _)| eye.index == index);
        let (entity, _, camera) = found.ok_or("no eye sees anything")?;
        if !camera.is_active {
            return Err("the headset shows nothing now");
        }
        let size = camera.physical_target_size().ok_or("the eyes have no pictures yet")?;
        Ok((entity, size))
    };
    let [(left, size), (right, _)] = [eye(0)?, eye(1)?];
    let copied = Arc::new([AtomicU32::new(0), AtomicU32::new(0)]);
    let images = [left, right].map(|eye| {
        let mut image = Image::new_target_texture(size.x, size.y, FORMAT, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let image = images.add(image);
        commands.entity(eye).insert(CopyInto { image: image.clone(), copied: copied.clone() });
        image
    });
    Ok(Shot {
        path,
        eyes: [left, right],
        images,
        size,
        copied,
        readers: None,
        answers: Arc::default(),
        frames: 0,
    })
}

/// Joins both and writes the file. Gives its size.
fn save(path: &std::path::Path, size: UVec2, eyes: &[Vec<u8>; 2]) -> Result<UVec2, String> {
    let (width, height) = (size.x as usize, size.y as usize);
    let row_bytes = (width * 4).next_multiple_of(ALIGNMENT);
    let mut pixels = Vec::with_capacity(width * 2 * height * 3);
    for y in 0..height {
        for eye in eyes {
            let row = eye.get(y * row_bytes..y * row_bytes + width * 4);
            let row = row.ok_or("the graphics device gave half a picture")?;
            pixels.extend(row.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]));
        }
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| error.to_string())?;
    }
    let both = UVec2::new(size.x * 2, size.y);
    image::save_buffer(path, &pixels, both.x, both.y, image::ColorType::Rgb8)
        .map_err(|error| error.to_string())?;
    Ok(both)
}

fn prepare(
    mut shower: ResMut<Shower>,
    cache: Res<PipelineCache>,
    server: Res<AssetServer>,
    fullscreen: Res<FullscreenShader>,
    wanted: Query<(), With<CopyInto>>,
) {
    if !wanted.is_empty() {
        shower.pipeline(FORMAT, &cache, &server, &fullscreen);
    }
}

fn copy(
    view: ViewQuery<(&XrEye, &CopyInto, &ViewTarget)>,
    images: Res<RenderAssets<GpuImage>>,
    shower: Res<Shower>,
    cache: Res<PipelineCache>,
    mut context: RenderContext,
) {
    let (eye, into, target) = view.into_inner();
    let Some(image) = images.get(&into.image) else { return };
    let into_view = (&image.texture_view, FORMAT);
    let all = Vec4::new(1.0, 1.0, 0.0, 0.0);
    if shower.show(&mut context, &cache, target.main_texture_view(), all, into_view)
        && let Some(count) = into.copied.get(eye.index as usize)
    {
        count.fetch_add(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_eyes_are_side_by_side() {
        let size = UVec2::new(3, 2);
        let eye = |value: u8| vec![value; 2 * ALIGNMENT];
        let path = std::env::temp_dir().join(format!("farlight_xr_{}.png", std::process::id()));
        assert_eq!(save(&path, size, &[eye(10), eye(200)]), Ok(UVec2::new(6, 2)));
        let read = image::open(&path).unwrap().to_rgb8();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(read.dimensions(), (6, 2));
        assert_eq!((read.get_pixel(2, 1).0, read.get_pixel(3, 1).0), ([10; 3], [200; 3]));
        assert!(save(&path, size, &[eye(10), vec![0; 7]]).is_err());
    }
}

//! What a frame of the controls takes: no memory, once it is warm, and the same time whatever devices
//! do. Alone in its program, for it counts what the program allocates.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    time::Duration,
};

use bevy::{
    ecs::schedule::SingleThreadedExecutor,
    input::{InputPlugin, InputSystems},
    prelude::*,
    time::TimeUpdateStrategy,
};
use farlight::controls::{
    ControlsPlugin, ControlsSystems, UserFile, XrControllers,
    bevy_enhanced_input::prelude::EnhancedInputSystems,
};
use farlight_bindings::{Hand, Profile, Xr};

struct Counting;

/// Whose systems run.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Whose {
    /// The engine's, or nobody's.
    Others,
    /// Ours: devices become values of actions.
    Sampling,
    /// Those of `bevy_enhanced_input`: values become actions.
    Enhanced,
    /// Ours again: what actions say is announced and recorded.
    Announcing,
}

/// Allocations of all threads.
static EVERYWHERE: AtomicUsize = AtomicUsize::new(0);
/// Who counts those is alone.
static ALONE: Mutex<()> = Mutex::new(());

thread_local! {
    static NOW: Cell<Whose> = const { Cell::new(Whose::Others) };
    /// Allocations of this thread and their bytes, by whose systems ran.
    static COUNTED: Cell<[[usize; 2]; 4]> = const { Cell::new([[0; 2]; 4]) };
}

fn note(bytes: usize) {
    EVERYWHERE.fetch_add(1, Ordering::Relaxed);
    let mut counted = COUNTED.get();
    let [count, all] = &mut counted[NOW.get() as usize];
    *count += 1;
    *all += bytes;
    COUNTED.set(counted);
}

// SAFETY: it passes everything on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        // SAFETY: the caller keeps the promises of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note(size);
        // SAFETY: the caller keeps the promises of `realloc`.
        unsafe { System.realloc(old, layout, size) }
    }

    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the promises of `dealloc`.
        unsafe { System.dealloc(old, layout) }
    }
}

#[global_allocator]
static GLOBAL: Counting = Counting;

/// An app without a window, with controls or without, whose systems run as Bevy likes.
fn plain(controls: bool) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), InputPlugin));
    let frame = Duration::from_millis(16);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    if controls {
        let user_file = UserFile::Nowhere;
        app.add_plugins(ControlsPlugin { gamepads: false, user_file, ..default() });
    }
    app.finish();
    app.cleanup();
    app
}

/// An app whose systems run in one thread, in order: what lies between these is whose it says.
fn app() -> App {
    let mut app = plain(true);
    let now = |whose: Whose| move || NOW.set(whose);
    app.add_systems(
        PreUpdate,
        (
            before.after(InputSystems),
            now(Whose::Sampling).after(before).before(ControlsSystems::Sample),
            now(Whose::Enhanced)
                .after(ControlsSystems::Sample)
                .before(EnhancedInputSystems::Update),
            now(Whose::Announcing)
                .after(EnhancedInputSystems::Apply)
                .before(ControlsSystems::Announce),
            now(Whose::Others).after(ControlsSystems::Announce),
        ),
    );
    app.edit_schedule(PreUpdate, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
    });
    app
}

/// What a frame allocated: count and bytes, by whose systems ran.
fn frame(app: &mut App) -> [[usize; 2]; 4] {
    COUNTED.set([[0; 2]; 4]);
    app.update();
    COUNTED.get()
}

fn of(counted: [[usize; 2]; 4], whose: Whose) -> usize {
    counted[whose as usize][0]
}

#[test]
fn a_warm_frame_allocates_nothing_of_ours() {
    let _alone = ALONE.lock().unwrap_or_else(|e| e.into_inner());
    let mut app = app();
    let mut counts = Vec::new();
    for number in 0..400_u32 {
        use_devices(&mut app, number);
        counts.push(frame(&mut app));
    }
    // Each device has been used in the first half.
    let ours = |counted: &[[usize; 2]; 4]| of(*counted, Whose::Sampling);
    assert!(counts[200..].iter().all(|counted| ours(counted) == 0), "{counts:?}");
    assert!(ours(&counts[0]) > 0, "the first frame compiles the bindings: something is counted");
    // What actions said stands in messages for two frames: their buffers grow, and then no more.
    let announced = |counted: &[[usize; 2]; 4]| of(*counted, Whose::Announcing);
    assert!(counts[200..].iter().all(|counted| announced(counted) == 0), "{counts:?}");
}

#[test]
fn an_idle_frame_allocates_nothing_but_tasks() {
    let _alone = ALONE.lock().unwrap_or_else(|e| e.into_inner());
    let mut one_thread = app();
    let counted = (0..100).map(|_| frame(&mut one_thread)).last().unwrap();
    for whose in [Whose::Sampling, Whose::Enhanced, Whose::Announcing] {
        assert_eq!(of(counted, whose), 0, "{whose:?} of {counted:?}");
    }
    // On several threads each system that runs is a task of Bevy's executor, with an allocation.
    let [with, without] = [true, false].map(|controls| {
        let mut app = plain(controls);
        (0..100).for_each(|_| app.update());
        let before = EVERYWHERE.load(Ordering::Relaxed);
        (0..100).for_each(|_| app.update());
        (EVERYWHERE.load(Ordering::Relaxed) - before) as f64 / 100.0
    });
    println!("a frame on several threads allocates {with} times with controls, {without} without");
    assert!(with - without < 16.0, "{with} with controls, {without} without");
}

/// Where counting begins, at the earliest.
fn before() {}

/// Keys go down and up, a controller moves.
fn use_devices(app: &mut App, frame: u32) {
    let mut keys = app.world_mut().resource_mut::<ButtonInput<KeyCode>>();
    for (at, key) in [KeyCode::KeyW, KeyCode::ArrowRight, KeyCode::ShiftLeft].iter().enumerate() {
        if frame >> (at + 2) & 1 == 0 {
            keys.press(*key);
        } else {
            keys.release(*key);
        }
    }
    let turn = Vec2::from_angle(frame as f32 * 0.1);
    let mut hands = app.world_mut().resource_mut::<XrControllers>();
    for hand in Hand::ALL {
        hands.hand_mut(hand).profile = Some(Profile::Touch);
        hands.hand_mut(hand).values.insert(Xr::Stick, turn);
    }
}

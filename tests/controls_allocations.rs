//! What a frame of the controls takes: no memory, once it is warm, and the same time whatever devices
//! do. Alone in its program, for it counts what the program allocates.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
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

thread_local! {
    /// Allocations of this thread, while our systems run.
    static COUNTED: Cell<u64> = const { Cell::new(0) };
    static COUNTING: Cell<bool> = const { Cell::new(false) };
}

fn note() {
    if COUNTING.get() {
        COUNTED.set(COUNTED.get() + 1);
    }
}

// SAFETY: it passes everything on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note();
        // SAFETY: the caller keeps the promises of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note();
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

#[test]
fn a_warm_frame_allocates_nothing() {
    let mut app = App::new();
    let controls = ControlsPlugin { gamepads: false, user_file: UserFile::Nowhere, ..default() };
    let frame = Duration::from_millis(16);
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), InputPlugin, controls))
        .insert_resource(TimeUpdateStrategy::ManualDuration(frame))
        // Systems of one thread, in order: what lies between these two is ours.
        .edit_schedule(PreUpdate, |schedule| {
            schedule.set_executor(SingleThreadedExecutor::new());
        })
        .add_systems(
            PreUpdate,
            (
                (|| COUNTING.set(true)).before(ControlsSystems::Sample).after(before),
                (|| COUNTING.set(false))
                    .after(ControlsSystems::Sample)
                    .before(EnhancedInputSystems::Update),
                before.after(InputSystems),
            ),
        );
    app.finish();
    app.cleanup();
    let mut counts = Vec::new();
    for frame in 0..400_u32 {
        use_devices(&mut app, frame);
        COUNTED.set(0);
        app.update();
        counts.push(COUNTED.get());
    }
    // Each device has been used in the first half.
    let warm = &counts[200..];
    assert!(warm.iter().all(|count| *count == 0), "{warm:?}");
    assert!(counts[0] > 0, "the first frame compiles the bindings: something is counted");
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

//! Whether there is a runtime with a headset. It is asked before anything else, so that without one
//! nothing of it runs.

#[cfg(target_os = "linux")]
use std::path::PathBuf;

use bevy::prelude::*;
use openxr::{
    ApplicationInfo, Entry, EnvironmentBlendMode, ExtensionSet, FormFactor, ViewConfigurationType,
    sys,
};

/// What was found.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    /// The runtime's name.
    pub(crate) runtime: String,
    /// Pixels of an eye.
    recommended: UVec2,
    max: UVec2,
    blend_modes: Vec<EnvironmentBlendMode>,
    pub(crate) hand_interaction: bool,
    pub(crate) local_floor: bool,
}

impl Found {
    /// Pixels of an eye's picture.
    pub(crate) fn resolution(&self, scale: f32) -> UVec2 {
        let scaled = (self.recommended.as_vec2() * scale).round().as_uvec2();
        scaled.clamp(UVec2::ONE, self.max.max(UVec2::ONE))
    }

    /// How pictures are put together with the real room: what was asked for, then what there is.
    pub(crate) fn blend_modes(&self, see_through: bool) -> Vec<EnvironmentBlendMode> {
        let mut modes = if see_through {
            vec![EnvironmentBlendMode::ALPHA_BLEND, EnvironmentBlendMode::ADDITIVE]
        } else {
            vec![EnvironmentBlendMode::OPAQUE]
        };
        modes.extend(&self.blend_modes);
        modes
    }
}

/// Asks.
pub(crate) fn find(app_name: &str) -> Result<Found, String> {
    #[cfg(target_os = "linux")]
    manifest()?;
    #[cfg(windows)]
    let entry = Entry::linked();
    #[cfg(not(windows))]
    // SAFETY: what is loaded is the system's OpenXR loader, which keeps to the interface.
    let entry = unsafe { Entry::load() }
        .map_err(|error| format!("no OpenXR loader is installed ({error})"))?;
    #[cfg(target_os = "android")]
    entry.initialize_android_loader().map_err(|error| problem("it does not start", error))?;

    let extensions =
        entry.enumerate_extensions().map_err(|error| problem("no OpenXR runtime", error))?;
    if !extensions.khr_vulkan_enable2 {
        return Err("the OpenXR runtime doesn't draw with Vulkan".into());
    }
    let mut enabled = ExtensionSet::default();
    enabled.khr_vulkan_enable2 = true;
    let application = ApplicationInfo {
        application_name: app_name,
        application_version: 1,
        engine_name: "Bevy",
        engine_version: 0,
        api_version: openxr::Version::new(1, 0, 34),
    };
    let instance = entry
        .create_instance(&application, &enabled, &[])
        .map_err(|error| problem("the OpenXR runtime does not start", error))?;
    let runtime = instance.properties().map(|p| p.runtime_name).unwrap_or_default();
    let failed = |error| problem(&format!("{runtime} has no headset that can be used"), error);
    let system =
        instance.system(FormFactor::HEAD_MOUNTED_DISPLAY).map_err(|error| match error {
            sys::Result::ERROR_FORM_FACTOR_UNAVAILABLE => {
                format!("{runtime} says that no headset is connected")
            }
            error => failed(error),
        })?;
    let stereo = ViewConfigurationType::PRIMARY_STEREO;
    let views = instance.enumerate_view_configuration_views(system, stereo).map_err(failed)?;
    let [view, _] = views[..] else {
        return Err(format!("{runtime}'s display has {} eyes", views.len()));
    };
    let blend_modes = instance.enumerate_environment_blend_modes(system, stereo).map_err(failed)?;
    Ok(Found {
        recommended: UVec2::new(
            view.recommended_image_rect_width,
            view.recommended_image_rect_height,
        ),
        max: UVec2::new(view.max_image_rect_width, view.max_image_rect_height),
        blend_modes,
        hand_interaction: extensions.ext_hand_interaction,
        local_floor: extensions.ext_local_floor,
        runtime,
    })
}

fn problem(what: &str, error: sys::Result) -> String {
    format!("{what} ({error})")
}

/// Whether a runtime is installed at all: the loader would complain on its own.
#[cfg(target_os = "linux")]
fn manifest() -> Result<(), String> {
    let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    if let Some(path) = variable("XR_RUNTIME_JSON") {
        let path = PathBuf::from(path);
        let missing = format!("XR_RUNTIME_JSON names {}, which is not there", path.display());
        return if path.exists() { Ok(()) } else { Err(missing) };
    }
    let home = variable("HOME").map(|home| PathBuf::from(home).join(".config"));
    let mut folders: Vec<PathBuf> =
        variable("XDG_CONFIG_HOME").map(PathBuf::from).or(home).into_iter().collect();
    match variable("XDG_CONFIG_DIRS") {
        Some(list) => folders.extend(std::env::split_paths(&list)),
        None => folders.push("/etc/xdg".into()),
    }
    folders.extend(["/usr/local/etc", "/etc"].map(PathBuf::from));
    // The loader knows a file per architecture, too: active_runtime.x86_64.json.
    let is_there = |folder: &PathBuf| {
        std::fs::read_dir(folder.join("openxr/1")).is_ok_and(|entries| {
            entries
                .flatten()
                .any(|entry| entry.file_name().to_string_lossy().starts_with("active_runtime"))
        })
    };
    if folders.iter().any(is_there) { Ok(()) } else { Err("no OpenXR runtime is installed".into()) }
}

//! The suite's WGSL modules as assets of the app.

use std::path::{Path, PathBuf};

use bevy::{
    asset::{UntypedHandle, io::embedded::EmbeddedAssetRegistry},
    prelude::*,
    shader::Shader,
};

/// Keeps the modules loaded: a shader that imports a module waits for it without a word.
#[derive(Resource)]
struct ShaderModules {
    _handles: Vec<UntypedHandle>,
}

/// Where a module of `shaders/` is found: `shader_path("btf/material.wgsl")`.
pub fn shader_path(module: &str) -> String {
    format!("embedded://farlight/shaders/{module}")
}

/// Registers and loads all modules. Without assets or without rendering, nothing happens.
pub(crate) fn build(app: &mut App) {
    let Some(registry) = app.world().get_resource::<EmbeddedAssetRegistry>() else {
        return;
    };
    for module in farlight_shaders::MODULES {
        // Under a name of our own: the source's path would leave the crate, and Bevy refuses that.
        let watched = PathBuf::from("shaders").join(module.path);
        let name = Path::new("farlight/shaders").join(module.path);
        registry.insert_asset(watched, &name, module.source.as_bytes());
    }
    if !app.world().contains_resource::<Assets<Shader>>() {
        return;
    }
    let server = app.world().resource::<AssetServer>();
    let handles = farlight_shaders::MODULES
        .iter()
        .map(|module| server.load::<Shader>(shader_path(module.path)).untyped())
        .collect();
    app.insert_resource(ShaderModules { _handles: handles });
}

//! Measured materials in Bevy: a [`BtfMaterial`] shows a surface as it was measured for every
//! direction of light and view, decoded in the shader from a few megabytes.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use farlight_btf::{BtfMaterial, BtfPlugin};
//!
//! fn setup(
//!     mut commands: Commands,
//!     server: Res<AssetServer>,
//!     mut meshes: ResMut<Assets<Mesh>>,
//!     mut materials: ResMut<Assets<BtfMaterial>>,
//! ) {
//!     commands.spawn((
//!         Mesh3d(meshes.add(Sphere::default())),
//!         MeshMaterial3d(materials.add(BtfMaterial {
//!             repeat: Vec2::new(8.0, 4.0),
//!             ..BtfMaterial::new(server.load("materials/cloth.fbtf"))
//!         })),
//!     ));
//! }
//!
//! App::new().add_plugins((DefaultPlugins, BtfPlugin)).add_systems(Startup, setup).run();
//! ```

mod asset;
mod material;

use bevy::prelude::*;

pub use asset::BtfAsset;
pub use material::{BtfFilter, BtfMaterial};

/// Adds [`BtfMaterial`] and the loader of material files.
#[derive(Clone, Copy, Debug, Default)]
pub struct BtfPlugin;

impl Plugin for BtfPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<BtfAsset>().init_asset::<BtfMaterial>();
    }
}

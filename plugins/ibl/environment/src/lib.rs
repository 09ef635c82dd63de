//! Light from far away: reads environment maps, and turns them into directional lights.
//!
//! An [`Environment`] is an equirectangular map of linear Rec. 709 radiance, whatever it was read
//! from. [`Environment::lights`] replaces it by N [`EnvironmentLight`]s whose sum lights a surface as
//! the map does. This crate knows no engine.
//!
//! ```
//! use farlight_environment::{Environment, LightRequest, measure};
//! use glam::Vec3;
//!
//! let sky = Environment::from_equirect(4, 2, vec![Vec3::ONE; 8])?;
//! let lights = sky.lights(&LightRequest { count: 200, ..Default::default() });
//! let (lit, exact) = (measure::irradiance(&lights, Vec3::Y), sky.irradiance(Vec3::Y));
//! assert!((exact.x - std::f32::consts::PI).abs() < 1e-3);
//! assert!((lit - exact).length() < 0.01 * exact.length());
//! # Ok::<(), farlight_environment::EnvironmentError>(())
//! ```

mod cache;
mod environment;
mod error;
mod layout;
mod lights;
pub mod measure;
mod prefilter;
mod projection;
mod random;
mod read;
mod shrink;
mod sphere;
mod unroll;

pub use cache::LightCache;
pub use environment::{Environment, Repairs};
pub use error::EnvironmentError;
pub use layout::Layout;
pub use lights::{EnvironmentLight, LightExtractor, LightRequest, Method, UnknownName};
pub use prefilter::CubeMap;

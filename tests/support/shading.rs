//! What Bevy's `StandardMaterial` reflects of a directional light, on the CPU: the twin of
//! `directional_light` in `bevy_pbr-0.19.1/src/render/pbr_lighting.wgsl`, in double precision.
//!
//! Diffuse: B. Burley, *Physically-based shading at Disney*, SIGGRAPH 2012 course. Specular: GGX with
//! the height-correlated Smith term, Schlick's Fresnel and a factor for scattering between facets; the
//! formulas are those of <https://google.github.io/filament/Filament.md.html>, sections 4.4 to 4.7.

use std::{f64::consts::PI, fmt};

use bevy::{math::DVec3, prelude::*};

/// How a surface reflects; colours are linear Rec. 709.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// The same radiance into every direction: a BTF of constant value.
    Lambert {
        /// Reflected share, 0..=1.
        albedo: DVec3,
    },
    /// Bevy's material.
    Standard {
        /// Diffuse or, of a metal, specular colour, 0..=1.
        base_color: DVec3,
        /// 0: dielectric, 1: metal.
        metallic: f64,
        /// Square root of GGX's alpha, 0..=1; below 0.089 it counts as that.
        perceptual_roughness: f64,
        /// Specular strength of a dielectric; 0.5 is 4 % at normal incidence.
        reflectance: f64,
    },
}

impl Surface {
    /// A grey `StandardMaterial` with Bevy's default reflectance.
    pub fn standard(perceptual_roughness: f64, metallic: f64) -> Self {
        Self::Standard {
            base_color: DVec3::splat(0.8),
            metallic,
            perceptual_roughness,
            reflectance: 0.5,
        }
    }

    /// The same surface for Bevy; Lambert's cannot be had.
    pub fn bevy(&self) -> Option<StandardMaterial> {
        let Self::Standard { base_color, metallic, perceptual_roughness, reflectance } = *self
        else {
            return None;
        };
        Some(StandardMaterial {
            base_color: Color::from(LinearRgba::from_vec3(base_color.as_vec3())),
            metallic: metallic as f32,
            perceptual_roughness: perceptual_roughness as f32,
            reflectance: reflectance as f32,
            ..default()
        })
    }
}

impl fmt::Display for Surface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lambert { albedo } => write!(f, "Lambert {albedo}"),
            Self::Standard { base_color, metallic, perceptual_roughness, reflectance } => write!(
                f,
                "roughness {perceptual_roughness}, metallic {metallic}, reflectance {reflectance}, \
                 colour {base_color}"
            ),
        }
    }
}

/// Radiance towards `view` of a surface under one directional light. All directions are unit vectors
/// that point away from the surface; `irradiance` is on a plane that faces the light.
pub fn shade(
    surface: &Surface,
    normal: DVec3,
    view: DVec3,
    light: DVec3,
    irradiance: DVec3,
) -> DVec3 {
    Reflection::new(surface, normal, view).towards_view(light) * irradiance
}

/// A point of a surface, seen from one direction.
#[derive(Clone, Copy, Debug)]
pub struct Reflection {
    normal: DVec3,
    view: DVec3,
    n_dot_v: f64,
    diffuse: DVec3,
    specular: Option<Specular>,
}

#[derive(Clone, Copy, Debug)]
struct Specular {
    /// GGX's alpha.
    roughness: f64,
    f0: DVec3,
    f90: f64,
    /// What light that facets reflect more than once adds.
    multiple: DVec3,
}

impl Reflection {
    /// As [`shade`] takes them.
    pub fn new(surface: &Surface, normal: DVec3, view: DVec3) -> Self {
        let n_dot_v = normal.dot(view).max(1e-4);
        let (diffuse, specular) = match *surface {
            Surface::Lambert { albedo } => (albedo, None),
            Surface::Standard { base_color, metallic, perceptual_roughness, reflectance } => {
                let f0 = DVec3::splat(0.16 * reflectance * reflectance);
                let f0 = f0.lerp(base_color, metallic);
                let specular = Specular {
                    roughness: perceptual_roughness.clamp(0.089, 1.0).powi(2),
                    f0,
                    f90: f0.dot(DVec3::splat(50.0 * 0.33)).clamp(0.0, 1.0),
                    multiple: 1.0
                        + f0 * (1.0 / albedo_of_white(perceptual_roughness, n_dot_v) - 1.0),
                };
                (base_color * (1.0 - metallic), Some(specular))
            }
        };
        Self { normal, view, n_dot_v, diffuse, specular }
    }

    /// Radiance for an irradiance of 1 on a plane that faces the light: the BRDF times the cosine.
    pub fn towards_view(&self, light: DVec3) -> DVec3 {
        let n_dot_l = self.normal.dot(light).min(1.0);
        if n_dot_l <= 0.0 {
            return DVec3::ZERO;
        }
        let Some(Specular { roughness, f0, f90, multiple }) = self.specular else {
            return self.diffuse * (n_dot_l / PI);
        };
        let half = (light + self.view).normalize();
        let n_dot_h = self.normal.dot(half).clamp(0.0, 1.0);
        let l_dot_h = light.dot(half).clamp(0.0, 1.0);
        let n_dot_v = self.n_dot_v;

        let grazing = 0.5 + 2.0 * roughness * l_dot_h * l_dot_h;
        let burley = schlick(1.0, grazing, n_dot_l) * schlick(1.0, grazing, n_dot_v) / PI;

        let alpha2 = roughness * roughness;
        let slope = 1.0 - n_dot_h * n_dot_h + alpha2 * n_dot_h * n_dot_h;
        let distribution = alpha2 / (PI * slope * slope);
        let lambda_v = n_dot_l * ((n_dot_v - alpha2 * n_dot_v) * n_dot_v + alpha2).sqrt();
        let lambda_l = n_dot_v * ((n_dot_l - alpha2 * n_dot_l) * n_dot_l + alpha2).sqrt();
        let visibility = 0.5 / (lambda_v + lambda_l);
        let fresnel = f0 + (f90 - f0) * fifth(1.0 - l_dot_h);
        (self.diffuse * burley + distribution * visibility * fresnel * multiple) * n_dot_l
    }
}

fn schlick(f0: f64, f90: f64, cosine: f64) -> f64 {
    f0 + (f90 - f0) * fifth(1.0 - cosine)
}

fn fifth(v: f64) -> f64 {
    (v * v) * (v * v) * v
}

/// Share of light that a white GGX surface reflects in one bounce: `F_AB(..).x + F_AB(..).y`, Bevy's
/// fit without its feature `dfg_lut` (B. Karis, *Physically based shading on mobile*, 2014).
fn albedo_of_white(perceptual_roughness: f64, n_dot_v: f64) -> f64 {
    let along = |c0: f64, c1: f64| perceptual_roughness * c0 + c1;
    let (x, y) = (along(-1.0, 1.0), along(-0.0275, 0.0425));
    let (z, w) = (along(-0.572, 1.04), along(0.022, -0.04));
    let a004 = (x * x).min((-9.28 * n_dot_v).exp2()) * x + y;
    (-1.04 * a004 + z).max(5e-5) + (1.04 * a004 + w).max(5e-5)
}

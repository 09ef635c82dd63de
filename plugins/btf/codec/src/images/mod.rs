//! A material as it was measured: a picture for each pair of directions of view and light.

mod hemisphere;
mod resample;
mod store;

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, LazyLock};

use glam::Vec3;
use rayon::prelude::*;

use self::hemisphere::Hemisphere;
use self::store::Store;
use crate::{Angles, BtfError, Info, Query, linear, srgb_encode};

pub use resample::Resampled;
pub use store::Picture;
pub(crate) use store::Source;

/// A direction above the surface, kept to a hundred thousandth of a degree.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Direction {
    theta: u32,
    phi: u32,
}

/// Parts of a degree.
const UNIT: f64 = 1e5;

impl Direction {
    /// `theta` is within 0 to 90 degrees; `phi` is wrapped, and 0 at the pole.
    pub(crate) fn from_degrees(theta: f64, phi: f64) -> Self {
        let theta = (theta.clamp(0.0, 90.0) * UNIT).round() as u32;
        let phi = (phi.rem_euclid(360.0) * UNIT).round() as u32 % (360.0 * UNIT) as u32;
        Self { theta, phi: if theta == 0 { 0 } else { phi } }
    }

    fn from_radians(theta: f32, phi: f32) -> Self {
        Self::from_degrees(f64::from(theta).to_degrees(), f64::from(phi).to_degrees())
    }

    /// In radians, as [`Angles::from_degrees`] would have it.
    fn theta(&self) -> f32 {
        (f64::from(self.theta) / UNIT).to_radians() as f32
    }

    /// In radians, as [`Angles::from_degrees`] would have it.
    fn phi(&self) -> f32 {
        (f64::from(self.phi) / UNIT).to_radians() as f32
    }

    fn vector(&self) -> Vec3 {
        let (sin, cos) = self.theta().sin_cos();
        Vec3::new(sin * self.phi().cos(), sin * self.phi().sin(), cos)
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {})", f64::from(self.theta) / UNIT, f64::from(self.phi) / UNIT)
    }
}

impl fmt::Debug for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Measured pictures, read from where they lie when they are needed. A bounded number of them stays
/// in memory.
///
/// Between measured directions, linear light is interpolated: first between views, then for each
/// between its lights. Where directions form rings of equal elevation, as those of the Bonn
/// measurements do, that is linear in the elevation and along each ring; without a sample at the
/// pole the mean of the first ring stands there. Else samples are weighted by distance within a
/// reach (Franke and Nielson 1980). Both are continuous and exact at the samples.
///
/// A view beyond the outermost one counts as that far from the normal. Light from beyond the
/// outermost one looks as from there, and falls off with the cosine, as what arrives does: to black
/// at 90 degrees.
pub struct ImageBtf {
    info: Info,
    views: Hemisphere,
    /// For each view, which of `lights` it has, and the picture of each.
    of_view: Vec<(usize, Vec<u32>)>,
    lights: Vec<Hemisphere>,
    light_count: usize,
    store: Store,
}

impl ImageBtf {
    /// Of pictures with their directions of light and view.
    pub(crate) fn new(
        mut info: Info,
        directions: &[[Direction; 2]],
        source: Source,
    ) -> Result<Self, BtfError> {
        let mut by_view: BTreeMap<Direction, BTreeMap<Direction, u32>> = BTreeMap::new();
        for (picture, [light, view]) in (0..).zip(directions) {
            if by_view.entry(*view).or_default().insert(*light, picture).is_some() {
                return Err(BtfError::Tables(format!(
                    "two pictures for the light {light} and the view {view}"
                )));
            }
        }
        if by_view.is_empty() {
            return Err(BtfError::Tables("no pictures".to_owned()));
        }
        let views: Vec<Direction> = by_view.keys().copied().collect();
        let mut arrangements: BTreeMap<Vec<Direction>, usize> = BTreeMap::new();
        let mut lights = Vec::new();
        let mut of_view = Vec::with_capacity(views.len());
        let mut light_count = 0;
        for pictures in by_view.into_values() {
            let directions: Vec<Direction> = pictures.keys().copied().collect();
            light_count = light_count.max(directions.len());
            let arrangement = *arrangements.entry(directions).or_insert_with_key(|directions| {
                lights.push(Hemisphere::new(directions));
                lights.len() - 1
            });
            of_view.push((arrangement, pictures.into_values().collect()));
        }
        info.measured = Some([views.len() as u32, light_count as u32]);
        let store = Store::new(source)?;
        Ok(Self { info, views: Hemisphere::new(&views), of_view, lights, light_count, store })
    }

    /// What is known of the material.
    pub fn info(&self) -> &Info {
        &self.info
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        self.store.size()
    }

    /// Numbers of directions of view, and of light for one view at most.
    pub fn directions(&self) -> [usize; 2] {
        [self.of_view.len(), self.light_count]
    }

    /// Number of pictures.
    pub fn pictures(&self) -> usize {
        self.of_view.iter().map(|(_, pictures)| pictures.len()).sum()
    }

    /// How many rings of equal elevation the views and the lights of the first view form; none
    /// where they are scattered.
    pub fn rings(&self) -> [Option<usize>; 2] {
        let lights = self.of_view.first().map(|(lights, _)| &self.lights[*lights]);
        [self.views.ring_count(), lights.and_then(Hemisphere::ring_count)]
    }

    /// The value of the texel in column `x` and row `y` (both wrap round): red, green and blue,
    /// gamma-encoded, 0 to 255, with the cosine of the light in it. Black below the horizon.
    ///
    /// # Errors
    ///
    /// Pictures that can't be read, are damaged, or of another size than the others.
    pub fn evaluate(&self, x: i32, y: i32, angles: Angles) -> Result<Vec3, BtfError> {
        let place = self.place(x, y);
        let mut sum = Vec3::ZERO;
        for (picture, weight) in self.contributions(angles) {
            let picture = self.store.picture(picture)?;
            sum += weight * light(&picture, place);
        }
        Ok(encode(sum))
    }

    /// Values of many texels at once: each picture is read only once. See [`ImageBtf::evaluate`].
    ///
    /// # Errors
    ///
    /// As [`ImageBtf::evaluate`].
    pub fn evaluate_all(&self, queries: &[Query]) -> Result<Vec<Vec3>, BtfError> {
        let mut wanted: Vec<(u32, u32, f32)> = queries
            .par_iter()
            .enumerate()
            .flat_map_iter(|(number, query)| {
                let contributions = self.contributions(query.angles).into_iter();
                contributions.map(move |(picture, weight)| (picture, number as u32, weight))
            })
            .collect();
        wanted.par_sort_unstable_by_key(|(picture, query, _)| (*picture, *query));
        let groups: Vec<_> = wanted.chunk_by(|a, b| a.0 == b.0).collect();
        let mut sums = vec![Vec3::ZERO; queries.len()];
        // A few pictures at a time, however many there are.
        for groups in groups.chunks(2 * rayon::current_num_threads()) {
            let pictures: Vec<Arc<Picture>> = groups
                .par_iter()
                .map(|group| self.store.picture(group[0].0))
                .collect::<Result<_, _>>()?;
            for (group, picture) in groups.iter().zip(pictures) {
                for (_, query, weight) in *group {
                    let Query { x, y, .. } = queries[*query as usize];
                    sums[*query as usize] += weight * light(&picture, self.place(x, y));
                }
            }
        }
        Ok(sums.into_iter().map(encode).collect())
    }

    /// A picture by its number, as [`ImageBtf::contributions`] gives them; it is not kept.
    ///
    /// # Errors
    ///
    /// As [`ImageBtf::evaluate`].
    pub fn picture(&self, number: u32) -> Result<Picture, BtfError> {
        self.store.read(number)
    }

    /// Numbers of the pictures that a pair of directions is made of, and what to multiply their
    /// linear light with. Nothing below the horizon.
    pub fn contributions(&self, angles: Angles) -> Vec<(u32, f32)> {
        let mut all = Vec::with_capacity(16);
        if !angles.above() {
            return all;
        }
        self.views.weights(angles.theta_v, angles.phi_v, |view, share| {
            let (lights, pictures) = &self.of_view[view as usize];
            let lights = &self.lights[*lights];
            let share = share * lights.falloff(angles.theta_i);
            if share > 0.0 {
                lights.weights(angles.theta_i, angles.phi_i, |light, weight| {
                    if weight > 0.0 {
                        all.push((pictures[light as usize], share * weight));
                    }
                });
            }
        });
        all
    }

    fn place(&self, x: i32, y: i32) -> usize {
        let [width, height] = self.size().map(|size| size as usize);
        let (x, y) = (x.rem_euclid(width as i32) as usize, y.rem_euclid(height as i32) as usize);
        y * width + x
    }
}

fn light(picture: &Picture, place: usize) -> Vec3 {
    picture.texels[place].map(|channel| LINEAR[channel as usize]).into()
}

/// Linear light of 8-bit values.
static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|value| linear(value as f32 / 255.0)));

fn encode(light: Vec3) -> Vec3 {
    255.0 * light.map(srgb_encode)
}

impl fmt::Debug for ImageBtf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [views, lights] = self.directions();
        write!(f, "ImageBtf {:?}, {views} views, {lights} lights", self.info.name)
    }
}

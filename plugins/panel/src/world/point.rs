//! What points at the panel: rays of controllers, the mouse, the gaze.

use bevy::{platform::collections::HashMap, prelude::*};
use bevy_egui::egui::{self, Color32, Event, Modifiers, PointerButton, Pos2, Stroke};
use farlight_bindings::Hand;

use super::{WorldPanel, viewer};
use crate::{PanelRay, PanelSettings, PanelViewer, screen::Screen, style::ACCENT};

/// Whoever points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Who {
    Ray(Entity),
    Mouse,
    Gaze,
}

/// A ray in this frame.
struct Pointing {
    who: Who,
    hand: Option<Hand>,
    pressed: bool,
    /// Where it meets the panel's plane, in points and in metres from its origin.
    hit: Option<(Pos2, f32)>,
    /// Whether something that can be pressed is there.
    over: bool,
}

/// What points at the panel.
#[derive(Resource, Default)]
pub(crate) struct Pointed {
    /// What egui is to hear.
    pub(crate) events: Vec<Event>,
    /// Where.
    pub(crate) at: Option<Pos2>,
    pub(crate) hands: [bool; 2],
    pub(crate) mouse: bool,
    /// Who holds a press that began on the panel.
    holds: Option<Who>,
    /// Who pressed in the frame before.
    pressed: HashMap<Who, bool>,
    dwell: Dwell,
}

/// How long the gaze has been on a control.
#[derive(Default)]
struct Dwell {
    on: Option<egui::Rect>,
    seconds: f32,
    /// From 0 to 1.
    part: f32,
    done: bool,
}

impl Dwell {
    /// Whether it presses in this frame.
    fn look(&mut self, on: Option<egui::Rect>, seconds: f32, needed: f32) -> bool {
        if on.is_none() || on != self.on {
            *self = Self { on, ..Self::default() };
            return false;
        }
        self.seconds += seconds;
        self.part = if self.done { 0.0 } else { (self.seconds / needed).min(1.0) };
        let presses = !self.done && self.seconds >= needed;
        self.done |= presses;
        presses
    }
}

impl Pointed {
    /// Shows where the ray ends, and how long the gaze has to stay.
    pub(crate) fn mark(&self, ctx: &egui::Context) {
        let Some(at) = self.at else { return };
        let layer = egui::LayerId::new(egui::Order::Debug, egui::Id::new("farlight pointer"));
        let painter = ctx.layer_painter(layer);
        let colour = if self.holds.is_some() { ACCENT } else { Color32::WHITE };
        painter.circle(at, 4.5, colour, Stroke::new(1.5, Color32::from_black_alpha(200)));
        if self.dwell.part > 0.0 {
            let steps = (self.dwell.part * 40.0).ceil() as usize;
            let points = (0..=steps).map(|step| {
                let turn = (step as f32 / 40.0).min(self.dwell.part) * std::f32::consts::TAU;
                at + 13.0 * egui::vec2(turn.sin(), -turn.cos())
            });
            painter.circle_stroke(at, 13.0, Stroke::new(4.0, Color32::from_black_alpha(160)));
            painter.add(egui::Shape::line(points.collect(), Stroke::new(3.0, ACCENT)));
        }
    }
}

/// Where a ray meets the panel from its front.
fn meet(panel: &WorldPanel, pose: &Transform, ray: Ray3d) -> Option<(Pos2, f32)> {
    let inverse = pose.compute_affine().inverse();
    let origin = inverse.transform_point3(ray.origin);
    let direction = inverse.transform_vector3(*ray.direction);
    if direction.z > -1e-4 || origin.z <= 0.0 {
        return None;
    }
    let distance = -origin.z / direction.z;
    let at = (origin + direction * distance).truncate() / panel.size;
    let points = (at * Vec2::new(1.0, -1.0) + 0.5) * panel.points;
    points.is_finite().then_some((egui::pos2(points.x, points.y), distance))
}

/// Looks up what points where.
pub(crate) fn point(
    panel: Res<WorldPanel>,
    mut pointed: ResMut<Pointed>,
    settings: Res<PanelSettings>,
    screen: Res<Screen>,
    time: Res<Time<Real>>,
    mut rays: Query<(Entity, &mut PanelRay, &GlobalTransform)>,
    heads: Query<&GlobalTransform, With<PanelViewer>>,
    all: Query<&GlobalTransform>,
    cameras: Query<(&Camera, &GlobalTransform)>,
    windows: Query<&Window>,
    buttons: Option<Res<ButtonInput<MouseButton>>>,
) {
    let pointed = &mut *pointed;
    pointed.hands = [false; 2];
    pointed.mouse = false;
    let (Some(pose), Some(ctx)) = (panel.transform(), panel.ctx()) else {
        if pointed.at.take().is_some() || pointed.holds.take().is_some() {
            pointed.events.push(Event::PointerGone);
        }
        for (_, mut ray, _) in &mut rays {
            if ray.hit.is_some() {
                ray.hit = None;
            }
        }
        return;
    };
    let aim = |who, hand, pressed, ray: Option<Ray3d>| {
        let hit = ray.and_then(|ray| meet(&panel, &pose, ray));
        let over = hit.is_some_and(|(at, _)| {
            ctx.layer_id_at(at).is_some_and(|layer| layer.order != egui::Order::Background)
        });
        Pointing { who, hand, pressed, hit, over }
    };
    let mut all_rays: Vec<_> = rays
        .iter()
        .map(|(entity, ray, at)| {
            let line = Ray3d::new(at.translation(), at.forward());
            aim(Who::Ray(entity), ray.hand, ray.pressed, Some(line))
        })
        .collect();
    let mouse =
        screen.camera.and_then(|camera| cameras.get(camera).ok()).and_then(|(camera, at)| {
            let cursor = windows.iter().find_map(|window| window.cursor_position())?;
            camera.viewport_to_world(at, cursor).ok()
        });
    let left = buttons.is_some_and(|buttons| buttons.pressed(MouseButton::Left));
    if heads.is_empty() {
        all_rays.push(aim(Who::Mouse, None, left, mouse));
    }
    if settings.gaze_dwell > 0.0 && !all_rays.iter().any(|ray| ray.over) {
        let eye = viewer(&screen, &heads, &all);
        let mut gaze = aim(
            Who::Gaze,
            None,
            false,
            eye.map(|eye| Ray3d::new(eye.translation(), eye.forward())),
        );
        let on = gaze.hit.filter(|_| gaze.over).and_then(|(at, _)| control_at(ctx, at));
        gaze.pressed = pointed.dwell.look(on, time.delta_secs(), settings.gaze_dwell);
        all_rays.push(gaze);
    } else {
        pointed.dwell = Dwell::default();
    }
    pointed.hear(&all_rays);

    for ray in &all_rays {
        let on = ray.over || pointed.holds == Some(ray.who);
        if let Some(hand) = ray.hand {
            pointed.hands[hand as usize] |= on;
        }
        match ray.who {
            Who::Mouse => pointed.mouse = on,
            Who::Gaze => {}
            Who::Ray(entity) => {
                let hit = ray.hit.filter(|_| on).map(|(_, distance)| distance);
                if let Ok((_, mut ray, _)) = rays.get_mut(entity)
                    && ray.hit != hit
                {
                    ray.hit = hit;
                }
            }
        }
    }
}

impl Pointed {
    /// Turns rays into what a mouse would say: one of them is the pointer.
    fn hear(&mut self, rays: &[Pointing]) {
        // Who went away, lets go.
        let held = self.holds.and_then(|who| rays.iter().find(|ray| ray.who == who));
        if held.is_none() && self.holds.take().is_some() {
            self.events.push(Event::PointerGone);
            self.at = None;
        }
        let began = |ray: &Pointing| ray.pressed && !self.pressed.get(&ray.who).is_some_and(|&b| b);
        let nearest = |rays: &mut dyn Iterator<Item = &Pointing>| -> Option<usize> {
            rays.enumerate()
                .filter(|(_, ray)| ray.over)
                .min_by(|(_, a), (_, b)| {
                    let distance = |ray: &Pointing| ray.hit.map_or(f32::INFINITY, |hit| hit.1);
                    // Who presses now is the pointer; then the nearest.
                    (!began(a), distance(a))
                        .partial_cmp(&(!began(b), distance(b)))
                        .unwrap_or(std::cmp::Ordering::Equal)
                })
                .map(|(at, _)| at)
        };
        let active = match held {
            Some(held) => Some(held),
            None => nearest(&mut rays.iter()).and_then(|at| rays.get(at)),
        };
        let at = active.and_then(|ray| ray.hit.map(|hit| hit.0)).or(match held {
            Some(_) => self.at,
            None => None,
        });
        match (at, active) {
            (Some(at), Some(active)) => {
                if self.at != Some(at) {
                    self.events.push(Event::PointerMoved(at));
                }
                let button = |pressed| Event::PointerButton {
                    pos: at,
                    button: PointerButton::Primary,
                    pressed,
                    modifiers: Modifiers::NONE,
                };
                if self.holds.is_some() && !active.pressed {
                    self.events.push(button(false));
                    self.holds = None;
                } else if self.holds.is_none() && active.over && began(active) {
                    self.events.push(button(true));
                    self.holds = Some(active.who);
                }
            }
            _ if self.at.is_some() => self.events.push(Event::PointerGone),
            _ => {}
        }
        self.at = at;
        self.pressed = rays.iter().map(|ray| (ray.who, ray.pressed)).collect();
    }
}

/// The smallest control under a point.
fn control_at(ctx: &egui::Context, at: Pos2) -> Option<egui::Rect> {
    let rects = ctx.interactive_rects_last_pass();
    let under = rects.into_iter().filter(|rect| rect.contains(at) && rect.area() < 40_000.0);
    under.min_by(|a, b| a.area().total_cmp(&b.area()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(pressed: bool, over: bool) -> [Pointing; 1] {
        let hit = Some((egui::pos2(10.0, 20.0), 1.0));
        [Pointing { who: Who::Mouse, hand: None, pressed, hit, over }]
    }

    fn presses(pointed: &mut Pointed, pressed: bool, over: bool) -> Vec<bool> {
        pointed.hear(&ray(pressed, over));
        pointed
            .events
            .drain(..)
            .filter_map(|event| match event {
                Event::PointerButton { pressed, .. } => Some(pressed),
                _ => None,
            })
            .collect()
    }

    #[test]
    fn a_press_that_began_elsewhere_does_not_count() {
        let mut pointed = Pointed::default();
        assert_eq!(presses(&mut pointed, true, false), [false; 0]);
        assert_eq!(
            presses(&mut pointed, true, true),
            [false; 0],
            "it comes over the panel, pressed"
        );
        assert_eq!(presses(&mut pointed, false, true), [false; 0]);
        assert_eq!(presses(&mut pointed, true, true), [true]);
        assert_eq!(presses(&mut pointed, true, false), [false; 0], "it stays the panel's");
        assert_eq!(presses(&mut pointed, false, false), [false]);
    }

    #[test]
    fn the_gaze_presses_once() {
        let mut dwell = Dwell::default();
        let on = Some(egui::Rect::from_min_size(Pos2::ZERO, egui::vec2(20.0, 20.0)));
        let presses = (0..30).filter(|_| dwell.look(on, 0.1, 1.0)).count();
        assert_eq!(presses, 1);
        assert!(!dwell.look(None, 0.1, 1.0));
        assert_eq!((0..30).filter(|_| dwell.look(on, 0.1, 1.0)).count(), 1, "it looks again");
    }
}

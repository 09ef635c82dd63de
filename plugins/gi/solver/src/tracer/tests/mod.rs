//! Against a double-precision search of all triangles, closed surfaces, and hostile input.

mod hostile;
mod watertight;

use glam::{DVec3, Vec3};

use super::{Hit, Instructions, Ray, Tracer};

/// PCG32.
struct Random(u64);

impl Random {
    fn word(&mut self) -> u32 {
        let old = self.0;
        self.0 =
            old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((((old >> 18) ^ old) >> 27) as u32).rotate_right((old >> 59) as u32)
    }

    /// In 0 to 1.
    fn unit(&mut self) -> f32 {
        (self.word() >> 8) as f32 / (1 << 24) as f32
    }

    /// In a cube from -1 to 1.
    fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

/// All kernels that this processor has, each as a tracer of the same triangles.
fn tracers(triangles: &[[Vec3; 3]]) -> Vec<Tracer> {
    let best = Tracer::new(triangles);
    Instructions::available()
        .into_iter()
        .map(|instructions| Tracer { tree: best.tree.clone(), instructions })
        .collect()
}

fn soup(n: usize, size: f32, random: &mut Random) -> Vec<[Vec3; 3]> {
    (0..n)
        .map(|_| {
            let centre = random.cube();
            [0, 1, 2].map(|_| centre + random.cube() * size)
        })
        .collect()
}

/// Distance, weights and a bound of their error, in double precision.
fn reference(ray: &Ray, triangle: &[Vec3; 3]) -> Option<(f64, f64, f64)> {
    let [a, b, c] = triangle.map(Vec3::as_dvec3);
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (ab, ac) = (b - a, c - a);
    let p = d.cross(ac);
    let det = ab.dot(p);
    let s = o - a;
    let u = s.dot(p) / det;
    let q = s.cross(ab);
    let v = d.dot(q) / det;
    let t = ac.dot(q) / det;
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    (inside && t >= f64::from(ray.t_min) && t <= f64::from(ray.t_max)).then_some((t, u, v))
}

/// How close to an edge, the plane's vanishing or an end of the interval the ray passes: small
/// values may be decided either way.
fn doubtful(ray: &Ray, triangle: &[Vec3; 3]) -> bool {
    let [a, b, c] = triangle.map(Vec3::as_dvec3);
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3().normalize());
    let normal = (b - a).cross(c - a);
    let length = ray.direction.as_dvec3().length();
    let t = (a - o).dot(normal) / d.dot(normal);
    let p = o + t * d;
    let edge = |a: DVec3, b: DVec3| {
        let along = (b - a).normalize();
        let k = (p - a).dot(along).clamp(0.0, (b - a).length());
        (p - a - k * along).length()
    };
    let nearest = edge(a, b).min(edge(b, c)).min(edge(c, a));
    let slope = d.dot(normal.normalize()).abs();
    let ends =
        (t - f64::from(ray.t_min) * length).abs().min((t - f64::from(ray.t_max) * length).abs());
    slope < 1e-4 || nearest * slope < 3e-6 || ends * slope < 3e-6
}

#[test]
fn agrees_with_a_search_in_double_precision() {
    let mut random = Random(1);
    for (count, size) in [(1, 1.0), (3, 0.5), (40, 0.4), (700, 0.1)] {
        let triangles = soup(count, size, &mut random);
        let tracers = tracers(&triangles);
        let mut hits = 0;
        for _ in 0..2000 {
            let length = 10.0f32.powf(random.unit() * 6.0 - 3.0);
            let ray = Ray {
                origin: random.cube() * 1.5,
                direction: random.cube() * length,
                t_min: 0.0,
                t_max: if random.unit() < 0.5 { f32::INFINITY } else { random.unit() / length },
            };
            let expected = triangles
                .iter()
                .enumerate()
                .filter_map(|(i, t)| reference(&ray, t).map(|(t, u, v)| (t, u, v, i)))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let unsure = triangles.iter().any(|t| doubtful(&ray, t));
            for tracer in &tracers {
                let hit = tracer.closest(&ray);
                assert_eq!(hit.is_hit(), tracer.occluded(&ray));
                if unsure {
                    continue;
                }
                let Some((t, u, v, i)) = expected else {
                    assert!(!hit.is_hit(), "{:?} {ray:?} {hit:?}", tracer.instructions);
                    continue;
                };
                hits += 1;
                assert_eq!(hit.triangle as usize, i, "{:?} {ray:?}", tracer.instructions);
                let tolerance = 1e-4 * (1.0 + t * f64::from(ray.direction.length()));
                let error = (f64::from(hit.t) - t).abs() * f64::from(ray.direction.length());
                assert!(error < tolerance, "{ray:?} {hit:?} {t}");
                assert!((f64::from(hit.u) - u).abs() < 2e-3, "{ray:?} {hit:?} {u}");
                assert!((f64::from(hit.v) - v).abs() < 2e-3, "{ray:?} {hit:?} {v}");
            }
        }
        assert!(hits > 20, "{hits} of {count}");
    }
}

#[test]
fn kernels_agree_bit_for_bit() {
    let mut random = Random(2);
    let triangles = soup(3000, 0.15, &mut random);
    let tracers = tracers(&triangles);
    if tracers.len() < 2 {
        println!("skipped: this processor has the portable kernel only");
        return;
    }
    for _ in 0..20_000 {
        let ray = Ray::new(random.cube(), random.cube());
        let hits: Vec<Hit> = tracers.iter().map(|t| t.closest(&ray)).collect();
        assert!(hits.iter().all(|h| *h == hits[0]), "{ray:?} {hits:?}");
    }
}

#[test]
fn nothing_and_degenerate_triangles() {
    let bad = [
        [Vec3::NAN, Vec3::X, Vec3::Y],
        [Vec3::ZERO, Vec3::INFINITY, Vec3::Y],
        [Vec3::ZERO, Vec3::NEG_INFINITY, Vec3::Y],
        [Vec3::splat(f32::MAX), Vec3::X, Vec3::splat(f32::MIN)],
        [Vec3::ZERO, Vec3::ZERO, Vec3::ZERO],
        [Vec3::splat(0.1), Vec3::splat(0.2), Vec3::splat(0.3)],
        [-Vec3::X, Vec3::X, Vec3::X],
    ];
    let good = [Vec3::new(-1.0, -1.0, 5.0), Vec3::new(1.0, -1.0, 5.0), Vec3::new(0.0, 1.0, 5.0)];
    let mut mixed = bad.to_vec();
    mixed.push(good);
    for (triangles, expected) in [(&[][..], None), (&bad[..], None), (&mixed[..], Some(7))] {
        for tracer in tracers(triangles) {
            let mut random = Random(3);
            let ray = Ray::new(Vec3::ZERO, Vec3::Z);
            let hit = tracer.closest(&ray);
            assert_eq!(hit.is_hit().then_some(hit.triangle), expected);
            assert_eq!(tracer.occluded(&ray), expected.is_some());
            for _ in 0..200 {
                let ray = Ray::new(random.cube() * 2.0, random.cube());
                let hit = tracer.closest(&ray);
                assert!(hit == Hit::NONE || Some(hit.triangle) == expected);
            }
        }
    }
}

#[test]
fn rays_that_are_none() {
    let mut random = Random(4);
    let triangles = soup(100, 2.0, &mut random);
    let good = Ray::new(Vec3::ZERO, Vec3::Z);
    let bad = [
        Ray { direction: Vec3::ZERO, ..good },
        Ray { direction: Vec3::NAN, ..good },
        Ray { direction: Vec3::new(0.0, f32::NAN, 1.0), ..good },
        Ray { direction: Vec3::new(0.0, f32::INFINITY, 1.0), ..good },
        Ray { origin: Vec3::NAN, ..good },
        Ray { origin: Vec3::new(f32::NAN, 0.0, 0.0), ..good },
        Ray { origin: Vec3::INFINITY, ..good },
        Ray { origin: Vec3::splat(f32::MAX), ..good },
        Ray { t_min: f32::NAN, ..good },
        Ray { t_max: f32::NAN, ..good },
        Ray { t_min: 2.0, t_max: 1.0, ..good },
        Ray { t_max: -1.0, ..good },
    ];
    for tracer in tracers(&triangles) {
        assert!(tracer.occluded(&good));
        for ray in &bad {
            assert_eq!(tracer.closest(ray), Hit::NONE, "{ray:?}");
            assert!(!tracer.occluded(ray), "{ray:?}");
        }
    }
}

#[test]
fn ends_of_the_interval() {
    let wall = |z: f32| [Vec3::new(-9.0, -9.0, z), Vec3::new(9.0, -9.0, z), Vec3::new(0.0, 9.0, z)];
    let triangles = [wall(1.0), wall(2.0), wall(3.0)];
    for tracer in tracers(&triangles) {
        for scale in [1.0e-20, 0.25, 1.0, 64.0, 1.0e20] {
            let at = |t_min: f32, t_max: f32| {
                let ray = Ray {
                    origin: Vec3::ZERO,
                    direction: Vec3::new(0.1, -0.2, 1.0) * scale,
                    t_min: t_min / scale,
                    t_max: t_max / scale,
                };
                let hit = tracer.closest(&ray);
                assert_eq!(tracer.occluded(&ray), hit.is_hit());
                assert!(!hit.is_hit() || (hit.t * scale - hit.triangle as f32 - 1.0).abs() < 1e-5);
                hit.is_hit().then_some(hit.triangle)
            };
            assert_eq!(at(0.0, f32::INFINITY), Some(0));
            assert_eq!(at(-5.0, f32::INFINITY), Some(0));
            assert_eq!(at(1.01, f32::INFINITY), Some(1));
            assert_eq!(at(2.01, 3.01), Some(2));
            assert_eq!(at(1.01, 1.99), None);
            assert_eq!(at(0.0, 0.99), None);
            assert_eq!(at(3.01, f32::INFINITY), None);
        }
    }
}

#[test]
fn edge_functions_that_all_round_to_zero() {
    // Seen along z, the corners lie so nearly on a line through the origin that only the second
    // order of the unit in the last place tells that the origin is inside.
    let corner = |sign: f32, a: f32| {
        Vec3::new(1.0 + (a + 1.0) * f32::EPSILON, 1.0 + a * f32::EPSILON, sign) * sign
    };
    let triangle = [corner(1.0, 4.0), corner(1.0, 0.0), corner(-1.0, 2.0)];
    let ray = Ray::new(Vec3::ZERO, Vec3::Z);
    let [a, b, c] = triangle.map(|p| p.truncate());
    assert_eq!([a.perp_dot(b), b.perp_dot(c), c.perp_dot(a)], [0.0; 3]);
    for tracer in tracers(&[triangle]) {
        let hit = tracer.closest(&ray);
        assert!((hit.t - 1.0).abs() < 1e-6, "{:?} {hit:?}", tracer.instructions);
        assert!(tracer.occluded(&ray));
    }
}

#[test]
fn distances_in_a_hall_of_100_metres() {
    let mut random = Random(12);
    let (min, max) = (Vec3::new(-50.0, 0.0, -37.0), Vec3::new(50.0, 11.0, 63.0));
    let corner = |i: usize| {
        Vec3::from_array([0, 1, 2].map(|a| if i >> a & 1 == 1 { max[a] } else { min[a] }))
    };
    let faces =
        [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles: Vec<[Vec3; 3]> = faces
        .iter()
        .map(|f| f.map(corner))
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    for tracer in tracers(&triangles) {
        let mut worst: f64 = 0.0;
        for _ in 0..20_000 {
            let origin = min + (max - min) * (random.cube() * 0.499 + 0.5);
            let ray = Ray::new(origin, random.cube().normalize());
            let hit = tracer.closest(&ray);
            assert!(hit.is_hit(), "{ray:?}");
            let [a, b, c] = triangles[hit.triangle as usize].map(Vec3::as_dvec3);
            let normal = (b - a).cross(c - a).normalize();
            let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            // Off the plane, and off the point that the weights name.
            let point = o + f64::from(hit.t) * d;
            let (u, v) = (f64::from(hit.u), f64::from(hit.v));
            let named = a + u * (b - a) + v * (c - a);
            worst = worst.max((point - a).dot(normal).abs());
            // Along the ray, however it grazes the plane.
            let exact = (a - o).dot(normal) / d.dot(normal);
            assert!((f64::from(hit.t) - exact).abs() < 1e-6 * exact, "{ray:?} {hit:?} {exact}");
            assert!((point - named).reject_from(d).length() < 5e-5, "{ray:?} {hit:?}");
        }
        assert!(worst < 5e-5, "{:?}: {worst}", tracer.instructions);
        println!("{:?}: at most {:.1} um off the plane", tracer.instructions, worst * 1e6);
    }
}

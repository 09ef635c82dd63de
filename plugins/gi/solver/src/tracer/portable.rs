//! The kernel in plain arrays, for every other processor; compilers make vector code of its loops.

use super::{
    Hit, Ray,
    node::{Child, LANES, Node, Pack, Tree, WIDTH},
    ray::{Prepared, max, min},
    traverse::{self, Kernel},
    triangle::{Best, edge_on},
};

pub(super) fn closest(tree: &Tree, ray: &Ray) -> Hit {
    // SAFETY: needs no instruction beyond the target's own.
    unsafe { traverse::closest::<Portable>(tree, ray) }
}

pub(super) fn occluded(tree: &Tree, ray: &Ray) -> bool {
    // SAFETY: needs no instruction beyond the target's own.
    unsafe { traverse::occluded::<Portable>(tree, ray) }
}

#[derive(Clone, Copy)]
struct Portable;

/// Entry distances, and a bit for each box that the ray meets.
#[inline(always)]
fn slabs(ray: &Prepared, node: &Node, limit: f32) -> ([f32; WIDTH], u32) {
    let mut enter = [ray.t_min; WIDTH];
    let mut leave = [limit; WIDTH];
    for a in 0..3 {
        let near = &node.bounds[ray.near_row[a] / WIDTH];
        let far = &node.bounds[ray.far_row[a] / WIDTH];
        for i in 0..WIDTH {
            enter[i] = max(near[i] * ray.inverse[a] + ray.near[a], enter[i]);
            leave[i] = min(far[i] * ray.inverse[a] + ray.far[a], leave[i]);
        }
    }
    let mut met = 0;
    for i in 0..WIDTH {
        met |= u32::from(enter[i] <= leave[i]) << i;
    }
    (enter, met)
}

/// Edge functions of the second and third corner, their sum with the first's, distance; and bits
/// for the lanes that are hit and that are seen edge-on.
#[inline(always)]
fn edges(ray: &Prepared, pack: &Pack, limit: f32) -> ([[f32; LANES]; 4], u32, u32) {
    let mut p = [[[0.0; LANES]; 3]; 3];
    for (p, corner) in p.iter_mut().zip(&pack.corner) {
        for i in 0..LANES {
            let z = corner[ray.axis[2]][i] - ray.origin[ray.axis[2]];
            p[0][i] = (corner[ray.axis[0]][i] - ray.origin[ray.axis[0]]) - ray.shear[0] * z;
            p[1][i] = (corner[ray.axis[1]][i] - ray.origin[ray.axis[1]]) - ray.shear[1] * z;
            p[2][i] = z;
        }
    }
    let [a, b, c] = p;
    let mut out = [[0.0; LANES]; 4];
    let (mut hits, mut edge_on) = (0, 0);
    for i in 0..LANES {
        let u = c[0][i] * b[1][i] - c[1][i] * b[0][i];
        let v = a[0][i] * c[1][i] - a[1][i] * c[0][i];
        let w = b[0][i] * a[1][i] - b[1][i] * a[0][i];
        let inside = (u >= 0.0) & (v >= 0.0) & (w >= 0.0) | (u <= 0.0) & (v <= 0.0) & (w <= 0.0);
        let det = u + v + w;
        let t = (u * a[2][i] + v * b[2][i] + w * c[2][i]) / det * ray.sign;
        out[0][i] = v;
        out[1][i] = w;
        out[2][i] = det;
        out[3][i] = t;
        hits |= u32::from(inside & (t >= ray.t_min) & (t <= limit)) << i;
        edge_on |= u32::from(inside & (det == 0.0)) << i;
    }
    (out, hits, edge_on)
}

impl Kernel for Portable {
    #[inline(always)]
    unsafe fn new(_: &Prepared) -> Self {
        Self
    }

    #[inline(always)]
    unsafe fn children(
        &self,
        ray: &Prepared,
        node: &Node,
        limit: f32,
        child: *mut Child,
        distance: *mut f32,
    ) -> (usize, Child) {
        let (enter, met) = slabs(ray, node, limit);
        let mut count = 0;
        let mut nearest = Child::node(0);
        for order in node.order {
            let i = (order >> ray.order_shift) as usize & (WIDTH - 1);
            // SAFETY: at most eight are written.
            unsafe {
                child.add(count).write(node.child[i]);
                distance.add(count).write(enter[i]);
            }
            if met >> i & 1 == 1 {
                nearest = node.child[i];
                count += 1;
            }
        }
        (count, nearest)
    }

    #[inline(always)]
    unsafe fn any_children(
        &self,
        ray: &Prepared,
        node: &Node,
        child: *mut Child,
    ) -> (usize, Child) {
        let (_, mut met) = slabs(ray, node, ray.t_max);
        let mut count = 0;
        let mut last = Child::node(0);
        while met != 0 {
            last = node.child[met.trailing_zeros() as usize];
            // SAFETY: at most eight are written.
            unsafe { child.add(count).write(last) };
            count += 1;
            met &= met - 1;
        }
        (count, last)
    }

    #[inline(always)]
    unsafe fn closest(&self, ray: &Prepared, pack: &Pack, best: &mut Best) {
        let ([v, w, det, t], hits, edges_on) = edges(ray, pack, best.t);
        if hits | edges_on == 0 {
            return;
        }
        for lane in 0..LANES {
            if hits >> lane & 1 == 1 && t[lane] <= best.t {
                *best = Best {
                    t: t[lane],
                    v: v[lane],
                    w: w[lane],
                    det: det[lane],
                    triangle: pack.triangle[lane],
                };
            }
        }
        for lane in (0..LANES).filter(|lane| edges_on >> lane & 1 == 1) {
            if let Some(hit) = edge_on(ray, pack, lane, best.t) {
                *best = hit;
            }
        }
    }

    #[inline(always)]
    unsafe fn any(&self, ray: &Prepared, pack: &Pack) -> bool {
        let (_, hits, edges_on) = edges(ray, pack, ray.t_max);
        hits != 0
            || (0..LANES)
                .filter(|lane| edges_on >> lane & 1 == 1)
                .any(|lane| edge_on(ray, pack, lane, ray.t_max).is_some())
    }
}

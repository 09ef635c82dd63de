//! The kernel in plain arrays, for every other processor; compilers make vector code of its loops.

use super::{
    Hit, Ray,
    node::{Child, LANES, Node, Pack, Tree, WIDTH},
    ray::{Frame, LEAST, PAD, max, min},
    traverse::{self, Kernel},
    triangle::{Best, edge_on},
};

#[inline(never)]
pub(super) fn closest(tree: &Tree, ray: &Ray) -> Hit {
    // SAFETY: needs no instruction beyond the target's own.
    unsafe { traverse::closest::<Portable>(tree, ray) }
}

#[inline(never)]
pub(super) fn occluded(tree: &Tree, ray: &Ray) -> bool {
    // SAFETY: needs no instruction beyond the target's own.
    unsafe { traverse::occluded::<Portable>(tree, ray) }
}

/// One ray's constants.
struct Portable {
    frame: Frame,
    /// Reciprocal direction; never zero, never infinite.
    inverse: [f32; 3],
    /// Plane distance = plane * inverse + offset, rounded towards the ray's start ...
    near: [f32; 3],
    /// ... and towards its end.
    far: [f32; 3],
    /// The rows of `Node::bounds` through which the ray enters, by axis.
    near_row: [usize; 3],
    /// The same for leaving.
    far_row: [usize; 3],
    /// Three times the octant.
    order_shift: u32,
}

/// Entry distances, and a bit for each box that the ray meets.
#[inline(always)]
fn slabs(ray: &Portable, node: &Node, limit: f32) -> ([f32; WIDTH], u32) {
    let mut enter = [ray.frame.t_min; WIDTH];
    let mut leave = [limit; WIDTH];
    for a in 0..3 {
        let near = &node.bounds[ray.near_row[a]];
        let far = &node.bounds[ray.far_row[a]];
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
fn edges(ray: &Frame, pack: &Pack, limit: f32) -> ([[f32; LANES]; 4], u32, u32) {
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
    unsafe fn new(ray: &Ray) -> Option<Self> {
        let frame = Frame::new(ray)?;
        let origin = frame.origin;
        let direction = ray.direction.to_array();
        let reach = max(max(origin[0].abs(), origin[1].abs()), origin[2].abs());
        let least = max(frame.scale * LEAST, f32::MIN_POSITIVE);
        let magnitude = direction.map(|d| frame.scale / max(d.abs(), least));
        let inverse = [0, 1, 2].map(|a| magnitude[a].copysign(direction[a]));
        let negative = direction.map(|d| (d.to_bits() >> 31) as usize);
        Some(Self {
            frame,
            inverse,
            near: [0, 1, 2].map(|a| -origin[a] * inverse[a] - reach * PAD * magnitude[a]),
            far: [0, 1, 2].map(|a| -origin[a] * inverse[a] + reach * PAD * magnitude[a]),
            near_row: [0, 1, 2].map(|a| a + 3 * negative[a]),
            far_row: [0, 1, 2].map(|a| a + 3 - 3 * negative[a]),
            order_shift: 3 * (negative[0] | negative[1] << 1 | negative[2] << 2) as u32,
        })
    }

    #[inline(always)]
    fn frame(&self) -> &Frame {
        &self.frame
    }

    #[inline(always)]
    unsafe fn children(
        &self,
        node: &Node,
        limit: f32,
        child: *mut Child,
        distance: *mut f32,
    ) -> (usize, Child) {
        let (enter, met) = slabs(self, node, limit);
        let mut count = 0;
        let mut nearest = Child::node(0);
        for order in node.order.into_iter().rev() {
            let i = (order >> self.order_shift) as usize & (WIDTH - 1);
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
    unsafe fn any_children(&self, node: &Node, child: *mut Child) -> (usize, Child) {
        let (_, met) = slabs(self, node, self.frame.t_max);
        let mut count = 0;
        for i in (0..WIDTH).rev().filter(|i| met >> i & 1 == 1) {
            // SAFETY: at most eight are written.
            unsafe { child.add(count).write(node.child[i]) };
            count += 1;
        }
        (count, node.child[met.trailing_zeros() as usize % WIDTH])
    }

    #[inline(always)]
    unsafe fn closest<'a>(&self, pack: &'a Pack, best: &mut Best<'a>) -> bool {
        let ([v, w, det, t], hits, edges_on) = edges(&self.frame, pack, best.t);
        if hits | edges_on == 0 {
            return false;
        }
        for lane in 0..LANES {
            if hits >> lane & 1 == 1 && t[lane] <= best.t {
                *best = Best {
                    t: t[lane],
                    v: v[lane],
                    w: w[lane],
                    det: det[lane],
                    pack: Some(pack),
                    lane,
                };
            }
        }
        for lane in (0..LANES).filter(|lane| edges_on >> lane & 1 == 1) {
            if let Some(hit) = edge_on(&self.frame, pack, lane, best.t) {
                *best = hit;
            }
        }
        false
    }

    #[inline(always)]
    unsafe fn any(&self, pack: &Pack) -> (bool, bool) {
        let (_, hits, edges_on) = edges(&self.frame, pack, self.frame.t_max);
        let hit = hits != 0
            || (0..LANES)
                .filter(|lane| edges_on >> lane & 1 == 1)
                .any(|lane| edge_on(&self.frame, pack, lane, self.frame.t_max).is_some());
        (hit, false)
    }
}

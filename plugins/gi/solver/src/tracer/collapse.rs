//! Binary tree to eight-wide tree, by the least expected cost.
//!
//! Dynamic programming as in Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on
//! GPUs Through Compressed Wide BVHs", section 3.1: for each binary node the least cost of
//! representing its subtree by at most 1 to 7 children of a wide node, from the leaves upwards;
//! then the choices are read back from the root.

use glam::{Vec3, Vec3A};

use super::{
    binary::{BinaryNode, Bounds, Content},
    node::{Child, LANES, MAX_DEPTH, Node, Pack, Tree, WIDTH},
    ray::PAD,
};

/// Cost of testing a node's eight boxes.
const NODE_COST: f32 = 1.0;
/// Cost of testing a pack's four triangles.
const PACK_COST: f32 = 0.6;
/// Most triangles of a leaf, where the surface area heuristic has a choice.
const LEAF_TRIANGLES: u32 = 8;
/// From this depth on subtrees are split in the middle, so that the tree ends before `MAX_DEPTH`:
/// 32-bit indices need 11 levels of eight.
const BALANCED_DEPTH: usize = MAX_DEPTH - 14;

/// What is known of a binary node's subtree.
#[derive(Clone, Copy, Default)]
struct Subtree {
    /// Least cost with at most `i + 1` children of the wide parent.
    cost: [f32; WIDTH - 1],
    references: u32,
}

/// A part of the binary tree, or leaves of it that are split in the middle.
#[derive(Clone)]
enum Part {
    Node(usize),
    List(Vec<u32>),
}

pub(super) struct Collapse<'a> {
    triangles: &'a [[Vec3; 3]],
    nodes: &'a [BinaryNode],
    subtrees: Vec<Subtree>,
    tree: Tree,
}

impl<'a> Collapse<'a> {
    pub(super) fn new(triangles: &'a [[Vec3; 3]], nodes: &'a [BinaryNode]) -> Self {
        let mut this = Self {
            triangles,
            nodes,
            subtrees: vec![Subtree::default(); nodes.len()],
            tree: Tree::default(),
        };
        this.costs();
        this
    }

    pub(super) fn run(mut self) -> Tree {
        self.tree.nodes.push(Node::EMPTY);
        // Depth first, so that a subtree lies together; children of one node are neighbours.
        let mut todo = vec![(Part::Node(0), 0, 1)];
        let mut next = Vec::new();
        while let Some((part, index, depth)) = todo.pop() {
            self.emit(part, index, depth, &mut next);
            todo.extend(next.drain(..).rev());
        }
        self.tree
    }

    fn children(&self, node: usize) -> Option<[usize; 2]> {
        match self.nodes[node].content {
            Content::Children(first) => Some([first as usize, first as usize + 1]),
            Content::Triangle(_) => None,
        }
    }

    /// Fills `subtrees`, children before parents.
    fn costs(&mut self) {
        let mut todo = vec![0];
        let mut order = Vec::with_capacity(self.nodes.len());
        while let Some(node) = todo.pop() {
            order.push(node);
            todo.extend(self.children(node).into_iter().flatten());
        }
        for &node in order.iter().rev() {
            let area = self.nodes[node].bounds.area();
            let mut subtree = Subtree::default();
            if let Some(children) = self.children(node) {
                let [left, right] = children.map(|c| &self.subtrees[c]);
                subtree.references = left.references + right.references;
                let inner = area * NODE_COST + distribute(left, right, WIDTH).0;
                subtree.cost[0] = inner.min(leaf_cost(area, subtree.references));
                for i in 1..WIDTH - 1 {
                    subtree.cost[i] = subtree.cost[i - 1].min(distribute(left, right, i + 1).0);
                }
            } else {
                subtree.references = 1;
                subtree.cost = [leaf_cost(area, 1); WIDTH - 1];
            }
            self.subtrees[node] = subtree;
        }
    }

    /// Writes the wide node `index`, and says what its inner children are.
    fn emit(
        &mut self,
        part: Part,
        index: usize,
        depth: usize,
        next: &mut Vec<(Part, usize, usize)>,
    ) {
        let mut parts = match part {
            Part::Node(node) if depth < BALANCED_DEPTH => {
                let mut parts = Vec::with_capacity(WIDTH);
                self.choose(node, WIDTH, true, &mut parts);
                parts.into_iter().map(Part::Node).collect()
            }
            Part::Node(node) => split(&self.gather(node)),
            Part::List(list) => split(&list),
        };
        parts.sort_by(|a, b| self.promise(b).total_cmp(&self.promise(a)));
        let boxes: Vec<Bounds> = parts.iter().map(|p| padded(self.bounds(p))).collect();
        let mut node = Node::EMPTY;
        for (i, part) in parts.drain(..).enumerate() {
            for a in 0..3 {
                node.bounds[a][i] = boxes[i].min[a];
                node.bounds[a + 3][i] = boxes[i].max[a];
            }
            node.child[i] = if self.is_leaf(&part) {
                let list = match part {
                    Part::Node(n) => self.gather(n),
                    Part::List(list) => list,
                };
                self.leaf(&list)
            } else {
                let child = self.tree.nodes.len();
                self.tree.nodes.push(Node::EMPTY);
                next.push((part, child, depth + 1));
                Child::node(child)
            };
        }
        node.order = orders(&boxes);
        self.tree.nodes[index] = node;
    }

    /// Whether a part becomes a leaf where it stands as one child.
    fn is_leaf(&self, part: &Part) -> bool {
        match *part {
            Part::List(ref list) => list.len() <= LEAF_TRIANGLES as usize,
            Part::Node(node) => match self.children(node) {
                None => true,
                Some(_) => {
                    let s = &self.subtrees[node];
                    s.cost[0] == leaf_cost(self.nodes[node].bounds.area(), s.references)
                }
            },
        }
    }

    /// The children that represent `node` by at most `budget` of them; at the top it must be opened.
    fn choose(&self, node: usize, budget: usize, top: bool, out: &mut Vec<usize>) {
        let Some([left, right]) = self.children(node) else {
            out.push(node);
            return;
        };
        let mut budget = budget;
        if !top {
            let cost = &self.subtrees[node].cost;
            while budget > 1 && cost[budget - 1] == cost[budget - 2] {
                budget -= 1;
            }
            if budget == 1 {
                out.push(node);
                return;
            }
        }
        let (_, to_left) = distribute(&self.subtrees[left], &self.subtrees[right], budget);
        self.choose(left, to_left, false, out);
        self.choose(right, budget - to_left, false, out);
    }

    /// All leaves below a binary node.
    fn gather(&self, node: usize) -> Vec<u32> {
        let mut todo = vec![node];
        let mut out = Vec::new();
        while let Some(node) = todo.pop() {
            match self.children(node) {
                Some([left, right]) => todo.extend([right, left]),
                None => out.push(node as u32),
            }
        }
        out
    }

    fn bounds(&self, part: &Part) -> Bounds {
        match part {
            Part::Node(node) => self.nodes[*node].bounds,
            Part::List(list) => {
                let mut bounds = Bounds::EMPTY;
                list.iter().for_each(|&leaf| bounds.add(self.nodes[leaf as usize].bounds));
                bounds
            }
        }
    }

    /// How soon an any-hit ray should look here: a large box is likely to stop it, and a leaf is
    /// cheap to ask.
    fn promise(&self, part: &Part) -> f32 {
        self.bounds(part).area() * if self.is_leaf(part) { 8.0 } else { 1.0 }
    }

    /// Packs the references' triangles.
    fn leaf(&mut self, list: &[u32]) -> Child {
        // Two parts of a triangle in one leaf are one triangle.
        let mut triangles: Vec<u32> = list
            .iter()
            .filter_map(|&leaf| match self.nodes[leaf as usize].content {
                Content::Triangle(triangle) => Some(triangle),
                Content::Children(_) => None,
            })
            .collect();
        triangles.sort_unstable();
        triangles.dedup();
        let first = self.tree.packs.len();
        for chunk in triangles.chunks(LANES) {
            let mut pack = Pack::EMPTY;
            for (lane, &triangle) in chunk.iter().enumerate() {
                pack.triangle[lane] = triangle;
                for (corner, p) in pack.corner.iter_mut().zip(self.triangles[triangle as usize]) {
                    for a in 0..3 {
                        corner[a][lane] = p[a];
                    }
                }
            }
            self.tree.packs.push(pack);
        }
        Child::leaf(first, triangles.len().div_ceil(LANES))
    }
}

/// Grown by what the tests may round away.
fn padded(bounds: Bounds) -> Bounds {
    let pad = Vec3A::splat(bounds.min.abs().max(bounds.max.abs()).max_element() * PAD);
    Bounds { min: bounds.min - pad, max: bounds.max + pad }
}

fn leaf_cost(area: f32, references: u32) -> f32 {
    if references > LEAF_TRIANGLES {
        f32::INFINITY
    } else {
        area * PACK_COST * references.div_ceil(LANES as u32) as f32
    }
}

/// The cheapest way to share `budget` children among two subtrees, and what the left one gets.
fn distribute(left: &Subtree, right: &Subtree, budget: usize) -> (f32, usize) {
    let mut best = (f32::INFINITY, 1);
    for to_left in 1..budget {
        let cost = left.cost[to_left - 1] + right.cost[budget - to_left - 1];
        if cost < best.0 {
            best = (cost, to_left);
        }
    }
    best
}

/// Eight runs of about the same length.
fn split(list: &[u32]) -> Vec<Part> {
    list.chunks(list.len().div_ceil(WIDTH).max(LANES)).map(|c| Part::List(c.to_vec())).collect()
}

/// `Node::order` for these children.
fn orders(boxes: &[Bounds]) -> [u32; WIDTH] {
    let mut order = [0; WIDTH];
    for octant in 0..8 {
        let direction =
            Vec3A::from_array([0, 1, 2].map(|a| if octant >> a & 1 == 1 { -1.0 } else { 1.0 }));
        let mut keys = [(f32::INFINITY, 0); WIDTH];
        for (i, key) in keys.iter_mut().enumerate() {
            let distance = boxes.get(i).map(|b| (b.min + b.max).dot(direction));
            *key = (distance.unwrap_or(f32::INFINITY), i as u32);
        }
        keys.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (position, (_, child)) in keys.into_iter().enumerate() {
            order[position] |= child << (3 * octant);
        }
    }
    order
}

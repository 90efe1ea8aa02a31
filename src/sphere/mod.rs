//! Binary bounding-sphere hierarchy.
//!
//! The tree of [`crate::bvh`] with spheres for boxes, the oldest of bounds (Whitted, "An Improved Illumination Model
//! for Shaded Display", CACM 23(6), 1980): a sphere takes four numbers where a box takes six, and does not care how the
//! scene is turned. It fits most things worse, above all long and flat ones.
//!
//! Choose it where flash is short and primitives are compact. It costs 40 bytes a node where `bvh` costs 64, and visits
//! more nodes. Primitives stand in exactly one leaf, and a walk needs as deep a stack as that of the same tree of
//! boxes.
//!
//! # A node: 40 bytes
//! | offset | size | field | meaning |
//! |---|---|---|---|
//! | 0 | 24 | `centers` | for each of x, y, z: child 0's centre, child 1's |
//! | 24 | 8 | `radii` | child 0's radius, child 1's; infinite where it is beyond `f32` |
//! | 32 | 8 | `child` | as in a node of boxes |
//!
//! Nodes and slots stand in walk order, as in `bvh`.

#[cfg(feature = "build")]
pub mod build;
pub(crate) mod group;
mod walk;

use crate::blob::prims::Prims;
use crate::blob::{Blob, BlobError, Rule, Section};
use crate::bvh::Child;
use crate::bvh::tree::{self, Branch, Proof, Step};
use crate::geom::vec::{Vec3, finite};
use crate::geom::{Aabb, Sphere};
use crate::num::{count, index, wide};
use crate::walk::Part;
use bytemuck::{Pod, Zeroable};

/// An inner node, as the module's table says.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// For each axis the centre of child 0's sphere, and of child 1's.
    pub centers: [[f32; 2]; 3],
    /// Their radii.
    pub radii: [f32; 2],
    /// The children.
    pub child: [Child; 2],
}

const _: () = assert!(size_of::<Node>() == 40);

impl Node {
    /// A node of two spheres over two children.
    #[must_use]
    pub const fn new([a, b]: [Sphere; 2], child: [Child; 2]) -> Self {
        let (p, q) = (a.center, b.center);
        Self { centers: [[p[0], q[0]], [p[1], q[1]], [p[2], q[2]]], radii: [a.radius, b.radius], child }
    }

    /// The sphere of child 0 or 1.
    #[must_use]
    pub const fn sphere(&self, side: usize) -> Sphere {
        let (side, [x, y, z]) = (side & 1, &self.centers);
        Sphere { center: [x[side], y[side], z[side]], radius: self.radii[side] }
    }
}

impl Branch for Node {
    const SECTION: Section = Section::SphereNodes;

    #[inline(always)]
    fn children(&self) -> [Child; 2] {
        self.child
    }

    fn bounds(&self, side: usize) -> Aabb {
        self.sphere(side).bounds()
    }
}

/// The square of the distance from a point to the farthest corner of a box, but for some `2^-51` of it.
#[must_use]
pub fn farthest(center: Vec3, b: &Aabb) -> f64 {
    let along = |k: usize| {
        let (below, above) = (wide(center[k]) - wide(b.min[k]), wide(b.max[k]) - wide(center[k]));
        if below > above { below } else { above }
    };
    let [x, y, z] = [along(0), along(1), along(2)];
    x * x + (y * y + z * z)
}

/// Whether a sphere contains a box, as builder and check decide. `false` for a radius below 0 or NaN.
#[must_use]
pub fn encloses(sphere: &Sphere, b: &Aabb) -> bool {
    let radius = wide(sphere.radius);
    radius >= 0.0 && farthest(sphere.center, b) <= radius * radius
}

/// The hierarchy in a blob.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The inner nodes.
    pub nodes: &'a [Node],
}

impl<'a> View<'a> {
    /// The section of nodes, O(1): rule 10.
    ///
    /// # Errors
    /// The rule, if it is broken.
    pub fn parse(blob: &Blob<'a>) -> Result<Self, BlobError> {
        Ok(Self { nodes: blob.section(Section::SphereNodes)? })
    }

    /// Most steps of a walk: every node, and every primitive.
    #[must_use]
    pub const fn steps(&self, prims: &Prims<'_>) -> u32 {
        count(self.nodes.len()).saturating_add(prims.len)
    }

    /// Calls `each` with every inner node and every leaf, a node before what is below it, each with the box of its
    /// sphere.
    pub fn parts(&self, prims: &Prims<'_>, bounds: &Aabb, each: &mut impl FnMut(Part)) {
        tree::parts(self.nodes, prims.len, bounds, each);
    }

    /// The full check: rules 20, 21, 23 and 50. O(n) for each level of the tree, with a stack as deep as the walk's.
    ///
    /// Returns the deepest stack of any walk.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    pub fn check(&self, prims: &Prims<'_>, bounds: &Aabb) -> Result<u32, BlobError> {
        tree::check(self.nodes, prims.len, &Spheres { nodes: self.nodes, prims, bounds })
    }
}

/// Rule 50: each sphere has its centre in the bounds and contains the boxes of all primitives below it.
struct Spheres<'c, 'a> {
    nodes: &'a [Node],
    prims: &'c Prims<'a>,
    bounds: &'c Aabb,
}

impl Proof for Spheres<'_, '_> {
    fn node(&self, number: u32, _: &[Step]) -> Result<(), BlobError> {
        let node = self.nodes.get(index(number)).ok_or(tree::broken::<Node>(Rule::NodeOrder, number))?;
        let inside = |s: Sphere| finite(s.center) && self.bounds.contains(&Aabb { min: s.center, max: s.center });
        if inside(node.sphere(0)) && inside(node.sphere(1)) {
            return Ok(());
        }
        Err(tree::broken::<Node>(Rule::SphereBounds, number))
    }

    /// Of spheres inside spheres nothing is asked, only of what they are there for.
    fn leaf(&self, (first, len): (u32, u32), way: &[Step]) -> Result<(), BlobError> {
        for prim in (first..first.saturating_add(len)).filter_map(|slot| self.prims.get(slot)) {
            let b = prim.bounds();
            for step in way {
                let sphere = self.nodes.get(index(step.node)).map(|node| node.sphere(step.side));
                if !sphere.is_some_and(|s| encloses(&s, &b)) {
                    return Err(tree::broken::<Node>(Rule::SphereBounds, step.node));
                }
            }
        }
        Ok(())
    }
}

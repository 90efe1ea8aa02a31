//! The walk: depth first, nearer child first.
//!
//! `best.t` shrinks as hits are found, and a box that begins beyond it is passed over; one that begins at it is not,
//! because a primitive there may have the lesser number. The farther child waits on the stack with its near distance,
//! so that it is dropped without a fetch if a hit came nearer meanwhile. Rule 23 bounds the stack, and a push beyond it
//! is refused, not trusted.
use super::tree::{Branch, root};
use super::{Child, Face, Node, View};
use crate::blob::MAX_STACK;
use crate::blob::prims::Prims;
use crate::geom::ray::Prepared;
use crate::geom::vec::{least, most};
use crate::num::index;
use crate::walk::{Best, Meter, Stop, test};

/// What the box tests of a walk read of the ray: for each axis the row of the nearer and of the farther plane.
#[derive(Clone, Copy)]
pub(crate) struct Rows {
    pub(crate) near: [Face; 3],
    pub(crate) far: [Face; 3],
}

impl Rows {
    #[inline(always)]
    pub(crate) const fn new(ray: &Prepared) -> Self {
        Self::of(ray.negative)
    }

    /// Those of directions with these signs.
    #[inline(always)]
    pub(crate) const fn of(negative: [bool; 3]) -> Self {
        let (mut near, mut far) = ([Face::MinX, Face::MinY, Face::MinZ], [Face::MaxX, Face::MaxY, Face::MaxZ]);
        if negative[0] {
            (near[0], far[0]) = (Face::MaxX, Face::MinX);
        }
        if negative[1] {
            (near[1], far[1]) = (Face::MaxY, Face::MinY);
        }
        if negative[2] {
            (near[2], far[2]) = (Face::MaxZ, Face::MinZ);
        }
        Self { near, far }
    }
}

/// What a walk asks of a node, once prepared for a ray.
pub(crate) trait Test<N> {
    /// An interval of `t` that holds every hit below child `C` from the ray's `t_min` to `t_max`; empty, its first
    /// number greater than its second, if there is none. Neither number is NaN.
    fn interval<const C: usize>(&self, node: &N, ray: &Prepared, t_max: f32) -> (f32, f32);
}

impl Test<Node> for Rows {
    /// The slab test of [`Prepared::slab`], cut to the ray's interval: the same steps in the same order.
    #[inline(always)]
    fn interval<const C: usize>(&self, node: &Node, ray: &Prepared, t_max: f32) -> (f32, f32) {
        let near = |k: usize, t: f32| most(ray.near(k, node.planes[self.near[k].at()][C]), t);
        let far = |k: usize, t: f32| least(ray.far(k, node.planes[self.far[k].at()][C]), t);
        (near(2, near(1, near(0, ray.t_min))), far(2, far(1, far(0, t_max))))
    }
}

/// Finds the closest hit, or with `ANY` whether there is one. Returns whether the walk ended at a hit.
///
/// # Errors
/// [`Stop`] if the meter runs out or the bytes contradict themselves.
// On a host out of line: inlined, the loop shares the registers with whatever surrounds the query, and was 5 to 12 %
// slower for every kind of ray. On Cortex-M4F it is inlined: out of line it takes 2 % more instructions and 300 bytes
// more stack. And written out, though [`descend`] is the same loop: through that, rays in a kitchen took 15 to 35 %
// longer.
#[cfg_attr(feature = "std", inline(never))]
#[cfg_attr(not(feature = "std"), inline)]
pub fn walk<const ANY: bool>(
    view: &View<'_>,
    prims: &Prims<'_>,
    ray: &Prepared,
    best: &mut Best,
    meter: &mut impl Meter,
) -> Result<bool, Stop> {
    let rows = Rows::new(ray);
    let mut stack = heapless::Vec::<_, { index(MAX_STACK) }>::new();
    let mut at = root(view.nodes, prims.len);
    loop {
        // Descend, nearer child first, to a leaf or to where both children are missed.
        let leaf = loop {
            if !at.is_node() {
                break at;
            }
            if !meter.node() {
                return Err(Stop::Fuel);
            }
            let node = view.nodes.get(index(at.number())).ok_or(Stop::Corrupt)?;
            meter.at(|| node.bounds(0).join(&node.bounds(1)));
            let (near0, far0) = rows.interval::<0>(node, ray, best.t);
            let (near1, far1) = rows.interval::<1>(node, ray, best.t);
            let [child0, child1] = node.child;
            match (near0 <= far0, near1 <= far1) {
                (true, true) => {
                    let swap = near1 < near0;
                    let (first, later) = if swap { (child1, (child0, near0)) } else { (child0, (child1, near1)) };
                    stack.push(later).map_err(|_| Stop::Corrupt)?;
                    at = first;
                }
                (true, false) => at = child0,
                (false, true) => at = child1,
                (false, false) => break Child::NONE,
            }
        };
        if leaf.len() > 0 && test::<ANY>(prims, (leaf.number(), leaf.len()), ray, best, meter)? {
            return Ok(true);
        }
        // Go on with the latest waiting child that is not beyond the best hit.
        at = loop {
            match stack.pop() {
                Some((child, near)) if near <= best.t => break child,
                Some(_) => {}
                None => return Ok(false),
            }
        };
    }
}

/// The walk of any binary tree in walk order, from a child on.
#[inline(always)]
pub(crate) fn descend<const ANY: bool, N: Branch>(
    nodes: &[N],
    from: Child,
    tester: &impl Test<N>,
    prims: &Prims<'_>,
    ray: &Prepared,
    best: &mut Best,
    meter: &mut impl Meter,
) -> Result<bool, Stop> {
    let mut stack = heapless::Vec::<_, { index(MAX_STACK) }>::new();
    let mut at = from;
    loop {
        // Descend, nearer child first, to a leaf or to where both children are missed.
        let leaf = loop {
            if !at.is_node() {
                break at;
            }
            if !meter.node() {
                return Err(Stop::Fuel);
            }
            let node = nodes.get(index(at.number())).ok_or(Stop::Corrupt)?;
            meter.at(|| node.bounds(0).join(&node.bounds(1)));
            let (near0, far0) = tester.interval::<0>(node, ray, best.t);
            let (near1, far1) = tester.interval::<1>(node, ray, best.t);
            let [child0, child1] = node.children();
            match (near0 <= far0, near1 <= far1) {
                (true, true) => {
                    let swap = near1 < near0;
                    let (first, later) = if swap { (child1, (child0, near0)) } else { (child0, (child1, near1)) };
                    stack.push(later).map_err(|_| Stop::Corrupt)?;
                    at = first;
                }
                (true, false) => at = child0,
                (false, true) => at = child1,
                (false, false) => break Child::NONE,
            }
        };
        if leaf.len() > 0 && test::<ANY>(prims, (leaf.number(), leaf.len()), ray, best, meter)? {
            return Ok(true);
        }
        // Go on with the latest waiting child that is not beyond the best hit.
        at = loop {
            match stack.pop() {
                Some((child, near)) if near <= best.t => break child,
                Some(_) => {}
                None => return Ok(false),
            }
        };
    }
}

//! The walk: depth first, children in the order in which the ray meets them.
//!
//! The three planes that halve a node have a near and a far distance each. A child before a plane ends at its far
//! distance at the latest, a child behind it begins at its near one at the earliest, and a child is visited if what is
//! left of the node's interval is not empty: so a leaf's interval is its cell's slab interval, as [`crate::geom`],
//! rule 6, asks. Children are numbered by the planes that lie before them and come in ascending order, so that one
//! behind some planes comes before one behind those and more.
//!
//! `best.t` shrinks as hits are found, and what begins beyond it is passed over; what begins at it is not, because a
//! primitive there may have the lesser number. A hit beyond its leaf is kept. The stack has one entry for each node
//! above that has children left (rule 42 bounds it), and a push beyond it is refused, not trusted.
use super::{Cell, Child, MAX_LEVELS, View};
use crate::blob::prims::Prims;
use crate::geom::lattice::Lattice;
use crate::geom::ray::{Axis, Prepared};
use crate::geom::vec::{least, most};
use crate::grid::Shape;
use crate::num::index;
use crate::walk::{Best, Mailbox, Meter, Stop, test_listed};

/// A node that the ray is in, and its children that are still to be visited.
#[derive(Clone, Copy, Debug)]
struct Visit {
    number: u32,
    cell: Cell,
    t: (f32, f32),
    /// Children by the planes before them.
    rest: u32,
}

/// The distances of the planes that halve a node.
struct Middle {
    near: [f32; 3],
    far: [f32; 3],
}

impl Middle {
    #[inline(always)]
    fn new(ray: &Prepared, lattice: &Lattice, cell: &Cell) -> Self {
        let at = cell.middle();
        let planes = Axis::ALL.map(|k| lattice.plane(k, at[k.at()]));
        Self {
            near: Axis::ALL.map(|k| ray.near(k.at(), planes[k.at()])),
            far: Axis::ALL.map(|k| ray.far(k.at(), planes[k.at()])),
        }
    }

    /// What is left of the node's interval in the child behind the planes whose bits are set in `behind`. A NaN
    /// constrains nothing.
    #[inline(always)]
    fn part(&self, behind: u32, (near, far): (f32, f32)) -> (f32, f32) {
        let (mut t0, mut t1) = (near, far);
        for (k, bit) in [(Axis::X, 1), (Axis::Y, 2), (Axis::Z, 4)] {
            if behind & bit != 0 {
                t0 = most(self.near[k.at()], t0);
            } else {
                t1 = least(self.far[k.at()], t1);
            }
        }
        (t0, t1)
    }

    /// The children, by the planes before them, of which [`Middle::part`] leaves anything: all pairs of an end that can
    /// be a child's first with one that can be its last.
    #[inline(always)]
    fn met(&self, (near, far): (f32, f32)) -> u32 {
        /// Children behind the plane of each axis.
        const BEHIND: [u32; 3] = [0xaa, 0xcc, 0xf0];
        let mut without = 0;
        for k in Axis::ALL.map(Axis::at) {
            without |= if self.near[k] > far { BEHIND[k] } else { 0 };
            without |= if self.far[k] < near { !BEHIND[k] } else { 0 };
            for j in Axis::ALL.map(Axis::at) {
                without |= if j != k && self.near[k] > self.far[j] { BEHIND[k] & !BEHIND[j] } else { 0 };
            }
        }
        0xff & !without
    }
}

/// Which children lie before which planes, for a ray of these signs: child `c` is behind the planes of `c ^ signs`.
#[derive(Clone, Copy)]
struct Signs(u32);

impl Signs {
    fn new(ray: &Prepared) -> Self {
        let [x, y, z] = ray.negative.map(u32::from);
        Self(x | y << 1 | z << 2)
    }

    /// A set of children as the set of the planes before them, or the other way round.
    #[inline(always)]
    const fn mirror(self, set: u32) -> u32 {
        let x = if self.0 & 1 == 0 { set } else { (set & 0x55) << 1 | (set >> 1 & 0x55) };
        let y = if self.0 & 2 == 0 { x } else { (x & 0x33) << 2 | (x >> 2 & 0x33) };
        if self.0 & 4 == 0 { y } else { (y & 0x0f) << 4 | (y >> 4 & 0x0f) }
    }
}

impl View<'_> {
    /// Finds the closest hit, or with `ANY` whether there is one. Returns whether the walk ended at a hit.
    ///
    /// # Errors
    /// [`Stop`] if the meter runs out or the bytes contradict themselves.
    // Out of line everywhere: a query has one function for all structures, whose stack would be that of the deepest.
    #[inline(never)]
    pub fn walk<const ANY: bool>(
        &self,
        prims: &Prims<'_>,
        ray: &Prepared,
        best: &mut Best,
        meter: &mut impl Meter,
        mailbox: &mut impl Mailbox,
    ) -> Result<bool, Stop> {
        // What is in the root cube and not in the scene's box is empty: of a flat scene's cube the most.
        let (near, far) = ray.slab(self.bounds);
        let t = (most(ray.t_min, near), least(best.t, far));
        if !(t.0 <= t.1) {
            return Ok(false);
        }
        let Some(shape) = self.shape else {
            if !meter.node() {
                return Err(Stop::Fuel);
            }
            meter.at(|| *self.bounds);
            let list = self.lists.get(0).ok_or(Stop::Corrupt)?;
            return test_listed::<ANY>(prims, list, ray, best, meter, mailbox);
        };
        let root = (0, Cell::root(shape), t);
        from::<ANY>(self, prims, shape, root, ray, best, meter, mailbox)
    }
}

/// The walk from a node on, given its cell and an interval that holds what counts.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub(super) fn from<const ANY: bool>(
    view: &View<'_>,
    prims: &Prims<'_>,
    shape: &Shape,
    (number, cell, t): (u32, Cell, (f32, f32)),
    ray: &Prepared,
    best: &mut Best,
    meter: &mut impl Meter,
    mailbox: &mut impl Mailbox,
) -> Result<bool, Stop> {
    let (lattice, signs) = (&shape.lattice, Signs::new(ray));
    let mut stack = heapless::Vec::<Visit, MAX_LEVELS>::new();
    let Some(mut here) = start(shape, (number, cell), ray, t) else { return Ok(false) };
    loop {
        // Enter a node.
        if !meter.node() {
            return Err(Stop::Fuel);
        }
        meter.at(|| here.cell.bounds(lattice));
        if here.cell.side < 2 {
            return Err(Stop::Corrupt);
        }
        let mut node = *view.nodes.get(index(here.number)).ok_or(Stop::Corrupt)?;
        let mut middle = Middle::new(ray, lattice, &here.cell);
        here.rest = middle.met(here.t) & signs.mirror(node.children());
        // Test leaves until a child is a node.
        here = loop {
            if here.rest == 0 {
                // Go on with the latest node that has children left.
                let Some(above) = stack.pop() else { return Ok(false) };
                here = above;
                node = *view.nodes.get(index(here.number)).ok_or(Stop::Corrupt)?;
                middle = Middle::new(ray, lattice, &here.cell);
            }
            let behind = here.rest.trailing_zeros();
            here.rest &= here.rest.wrapping_sub(1);
            let (near, far) = middle.part(behind, here.t);
            if !(near <= best.t) {
                continue;
            }
            let c = behind ^ signs.0;
            let cell = here.cell.child(c);
            match node.child(c) {
                Child::Node(number) => {
                    if here.rest != 0 {
                        stack.push(here).map_err(|_| Stop::Corrupt)?;
                    }
                    break Visit { number, cell, t: (near, least(best.t, far)), rest: 0 };
                }
                Child::Leaf(list) => {
                    if !meter.node() {
                        return Err(Stop::Fuel);
                    }
                    meter.at(|| cell.bounds(lattice));
                    let list = view.lists.get(list).ok_or(Stop::Corrupt)?;
                    if test_listed::<ANY>(prims, list, ray, best, meter, mailbox)? {
                        return Ok(true);
                    }
                }
                Child::Empty => {}
            }
        };
    }
}

/// The ray in a cell; `None` if it misses that within an interval.
#[inline(always)]
fn start(shape: &Shape, (number, cell): (u32, Cell), ray: &Prepared, (mut near, mut far): (f32, f32)) -> Option<Visit> {
    for axis in Axis::ALL {
        let k = axis.at();
        let (low, high) = (cell.corner[k], cell.corner[k].wrapping_add(cell.side));
        let (first, last) = if ray.negative[k] { (high, low) } else { (low, high) };
        near = most(ray.near(k, shape.lattice.plane(axis, first)), near);
        far = least(ray.far(k, shape.lattice.plane(axis, last)), far);
    }
    (near <= far).then_some(Visit { number, cell, t: (near, far), rest: 0 })
}

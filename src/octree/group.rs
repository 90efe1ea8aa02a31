//! Groups of rays: the cells of nodes and leaves are the boxes.
use super::walk::from;
use super::{Cell, Child, View};
use crate::blob::prims::Prims;
use crate::geom::Aabb;
use crate::geom::ray::Prepared;
use crate::geom::vec::{least, most};
use crate::num::index;
use crate::walk::group::{Heading, Slots, Tree};
use crate::walk::mailbox::NoMailbox;
use crate::walk::{Best, Meter, Stop, test_listed};

/// The tree with its primitives.
pub(crate) struct Cells<'q, 'a> {
    pub view: &'q View<'a>,
    pub prims: &'q Prims<'a>,
}

/// A node with its cell, or a leaf.
#[derive(Clone, Copy)]
pub(crate) enum Place {
    Node(u32, Cell),
    /// The list of this number.
    Leaf(u32),
}

impl<'a> Tree<'a> for Cells<'_, 'a> {
    type Place = Place;

    #[inline(always)]
    fn root(&self) -> (Place, Aabb) {
        // What is in the root cube and not in the scene's box is empty.
        (self.view.shape.map_or(Place::Leaf(0), |shape| Place::Node(0, Cell::root(shape))), *self.view.bounds)
    }

    #[inline(always)]
    fn open(
        &self,
        at: Place,
        _: &Aabb,
        heading: &Heading,
        mut child: impl FnMut(Place, Aabb) -> Result<(), Stop>,
    ) -> Result<Option<Slots<'a>>, Stop> {
        let (number, cell) = match at {
            Place::Leaf(list) => return Ok(Some(Slots::List(self.view.lists.get(list).ok_or(Stop::Corrupt)?))),
            Place::Node(number, cell) => (number, cell),
        };
        let node = self.view.nodes.get(index(number)).ok_or(Stop::Corrupt)?;
        let lattice = &self.view.shape.filter(|_| cell.side >= 2).ok_or(Stop::Corrupt)?.lattice;
        let signs = u32::from(heading.is_negative(0)) | u32::from(heading.is_negative(1)) << 1;
        let signs = signs | u32::from(heading.is_negative(2)) << 2;
        for behind in (0..8).rev() {
            let c = behind ^ signs;
            let cell = cell.child(c);
            match node.child(c) {
                Child::Empty => {}
                Child::Node(number) => child(Place::Node(number, cell), cell.bounds(lattice))?,
                Child::Leaf(list) => child(Place::Leaf(list), cell.bounds(lattice))?,
            }
        }
        Ok(None)
    }

    #[inline(always)]
    fn alone<const ANY: bool>(
        &self,
        at: Place,
        bounds: &Aabb,
        ray: &Prepared,
        best: &mut Best,
        meter: &mut impl Meter,
    ) -> Result<bool, Stop> {
        match (at, self.view.shape) {
            (Place::Node(number, cell), Some(shape)) => {
                let (near, far) = ray.slab(bounds);
                let t = (most(ray.t_min, near), least(best.t, far));
                from::<ANY>(self.view, self.prims, shape, (number, cell, t), ray, best, meter, &mut NoMailbox)
            }
            (Place::Node(..), None) => Err(Stop::Corrupt),
            (Place::Leaf(list), _) => {
                if !meter.node() {
                    return Err(Stop::Fuel);
                }
                let list = self.view.lists.get(list).ok_or(Stop::Corrupt)?;
                test_listed::<ANY>(self.prims, list, ray, best, meter, &mut NoMailbox)
            }
        }
    }
}

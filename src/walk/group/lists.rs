//! The walk with lists of rays for masks: the lecture's form, to be compared with.
use super::{FEW, RAYS, State, Tree};
use crate::blob::MAX_STACK;
use crate::blob::prims::Prims;
use crate::geom::Aabb;
use crate::num::index;
use crate::walk::lanes::Lanes;
use crate::walk::{Meter, Stop, Tally};

/// Most numbers in all lists: those of as many nodes as can wait, and the last.
const LISTED: usize = RAYS * (index(MAX_STACK) + 2);

impl State {
    /// All rays, node by node: the lecture's stack of references to rays. A node's rays are a run of the list; those
    /// that meet a child are copied above it, and taken off when the child is done.
    #[inline(always)]
    pub(super) fn walk_lists<'a, T: Tree<'a>, const ANY: bool, L: Lanes<8>>(
        &mut self,
        tree: &T,
        prims: &Prims<'a>,
        mut alive: u64,
        meter: &mut Tally,
    ) -> Result<(), Stop> {
        let mut stack = heapless::Vec::<(T::Place, Aabb, usize, usize), { index(2 * MAX_STACK) }>::new();
        let mut list = heapless::Vec::<u8, LISTED>::new();
        for i in (0u8..64).filter(|i| alive >> i & 1 == 1) {
            list.push(i).map_err(|_| Stop::Corrupt)?;
        }
        let (root, bounds) = tree.root();
        stack.push((root, bounds, 0, list.len())).map_err(|_| Stop::Corrupt)?;
        while let Some((at, bounds, first, last)) = stack.pop() {
            list.truncate(last);
            let mut rays = 0;
            for place in first..last {
                let i = list.get(place).copied().unwrap_or(0) % 64;
                if alive >> i & 1 == 1 && self.bundle.meets_box(usize::from(i), &bounds) {
                    list.push(i).map_err(|_| Stop::Corrupt)?;
                    rays |= 1 << i;
                }
            }
            if rays == 0 {
                continue;
            }
            if list.len().saturating_sub(last) <= index(FEW) {
                alive &= !self.alone::<T, ANY>(tree, at, &bounds, rays, meter)?;
                continue;
            }
            if tree.costs(at) && !meter.node() {
                return Err(Stop::Fuel);
            }
            let (first, last) = (last, list.len());
            let opened = tree.open(at, &bounds, &self.heading, |child, bounds| {
                stack.push((child, bounds, first, last)).map_err(|_| Stop::Corrupt)
            })?;
            if let Some(slots) = opened {
                alive &= !self.leaf::<ANY, L>(prims, slots, rays, meter)?;
            }
        }
        Ok(())
    }
}

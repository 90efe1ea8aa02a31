//! Rays that have nothing in common, in turns.
//!
//! A ray alone waits: for memory, for the chain of a node's steps, and for the machine to start anew after each branch that
//! it foretold wrongly. So up to 64 rays are on their way at once. Each has a stack of its own and goes its own way, nearest
//! child first, as it would alone; but they do their steps in turns, first all that stand at a node, then all that stand at
//! a leaf. What is next for a ray is not branched on but written into the one queue or the other, and its memory is asked
//! for a turn ahead. (After Tsakok, "Faster Incoherent Rays: Multi-BVH Ray Stream Tracing", HPG 2009, and Barringer and
//! Akenine-Moller, "Dynamic Ray Stream Traversal", ACM TOG 33(4), 2014, where rays of a stream visit a node together.)
// Both sides of an `&&` may be a branch; here nothing is to be foretold.
#![allow(clippy::needless_bitwise_bool)]

mod crowd;

use super::many::{Answer, Many, Purse};
use super::slabs::Slabs;
use super::walk::{Waiting, is_nearer, lane};
use super::{In, Node, Wide};
use crate::blob::block::Block;
use crate::bvh::Child;
use crate::bvh::tree::root;
use crate::geom::Ray;
use crate::geom::vec::most;
use crate::num::{byte, count, index};
use crate::walk::lanes::{Lanes, Work};
use crate::walk::{Best, Meter, Stop, block};
use core::hint::select_unpredictable;
use crowd::AT_ONCE;
use crowd::{One, Rays};

/// Rays on their way at once.
pub(super) const RAYS: usize = 64;
/// Entries of a ray's stack. A ray that needs more starts again, alone.
const DEPTH: usize = 32;
/// So many leaves ahead a leaf's memory is asked for.
const AHEAD: usize = 4;

/// A query of up to 64 rays, to be compiled for each instruction set.
pub(super) struct Stream<'q, 'a, 'r, A, P, const ANY: bool, const W: usize> {
    pub many: Many<'q, 'a, W>,
    pub rays: &'r [Ray],
    pub answers: &'r mut [A],
    /// Those that are asked for.
    pub which: u64,
    pub crowd: &'r mut Crowd,
    pub purse: &'r mut P,
}

impl<A: Answer, P: Purse, const ANY: bool, const W: usize> Work for Stream<'_, '_, '_, A, P, ANY, W>
where
    Node<W>: Wide<W>,
{
    /// The rays that are not answered.
    type Output = u64;

    #[inline(always)]
    fn run<L8: Lanes<8>, L4: Lanes<4>>(self) -> u64 {
        let Self { many, rays, answers, which, crowd, purse } = self;
        let (mut alone, mut enter) = (0, 0);
        for (c, eight) in rays.chunks(AT_ONCE).enumerate() {
            let from = count(c * AT_ONCE);
            if (which >> from).trailing_zeros() >= 8 {
                continue;
            }
            let mut few = [Ray { origin: [0.0; 3], dir: [0.0; 3], t_min: 0.0, t_max: 0.0 }; AT_ONCE];
            let told = crowd.rays.set::<L8>(
                c,
                eight.first_chunk().unwrap_or_else(|| {
                    few.iter_mut().zip(eight).for_each(|(to, ray)| *to = *ray);
                    &few
                }),
                &mut crowd.best,
                many.place,
            );
            alone |= u64::from(!told.quick & 255) << from;
            enter |= u64::from(told.enter) << from;
        }
        alone &= which;
        enter &= which;
        let mut meter = purse.open(many.fuel.saturating_mul(count(RAYS)));
        let lost = crowd.walk::<ANY, W, In<W, L8, L4>, L4>(many, enter, &mut meter).unwrap_or(enter);
        let mut answered = which & !alone & !lost;
        while answered != 0 {
            let i = index(answered.trailing_zeros());
            answered &= answered - 1;
            if let Some(answer) = answers.get_mut(i) {
                *answer = A::new(crowd.best[i % RAYS].hit());
            }
        }
        alone | lost
    }
}

/// The rays, where they are, and their best hits so far.
pub(super) struct Crowd {
    rays: Rays,
    best: [Best; RAYS],
    at: [Child; RAYS],
    len: [usize; RAYS],
    /// Children that wait, the nearest last, above an entry that is none.
    stack: [[Waiting; DEPTH]; RAYS],
}

/// The numbers of rays whose turn comes. Aligned as the entries of a walk's stack are.
#[cfg_attr(target_arch = "x86_64", repr(align(32)))]
struct Queue {
    all: [u8; RAYS],
    len: usize,
}

impl Queue {
    const EMPTY: Self = Self { all: [0; RAYS], len: 0 };

    /// Adds a ray, if it is to be added; without a branch.
    #[inline(always)]
    fn put(&mut self, i: usize, if_so: bool) {
        self.all[self.len % RAYS] = byte(i);
        self.len = self.len.wrapping_add(usize::from(if_so));
    }

    #[inline(always)]
    fn get(&self, j: usize) -> usize {
        usize::from(self.all[j % RAYS]) % RAYS
    }
}

impl Crowd {
    /// All zeros: that is written, where other numbers would be copied from memory.
    pub(super) const EMPTY: Self = Self {
        rays: Rays::EMPTY,
        best: [Best::ZERO; RAYS],
        at: [Child::NONE; RAYS],
        len: [0; RAYS],
        stack: [[(Child::NONE, 0.0); DEPTH]; RAYS],
    };

    /// All rays to their ends. Returns those that had no room.
    #[inline(always)]
    fn walk<const ANY: bool, const W: usize, L: Lanes<W>, L4: Lanes<4>>(
        &mut self,
        many: Many<'_, '_, W>,
        mut enter: u64,
        meter: &mut impl Meter,
    ) -> Result<u64, Stop> {
        let root = root(many.view.nodes, many.prims.len);
        let (mut nodes, mut leaves) = (Queue::EMPTY, Queue::EMPTY);
        while enter != 0 {
            let i = index(enter.trailing_zeros()) % RAYS;
            enter &= enter - 1;
            (self.at[i], self.len[i]) = (root, 0);
            nodes.put(i, root.is_node());
            leaves.put(i, !root.is_node());
        }
        let mut lost = 0;
        while nodes.len | leaves.len != 0 {
            while nodes.len != 0 {
                let turn = nodes.len;
                nodes.len = 0;
                for j in 0..turn {
                    if !meter.node() {
                        return Err(Stop::Fuel);
                    }
                    let i = nodes.get(j);
                    let next = self.node::<ANY, W, L>(many.view.nodes, i)?;
                    if let Some(next) = next {
                        nodes.put(i, next.is_node() & (next != Child::NONE));
                        leaves.put(i, !next.is_node());
                    } else {
                        lost |= 1 << i;
                    }
                }
            }
            let turn = leaves.len;
            leaves.len = 0;
            for j in 0..turn {
                if let Some(block) = many.prims.blocks.get(index(self.at[leaves.get(j + AHEAD)].number())) {
                    L::prefetch(block);
                }
                let i = leaves.get(j);
                let next = self.leaf::<ANY, L4>(many.prims.blocks, i, meter)?;
                nodes.put(i, next.is_node() & (next != Child::NONE));
                leaves.put(i, !next.is_node());
            }
        }
        Ok(lost)
    }

    /// A ray's step at a node. `None` if there may be no room for its children.
    #[inline(always)]
    fn node<const ANY: bool, const W: usize, L: Lanes<W>>(
        &mut self,
        nodes: &[Node<W>],
        i: usize,
    ) -> Result<Option<Child>, Stop> {
        let i = i % RAYS;
        let node = nodes.get(index(self.at[i].number())).ok_or(Stop::Corrupt)?;
        let len = self.len[i];
        if len > DEPTH - W {
            return Ok(None);
        }
        let slabs = Slabs::<W, L, true>::of(&self.rays.slab(i));
        let (met, near) = slabs.test(node, self.best[i].t);
        let rest = met & met.wrapping_sub(1);
        let stack = &mut self.stack[i];
        let next;
        if rest & rest.wrapping_sub(1) == 0 {
            let (first, second) = (lane::<W>(met), lane::<W>(rest));
            // With `ANY` distances are not asked for again.
            let near = if ANY { [0.0; W] } else { near.store() };
            let two = rest != 0;
            let swap = !ANY & two & is_nearer::<true>(near[second], near[first]);
            let (a, b) = select_unpredictable(swap, (second, first), (first, second));
            let below = stack[len % DEPTH].0;
            // The greater is the other's distance: sooner known than the other is.
            stack[len.wrapping_add(1) % DEPTH] = (node.child[b], most(near[first], near[second]));
            next = select_unpredictable(met == 0, below, node.child[a]);
            let less = (met == 0) & (len != 0);
            self.len[i] = self.len[i].wrapping_add(usize::from(two)).wrapping_sub(usize::from(less));
        } else {
            let (child, top) = many::<ANY, W, L>(node, near, met, stack, len);
            next = child;
            self.len[i] = top;
        }
        self.at[i] = next;
        if let Some(node) = nodes.get(index(next.number())) {
            L::prefetch(node);
        }
        Ok(Some(next))
    }

    /// A ray's step at a leaf.
    #[inline(always)]
    fn leaf<const ANY: bool, L: Lanes<4>>(
        &mut self,
        blocks: &[Block],
        i: usize,
        meter: &mut impl Meter,
    ) -> Result<Child, Stop> {
        let i = i % RAYS;
        let (at, ray) = (self.at[i], One { rays: &self.rays, i });
        let best = &mut self.best[i];
        let before = best.t;
        if block::test::<ANY, L>(blocks, (at.number(), at.len()), ray, best, meter)? {
            return Ok(Child::NONE);
        }
        let (stack, mut len) = (&mut self.stack[i], self.len[i]);
        if !ANY && best.t < before {
            // Those that begin beyond the hit need not wait any longer.
            let mut kept = 0usize;
            for from in 1..=len {
                let entry = stack[from % DEPTH];
                kept = kept.wrapping_add(1);
                stack[kept % DEPTH] = entry;
                kept = kept.wrapping_sub(usize::from(entry.1 > best.t));
            }
            len = kept;
        }
        let next = stack[len % DEPTH].0;
        self.len[i] = len.saturating_sub(1);
        self.at[i] = next;
        Ok(next)
    }
}

/// Puts all children but the nearest on the stack, the nearer above the farther; with `ANY` as they stand.
#[inline(always)]
fn many<const ANY: bool, const W: usize, L: Lanes<W>>(
    node: &Node<W>,
    near: L,
    met: u32,
    stack: &mut [Waiting; DEPTH],
    len: usize,
) -> (Child, usize) {
    let near = if ANY { [0.0; W] } else { near.store() };
    let (mut rest, mut top) = (met, len);
    if ANY {
        rest &= rest - 1;
    }
    while rest != 0 {
        let lane = lane::<W>(rest);
        rest &= rest - 1;
        let mut place = top.wrapping_add(1);
        top = place;
        let own = near[lane];
        while !ANY && place > len.wrapping_add(1) && is_nearer::<true>(stack[place.wrapping_sub(1) % DEPTH].1, own) {
            stack[place % DEPTH] = stack[place.wrapping_sub(1) % DEPTH];
            place = place.wrapping_sub(1);
        }
        stack[place % DEPTH] = (node.child[lane], own);
    }
    if ANY { (node.child[lane::<W>(met)], top) } else { (stack[top % DEPTH].0, top.wrapping_sub(1)) }
}

//! The walk: all children of a node at once, the nearest first.
//!
//! The interval of a child is that of [`Prepared::slab`], cut to the ray's: the same steps on each lane, but that extremes are
//! taken in another order, which changes nothing. Where one child is met, and that is most often so, the walk goes on with it
//! and nothing else is done; of several the nearest is next, and the others wait, the nearer above the farther.
use super::slabs::Slabs;
use super::{Node, STACK, View, slots};
use crate::blob::prims::Prims;
use crate::bvh::Child;
use crate::bvh::tree::root;
use crate::geom::Aabb;
use crate::geom::ray::Prepared;
use crate::num::index;
use crate::walk::aim::Known;
use crate::walk::lanes::{Lanes, Row};
use crate::walk::{Best, Meter, Stop, block, test};
use core::borrow::BorrowMut;
use core::hint::select_unpredictable;

impl<const W: usize> View<'_, W> {
    /// The walk with what every machine has. Finds the closest hit, or with `ANY` whether there is one; returns whether it
    /// ended at a hit.
    ///
    /// # Errors
    /// [`Stop`] if the meter runs out or the bytes contradict themselves.
    // A scene asks this only where there are no lanes. There `bvh` is the one to choose, so the other walks come first: `cold`,
    // they take 1 % fewer instructions on Cortex-M4F.
    #[cold]
    #[inline(never)]
    pub fn walk<const ANY: bool>(
        &self,
        prims: &Prims<'_>,
        ray: &Prepared,
        best: &mut Best,
        meter: &mut impl Meter,
    ) -> Result<bool, Stop> {
        walk::<W, ANY, false, true, Row<W>, Row<4>>(self, prims, (ray, ()), Rest::new(), best, meter)
    }
}

/// A child that waits, and the distance at which its box begins.
pub(super) type Waiting = (Child, f32);

/// What waits beyond the top of a stack.
pub(super) type Rest = heapless::Vec<Waiting, { index(STACK) - TOP }>;

/// Entries of a stack that every walk has; the others take a push out of line.
const TOP: usize = 24;

/// Those entries. Aligned, and with them the frame of whoever has them: rows of eight numbers that lie across two cache lines
/// there take longer.
#[cfg_attr(target_arch = "x86_64", repr(align(32)))]
struct Top([Waiting; TOP]);

/// Children that wait, the nearest last. The rest may lie elsewhere: what is pointed to takes all that it is part of along, and
/// where there are registers enough the length is to be in one. Where there are few, the pointer would take one in vain.
struct Stack<R> {
    top: Top,
    len: usize,
    rest: R,
}

impl<R: BorrowMut<Rest>> Stack<R> {
    #[inline(always)]
    const fn new(rest: R) -> Self {
        Self { top: Top([(Child::NONE, 0.0); TOP]), len: 0, rest }
    }

    #[inline(always)]
    fn push(&mut self, entry: Waiting) -> Result<(), Stop> {
        match self.top.0.get_mut(self.len) {
            Some(place) => *place = entry,
            None => push(self.rest.borrow_mut(), entry)?,
        }
        self.len = self.len.wrapping_add(1);
        Ok(())
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Waiting> {
        self.len = self.len.checked_sub(1)?;
        match self.top.0.get(self.len) {
            Some(&entry) => Some(entry),
            None => pop(self.rest.borrow_mut()),
        }
    }
}

// Of the rest alone, so that the stack's length stays in a register.
#[cold]
#[inline(never)]
fn push(rest: &mut Rest, entry: Waiting) -> Result<(), Stop> {
    rest.push(entry).map_err(|_| Stop::Corrupt)
}

#[cold]
#[inline(never)]
fn pop(rest: &mut Rest) -> Option<Waiting> {
    rest.pop()
}

/// Finds the closest hit, or with `ANY` whether there is one; with the quick box test if that is asked for, and only in blocks
/// unless `MIXED`. Takes the ray with what else is known of it, and where the rest of the stack may lie. Returns whether the
/// walk ended at a hit.
///
/// # Errors
/// [`Stop`] if the meter runs out or the bytes contradict themselves.
#[inline(always)]
pub(super) fn walk<const W: usize, const ANY: bool, const QUICK: bool, const MIXED: bool, L: Lanes<W>, L4: Lanes<4>>(
    view: &View<'_, W>,
    prims: &Prims<'_>,
    aim: (&Prepared, impl Known),
    rest: impl BorrowMut<Rest>,
    best: &mut Best,
    meter: &mut impl Meter,
) -> Result<bool, Stop> {
    let ray = aim.0;
    // Before what is read of the ray: small machines take 1 % fewer instructions.
    let mut stack = Stack::new(rest);
    let slabs = Slabs::<W, L, QUICK>::new(ray);
    let mut at = root(view.nodes, prims.len);
    let mut t_max = best.t;
    loop {
        // Descend, nearest child first, to a leaf or to where all children are missed.
        let leaf = loop {
            if !at.is_node() {
                break at;
            }
            if !meter.node() {
                return Err(Stop::Fuel);
            }
            let node = view.nodes.get(index(at.number())).ok_or(Stop::Corrupt)?;
            meter.at(|| (0..node.len()).fold(Aabb::EMPTY, |all, lane| all.join(&node.bounds(lane))));
            let (met, near) = slabs.test(node, t_max);
            if met == 0 {
                break Child::NONE;
            }
            let first = lane::<W>(met);
            let rest = met & (met - 1);
            if rest == 0 {
                at = node.child[first];
                continue;
            }
            if ANY {
                // Whichever comes first is good: the others wait as they stand, the lowest lane on top.
                at = others(node, met, &mut stack)?;
                continue;
            }
            let near = near.store();
            let second = lane::<W>(rest);
            let rest = rest & (rest - 1);
            let (a, b) = if is_nearer::<QUICK>(near[second], near[first]) { (second, first) } else { (first, second) };
            if !MIXED {
                fetch::<W, L>(view, prims, node.child[b]);
            }
            stack.push((node.child[b], near[b]))?;
            at = node.child[a];
            if rest != 0 {
                stack.push((at, near[a]))?;
                at = nearest::<W, QUICK>(node, &near, rest, &mut stack)?;
            }
        };
        if leaf.len() > 0 {
            let over = if MIXED && prims.blocks.is_empty() {
                // A copy, because that test points to its ray where f32 is not enough: what nobody points to stays in registers.
                let ray = *ray;
                test::<ANY>(prims, (slots(prims, leaf).0, leaf.len()), &ray, best, meter)?
            } else {
                block::test::<ANY, L4>(prims.blocks, (leaf.number(), leaf.len()), aim, best, meter)?
            };
            if over {
                return Ok(true);
            }
            t_max = best.t;
        }
        // Go on with the latest waiting child that is not beyond the best hit.
        at = loop {
            match stack.pop() {
                Some((child, near)) if !is_nearer::<QUICK>(t_max, near) => break child,
                Some(_) => {}
                None => return Ok(false),
            }
        };
    }
}

/// Asks for the memory of a child that waits, so that it need not be waited for. Whether it is a leaf is not branched on.
#[inline(always)]
fn fetch<const W: usize, L: Lanes<W>>(view: &View<'_, W>, prims: &Prims<'_>, child: Child) {
    let n = index(child.number());
    let (nodes, blocks) = (view.nodes.as_ptr().wrapping_add(n), prims.blocks.as_ptr().wrapping_add(n));
    L::prefetch_at(select_unpredictable(child.is_node(), nodes.cast(), blocks.cast()), size_of::<Node<W>>());
}

/// Whether a distance is less than another, neither of which is NaN; as whole numbers where neither is negative, which is
/// sooner known. `-0.0` is then less than `0.0`, and minus infinity than both.
#[inline(always)]
pub(super) const fn is_nearer<const QUICK: bool>(a: f32, b: f32) -> bool {
    if QUICK { a.to_bits().cast_signed() < b.to_bits().cast_signed() } else { a < b }
}

/// The lowest lane of those whose bits are on.
#[inline(always)]
pub(super) const fn lane<const W: usize>(met: u32) -> usize {
    index(met.trailing_zeros()) % W
}

/// Puts all children but that of the lowest lane on the stack, and takes that.
#[inline(always)]
fn others<const W: usize>(
    node: &Node<W>,
    mut met: u32,
    stack: &mut Stack<impl BorrowMut<Rest>>,
) -> Result<Child, Stop> {
    loop {
        let high = index(31u32.wrapping_sub(met.leading_zeros())) % W;
        met &= !(1 << high);
        if met == 0 {
            return Ok(node.child[high]);
        }
        stack.push((node.child[high], f32::NEG_INFINITY))?;
    }
}

/// Puts the children of lanes `rest` among the two on top of the stack, the nearest above the others, and takes that.
#[inline(always)]
fn nearest<const W: usize, const QUICK: bool>(
    node: &Node<W>,
    near: &[f32; W],
    mut rest: u32,
    stack: &mut Stack<impl BorrowMut<Rest>>,
) -> Result<Child, Stop> {
    let mut sorted = 2usize;
    while rest != 0 {
        let lane = lane::<W>(rest);
        rest &= rest - 1;
        stack.push((node.child[lane], near[lane]))?;
        let mut place = stack.len.wrapping_sub(1);
        for _ in 0..sorted {
            match stack.top.0.get_mut(place.wrapping_sub(1)..=place) {
                Some([below, above]) if is_nearer::<QUICK>(below.1, above.1) => core::mem::swap(below, above),
                _ => break,
            }
            place = place.wrapping_sub(1);
        }
        sorted = sorted.saturating_add(1);
    }
    stack.pop().map(|(child, _)| child).ok_or(Stop::Corrupt)
}

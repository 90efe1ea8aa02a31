//! Better places for subtrees until there are none, on all cores.
//!
//! What [`super::reinsert`] does one after another, here many subtrees look for at once, in a tree that meanwhile stays
//! as it is (Meister and Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization", CGF 37(2), 2018).
//! Each looks from its own place upwards: at each node on the way to the root it knows what the boxes below have shrunk
//! by without it, and so by how much less than that they have to grow elsewhere; most parts of the tree are passed over
//! at their top. Those that found a place move one after another, if they still gain: others that moved before may
//! have spoiled it, and then they stay.
//!
//! A batch is a share of the nodes, evenly spread over the tree so that few get in each other's way. What each of them
//! finds does not depend on when it looks, and they move in the order of their numbers: any number of threads makes the
//! same tree. Nothing is allocated: what is found stands in the scratch of the references.
use super::Place;
use super::reinsert::Links;
use crate::build::Ref;
use crate::build::sah::area;
use crate::bvh::Node;
use crate::geom::Aabb;
use crate::geom::vec::{size, sub};
use crate::num::count;

/// Most batches of a round: the fewer, the less all threads wait for each other, and the more moves are spoiled.
const BATCHES: usize = 8;
/// A batch has at least so many nodes, if there are as many.
const BATCH: usize = 2048;
/// Rounds end when one brings less than this share of what all boxes add up to.
const ENOUGH: f32 = 1.0 / 8192.0;

/// A better place for a subtree.
#[derive(Clone, Copy)]
struct Move {
    /// What all boxes would shrink by.
    gain: f32,
    from: Place,
    to: Place,
}

impl Move {
    const fn none(from: Place) -> Self {
        Self { gain: 0.0, from, to: Place::ROOT }
    }

    /// As a reference's scratch. (A node's number has 28 bits.)
    fn pack(self) -> f32 {
        f32::from_bits(if self.gain > 0.0 { self.to.0 << 1 | count(self.from.side()) } else { u32::MAX })
    }

    /// What was packed for a child of a node.
    fn unpack(node: usize, scratch: f32) -> Option<Self> {
        let bits = scratch.to_bits();
        let from = Place::new(count(node), bits & 1);
        (bits != u32::MAX).then_some(Self { gain: 0.0, from, to: Place(bits >> 1) })
    }
}

/// Moves subtrees until that brings next to nothing, in at most so many rounds over all of them.
pub fn converge(refs: &mut [Ref], nodes: &mut [Node], bounds: &Aabb, rounds: u32) {
    // Areas in units of the scene, so that they neither overflow nor vanish.
    let unit = 1.0 / size(sub(bounds.max, bounds.min));
    let mut tree = Links { nodes, unit };
    let batches = (tree.nodes.len() / BATCH).clamp(1, BATCHES);
    for _ in 0..rounds {
        let mut gain = 0.0;
        for batch in 0..batches {
            let node = |i: usize| batch + i * batches;
            let len = tree.nodes.len().saturating_sub(batch).div_ceil(batches);
            let found = refs.get_mut(..len).unwrap_or(&mut []);
            fill(found, |i| {
                let [a, b] = [0, 1].map(|side| tree.find(Place::new(count(node(i)), side)));
                if b.gain > a.gain { b.pack() } else { a.pack() }
            });
            for one in found.iter().enumerate().filter_map(|(i, r)| Move::unpack(node(i), r.scratch)) {
                gain += tree.carry_out(&one);
            }
        }
        if !(gain > ENOUGH * tree.total()) {
            return;
        }
    }
}

/// Fills scratches with what `of` says about their numbers.
#[cfg(feature = "parallel")]
fn fill(refs: &mut [Ref], of: impl Fn(usize) -> f32 + Sync) {
    use rayon::prelude::*;
    /// Nodes to a thread at a time: some hundred microseconds.
    const SHARE: usize = 128;
    refs.par_iter_mut().enumerate().with_min_len(SHARE).for_each(|(i, r)| r.scratch = of(i));
}

#[cfg(not(feature = "parallel"))]
fn fill(refs: &mut [Ref], of: impl Fn(usize) -> f32) {
    refs.iter_mut().enumerate().for_each(|(i, r)| r.scratch = of(i));
}

impl Links<'_> {
    /// The best place for the subtree at a place.
    fn find(&self, from: Place) -> Move {
        let mut best = Move::none(from);
        let mut pivot = self.place(from.node());
        if pivot == Place::ROOT {
            return best;
        }
        // Its sibling takes the place of the node above both.
        let (bounds, mut rest) = (self.bounds(from), self.bounds(from.sibling()));
        let mut saved = area(&self.bounds(pivot), self.unit);
        let own = area(&bounds, self.unit);
        for side in 0..2 {
            let sibling = self.child(from.sibling());
            if sibling.is_node() {
                let grown = area(&rest.join(&bounds), self.unit) - area(&rest, self.unit);
                self.search(Place::new(sibling.number(), side), grown, saved, (&bounds, own), &mut best);
            }
        }
        loop {
            self.search(pivot.sibling(), 0.0, saved, (&bounds, own), &mut best);
            let above = self.place(pivot.node());
            if above == Place::ROOT {
                return best;
            }
            // The node above the pivot shrinks, too, and is a place itself.
            rest = rest.join(&self.bounds(pivot.sibling()));
            saved += area(&self.bounds(above), self.unit) - area(&rest, self.unit);
            let gain = saved - area(&rest.join(&bounds), self.unit);
            if gain > best.gain {
                (best.gain, best.to) = (gain, above);
            }
            pivot = above;
        }
    }

    /// Looks at a place and those below it. Boxes have shrunk by `saved`, and grown by `grown` on the way here.
    fn search(&self, at: Place, grown: f32, saved: f32, (bounds, own): (&Aabb, f32), best: &mut Move) {
        let mut todo = heapless::Vec::<(Place, f32), 128>::new();
        let mut next = Some((at, grown));
        while let Some((place, grown)) = next.take().or_else(|| todo.pop()) {
            // At least its own area is added.
            if saved - (grown + own) <= best.gain {
                continue;
            }
            let there = self.bounds(place);
            let joined = area(&there.join(bounds), self.unit);
            let gain = saved - (grown + joined);
            if gain > best.gain {
                (best.gain, best.to) = (gain, place);
            }
            let (child, grown) = (self.child(place), grown + (joined - area(&there, self.unit)));
            if child.is_node() && saved - (grown + own) > best.gain {
                // (A full stack, of a very deep tree, only narrows the search.)
                let _ = todo.push((Place::new(child.number(), 1), grown));
                next = Some((Place::new(child.number(), 0), grown));
            }
        }
    }

    /// Makes a move if it still can be made and gains; returns how much.
    fn carry_out(&mut self, one: &Move) -> f32 {
        let mut at = one.to;
        while at != Place::ROOT {
            if at.node() == one.from.node() && (at == one.from || at == one.to) {
                // Meanwhile it belongs to what would move, or stands beside it.
                return 0.0;
            }
            at = self.place(at.node());
        }
        self.carry(one.from, |tree, bounds, old| {
            let gain = tree.cost(bounds, old) - tree.cost(bounds, one.to);
            if gain > 0.0 { (one.to, gain) } else { (old, 0.0) }
        })
    }

    /// The sum of all boxes.
    fn total(&self) -> f32 {
        let both = |node: &Node| area(&node.bounds(0), self.unit) + area(&node.bounds(1), self.unit);
        self.nodes.iter().map(both).sum()
    }
}

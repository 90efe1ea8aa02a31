//! The plane of least expected cost.
//!
//! A random line that meets a box meets a part of it with the share of their areas (`MacDonald` and Booth, "Heuristics
//! for ray tracing using space subdivision", The Visual Computer 6, 1990), so a plane costs one step and the tests of
//! both parts by their shares. The cost is linear between the ends of the primitives' parts in the node, so only planes
//! there are tried (Wald and Havran, "On building fast kd-Trees for Ray Tracing, and on doing that in O(N log N)", IRT
//! 2006, section 3). Their sweep, and their O(N log N): ends are sorted anew in each node and axis, but as words and
//! digit by digit, so a level of the tree takes time linear in what its nodes list. That needs three arrays of words,
//! and no lists to keep in order.
//!
//! Costs are in units of one test times half the area of a box, and in f64, which neither 1e30 nor 1e-42 squared
//! leaves.
use super::{Cut, radix};
use crate::build::Ref;
use crate::geom::Aabb;
use crate::geom::ray::Axis;
use crate::num::{count, wide};

/// Cost of a step to a child, in primitive tests. With 1.5 the bunny's blob has 5.65 MB and not 4.47.
const STEP_COST: f64 = 2.5;
/// What is left of the cost where one part is empty (Wald and Havran 2006, section 3.1).
const EMPTY: f64 = 0.8;

/// A box seen along an axis: half its area is `ends + sides * length`.
struct Along {
    min: f64,
    max: f64,
    ends: f64,
    sides: f64,
}

impl Along {
    fn new(bounds: &Aabb, axis: Axis) -> Self {
        let side = |k: Axis| wide(bounds.max[k.at()]) - wide(bounds.min[k.at()]);
        let (a, b) = axis.others();
        let (a, b) = (side(a), side(b));
        Self { min: wide(bounds.min[axis.at()]), max: wide(bounds.max[axis.at()]), ends: a * b, sides: a + b }
    }

    fn cost(&self, plane: f32, left: usize, right: usize) -> f64 {
        let part = |length: f64, n: usize| (self.ends + self.sides * length) * f64::from(count(n));
        let tests = part(wide(plane) - self.min, left) + part(self.max - wide(plane), right);
        let tests = if left == 0 || right == 0 { tests * EMPTY } else { tests };
        tests + STEP_COST * (self.ends + self.sides * (self.max - self.min))
    }
}

/// What a split costs.
pub fn cost(bounds: &Aabb, cut: Cut, left: usize, right: usize) -> f64 {
    Along::new(bounds, cut.axis).cost(cut.plane, left, right)
}

/// What a leaf of `len` primitives costs.
pub fn leaf_cost(bounds: &Aabb, len: usize) -> f64 {
    let box_ = Along::new(bounds, Axis::X);
    (box_.ends + box_.sides * (box_.max - box_.min)) * f64::from(count(len))
}

/// The plane of least cost strictly inside a box; `None` if there is none, or `words` are fewer than twice the list, or
/// `spare` fewer than the list.
pub fn plane(list: &[Ref], words: &mut [u32], spare: &mut [u32], bounds: &Aabb) -> Option<Cut> {
    let (mins, rest) = words.split_at_mut_checked(list.len())?;
    let (maxs, spare) = (rest.get_mut(..list.len())?, spare.get_mut(..list.len())?);
    let mut best: Option<(f64, Cut)> = None;
    for axis in Axis::ALL {
        let (k, along) = (axis.at(), Along::new(bounds, axis));
        for ((min, max), r) in mins.iter_mut().zip(maxs.iter_mut()).zip(list) {
            (*min, *max) = (key(r.bounds.min[k]), key(r.bounds.max[k]));
        }
        let (mins, spare) = radix::sort(mins, spare);
        let (maxs, _) = radix::sort(maxs, spare);
        sweep(mins, maxs, |end, left, right| {
            let plane = value(end);
            if bounds.min[k] < plane && plane < bounds.max[k] {
                let cost = along.cost(plane, left, right);
                if best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, Cut { axis, plane }));
                }
            }
        });
    }
    best.map(|(_, cut)| cut)
}

/// Calls `each` with every end in ascending order, and how many parts are below and above a plane there.
fn sweep(mins: &[u32], maxs: &[u32], mut each: impl FnMut(u32, usize, usize)) {
    let n = mins.len();
    let (mut begun, mut ended) = (0, 0);
    while let Some(&max) = maxs.get(ended) {
        let end = mins.get(begun).map_or(max, |&min| min.min(max));
        let before = begun;
        while mins.get(begun) == Some(&end) {
            begun += 1;
        }
        while maxs.get(ended) == Some(&end) {
            ended += 1;
        }
        // What is flat and in the plane belongs to the part below: it has ended and not begun before.
        each(end, before.max(ended), n - ended);
    }
}

/// A word that is ordered as the numbers are; -0 and 0 are one.
const fn key(x: f32) -> u32 {
    let bits = (x + 0.0).to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

/// The number of a word.
const fn value(key: u32) -> f32 {
    f32::from_bits(if key >> 31 == 1 { key & !(1 << 31) } else { !key })
}

//! Choosing where to split a run of primitives.
//!
//! The surface-area heuristic (Goldsmith and Salmon, "Automatic Creation of Object Hierarchies for Ray Tracing", IEEE
//! Computer Graphics and Applications 7(5), 1987): a ray that meets a box meets a box inside it with the share of their
//! areas. All `n - 1` splits along each axis are weighed by one sweep from each end over the primitives sorted by
//! centre.
use super::Ref;
use crate::geom::Aabb;
use crate::geom::vec::{size, sub};
use crate::num::weight;

/// Cost of visiting a node, in primitive tests. Measured: from 1 to 3 the host's speed hardly changes, for triangles as
/// for spheres, and the blob shrinks by a quarter to a half.
pub const NODE_COST: f32 = 3.0;
/// The same where there are cylinders or cones, which take several times as long to test: 3 made scenes of them two to
/// three times slower.
pub const NODE_COST_TUBES: f32 = 0.5;
/// A split that saves less than this share of the tests is no better than chance.
const GAIN: f32 = 0.9999;

/// What to do with a run of primitives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Leave it whole.
    Leaf,
    /// Part it before the primitive of this place; the run has been put in order for that.
    Split(usize),
}

/// The split of least expected cost of two or more primitives.
///
/// Always ends: where no split separates anything (coincident centres, identical primitives), the run is halved.
pub fn sweep(refs: &mut [Ref], bounds: &Aabb) -> Choice {
    match best_split(refs, bounds) {
        Some(best) if best.tests < weight(refs.len()) * GAIN => {
            sort(refs, best.axis);
            Choice::Split(best.at)
        }
        _ => halve(refs),
    }
}

/// Parts the run in the middle of its order along the axis on which its centres spread most.
pub fn halve(refs: &mut [Ref]) -> Choice {
    let centers = refs.iter().fold(Aabb::EMPTY, |all, r| all.with(r.center2()));
    let [x, y, z] = sub(centers.max, centers.min);
    sort(
        refs,
        if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        },
    );
    if refs.len() < 2 { Choice::Leaf } else { Choice::Split(refs.len() / 2) }
}

/// Sorts by centre along an axis, ties by number: one order, whatever the machine and the order before.
fn sort(refs: &mut [Ref], axis: usize) {
    let axis = axis.min(2);
    refs.sort_unstable_by(|a, b| a.center2()[axis].total_cmp(&b.center2()[axis]).then(a.prim.cmp(&b.prim)));
}

struct Split {
    axis: usize,
    at: usize,
    /// Expected primitive tests of a ray that meets the box.
    tests: f32,
}

fn best_split(refs: &mut [Ref], bounds: &Aabb) -> Option<Split> {
    let unit = 1.0 / size(sub(bounds.max, bounds.min));
    let whole = area(bounds, unit);
    let mut best: Option<Split> = None;
    for axis in 0..3 {
        sort(refs, axis);
        let mut after = Aabb::EMPTY;
        for r in refs.iter_mut().rev() {
            after = after.join(&r.bounds);
            r.scratch = area(&after, unit);
        }
        let (mut before, n) = (Aabb::EMPTY, refs.len());
        for at in 1..n {
            let (Some(last), Some(next)) = (refs.get(at - 1), refs.get(at)) else { break };
            before = before.join(&last.bounds);
            let tests = (area(&before, unit) * weight(at) + next.scratch * weight(n - at)) / whole;
            // Also passes over the NaN of a box without area.
            if best.as_ref().map_or(tests >= 0.0, |b| tests < b.tests) {
                best = Some(Split { axis, at, tests });
            }
        }
    }
    best
}

/// Half the surface area, with lengths in units of `1 / unit`: neither overflow nor underflow while the
/// box's sides are normal numbers.
pub fn area(bounds: &Aabb, unit: f32) -> f32 {
    let [x, y, z] = sub(bounds.max, bounds.min);
    let (x, y, z) = (x * unit, y * unit, z * unit);
    x * y + (y * z + z * x)
}

//! Whether a primitive has a part in a cell.
//!
//! Used by builders to list primitives in cells and by checks to prove that none is missing, so both decide alike. The
//! answer errs on the side of yes. For a triangle: thirteen separating axes (Akenine-Moeller, "Fast 3D Triangle-Box
//! Overlap Testing", journal of graphics tools 6(1), 2001), in f64, with the triangle grown by a share of its own
//! extent that covers the error of the distance at which it is met (rule 6 of [`super`]).
use super::aabb::Aabb;
use super::triangle::Triangle;
use crate::num::wide;

/// What a triangle is grown by, as a share of its longest side along an axis.
pub(crate) const MARGIN: f64 = 1.0 / 4096.0;
/// More than the relative error of any projection below, which is some 2^-48.
const SLACK: f64 = 1.0 + 1.0 / 1_099_511_627_776.0; // 1 + 2^-40
/// So much more than that, that a box is never ruled out which has in it one that is not.
const MORE_SLACK: f64 = 1.0 + 1.0 / 68_719_476_736.0; // 1 + 2^-36

type Wide = [f64; 3];

/// Whether two boxes, each with its surface, have a point in common.
#[inline]
#[must_use]
pub fn boxes(a: &Aabb, b: &Aabb) -> bool {
    let along = |k: usize| a.min[k] <= b.max[k] && b.min[k] <= a.max[k];
    along(0) && along(1) && along(2)
}

/// Whether the grown triangle has a point in the cell. `false` where not even their boxes have one.
#[must_use]
pub fn triangle(triangle: &Triangle, cell: &Aabb) -> bool {
    with_slack(triangle, cell, SLACK)
}

/// Whether a cell in this box may overlap the grown triangle: where this says no, [`triangle`] says no for each.
#[must_use]
pub fn triangle_nearly(triangle: &Triangle, around: &Aabb) -> bool {
    with_slack(triangle, around, MORE_SLACK)
}

fn with_slack(triangle: &Triangle, cell: &Aabb, slack: f64) -> bool {
    let own = triangle.bounds();
    if !boxes(&own, cell) {
        return false;
    }
    if cell.contains(&own) {
        return true;
    }
    let side = |k: usize| wide(own.max[k]) - wide(own.min[k]);
    let margin = greater(greater(side(0), side(1)), side(2)) * MARGIN;
    let center = axes(|k| (wide(cell.min[k]) + wide(cell.max[k])) * 0.5);
    let half = axes(|k| (wide(cell.max[k]) - wide(cell.min[k])) * 0.5 + margin);
    let corner = |i: usize| axes(|k| wide(triangle.v[i][k]) - center[k]);
    let (a, b, c) = (corner(0), corner(1), corner(2));
    let (ab, bc, ca) = (minus(b, a), minus(c, b), minus(a, c));
    let normal = cross(ab, bc);
    let apart = |axis: Wide| separates(axis, [a, b, c], half, slack);
    if apart(normal) {
        return false;
    }
    for edge in [ab, bc, ca] {
        let [x, y, z] = edge;
        if apart([0.0, z, -y]) || apart([-z, 0.0, x]) || apart([y, -x, 0.0]) {
            return false;
        }
    }
    true
}

/// Whether the corners lie beyond the box's shadow on a line.
fn separates(axis: Wide, [a, b, c]: [Wide; 3], half: Wide, slack: f64) -> bool {
    let (a, b, c) = (dot(axis, a), dot(axis, b), dot(axis, c));
    let reach = (half[0] * axis[0].abs() + half[1] * axis[1].abs() + half[2] * axis[2].abs()) * slack;
    let least = -greater(greater(-a, -b), -c);
    least > reach || greater(greater(a, b), c) < -reach
}

fn axes(f: impl Fn(usize) -> f64) -> Wide {
    [f(0), f(1), f(2)]
}

fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

fn minus(a: Wide, b: Wide) -> Wide {
    axes(|k| a[k] - b[k])
}

fn dot(a: Wide, b: Wide) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Wide, b: Wide) -> Wide {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

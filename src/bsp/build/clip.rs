//! The box of a primitive's part in a cell.
//!
//! A triangle is clipped, so that a plane is chosen by where it is in the cell and not by its whole box ("perfect
//! splits": Wald and Havran, "On building fast kd-Trees for Ray Tracing", IRT 2006, section 3.3). Only planes are
//! chosen by these boxes; what a cell lists is decided by the primitive itself.
use crate::blob::prims::Primitive;
use crate::geom::overlap::MARGIN;
use crate::geom::{Aabb, Triangle};
use crate::num::{narrow, wide};
use heapless::Vec;

/// Corners of a triangle that six planes have cut.
type Polygon = Vec<[f64; 3], 10>;

/// A box around the part of `prim`, whose box is `own`, in `cell`; with the margin by which cells list triangles.
pub fn clipped(prim: &Primitive, own: &Aabb, cell: &Aabb) -> Aabb {
    let meet = meet(own, cell);
    let Primitive::Triangle(triangle) = prim else { return meet };
    let side = |k: usize| wide(own.max[k]) - wide(own.min[k]);
    let longest = [1, 2].map(side).into_iter().fold(side(0), |a, b| if a > b { a } else { b });
    let margin = longest * MARGIN;
    let part = cut(triangle, cell, margin);
    let mut all = Aabb::EMPTY;
    for corner in &part {
        let low = corner.map(|x| below(x - margin));
        let high = corner.map(|x| -below(-x - margin));
        all = all.with(low).with(high);
    }
    let all = self::meet(&all, &meet);
    if all.is_valid() { all } else { meet }
}

fn meet(a: &Aabb, b: &Aabb) -> Aabb {
    let axes = [0, 1, 2];
    let greater = |a: f32, b: f32| if a > b { a } else { b };
    Aabb { min: axes.map(|k| greater(a.min[k], b.min[k])), max: axes.map(|k| -greater(-a.max[k], -b.max[k])) }
}

/// The greatest f32 that is not above `x`.
fn below(x: f64) -> f32 {
    let near = narrow(x);
    if wide(near) > x { near.next_down() } else { near }
}

/// The triangle's part in the cell grown by `margin` (Sutherland and Hodgman, "Reentrant Polygon Clipping", CACM 17(1),
/// 1974).
fn cut(triangle: &Triangle, cell: &Aabb, margin: f64) -> Polygon {
    let mut polygon = Polygon::from_iter(triangle.v.map(|v| v.map(wide)));
    for k in [0, 1, 2] {
        for (sign, end) in [(1.0, wide(cell.min[k]) - margin), (-1.0, wide(cell.max[k]) + margin)] {
            let inside = |p: &[f64; 3]| (p[k] - end) * sign >= 0.0;
            let mut kept = Polygon::new();
            let mut from = polygon.last().copied().unwrap_or_default();
            for &to in &polygon {
                if inside(&from) != inside(&to) {
                    let share = (end - from[k]) / (to[k] - from[k]);
                    let mut at = [0, 1, 2].map(|j| from[j] + (to[j] - from[j]) * share);
                    at[k] = end;
                    // Six planes leave at most nine corners.
                    let _ = kept.push(at);
                }
                if inside(&to) {
                    let _ = kept.push(to);
                }
                from = to;
            }
            polygon = kept;
        }
    }
    polygon
}

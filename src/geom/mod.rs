//! Plain values and the tests of a ray against one of them: no bytes, no trees.
//!
//! # The contract
//! Every structure of this crate answers as a list of these tests would, bit for bit. So the rules live here:
//!
//! 1. A hit counts if its `t` lies in `[t_min, t_max]`, both ends included, in units of `dir`, which need not be
//!    normalised. Among equal `t` the least primitive number wins.
//! 2. A ray with a NaN or infinite component in its origin or direction, a zero direction, a NaN in its interval, or
//!    an empty interval meets nothing. `-0.0` means `0.0`, and no result is ever `-0.0` or NaN.
//! 3. A primitive counts only if its own bounding box passes the slab test ([`ray::Prepared::slab`]), and `t` is
//!    clamped into that test's interval. The slab test is *monotone*: the interval of a box inside another lies
//!    inside the other's interval, because every step of it (subtract, multiply by a constant, compare) is monotone
//!    in IEEE arithmetic. So no ancestor of a hit primitive can be culled, whatever the tree.
//! 4. The slab test is *padded*, so that it does not take back what the triangle test accepts. The triangle test
//!    ([`triangle`]) decides as exact numbers would, but for `2^-50`. In f32 rounding moves a vertex, in the two sheared axes,
//!    by at most `2u |v - o|` (the difference and its rounding) plus `5u |S (v - o)_z|` (two roundings of the shear constant, the
//!    difference, the product, the sum), with `u = 2^-24` and `|S| <= 1`. That is below `7u E`, for `E` the largest
//!    distance, per axis, from the origin to the far side of the scene's bounds. The slab's own three roundings add
//!    `3u E`; rule 6 needs another `10u E`. The pad is `32u E`, plus `2u |o|` so that adding it to the origin survives
//!    rounding, plus the least normal number for scenes so small that products underflow. This holds while `v - o` and
//!    `S (v - o)` do not overflow: coordinates and origins up to 1e37 in size, directions up to 2^126, and `t` within
//!    f32. The tests go from 1e-42 to 1e30, for every kind of primitive. What is curved is measured in units of its own
//!    size: that must be 1e-38 of its distance from the origin or more, and a cylinder or cone must not be shorter than
//!    `2^-63` of its radius. Beyond that range answers are still the same everywhere, and still those of the list, but
//!    a crossing may be lost.
//! 5. Only `+ - * /` and square root reach a result, in the order written, never contracted. Minimum and maximum are
//!    compare-and-select, in an order that says what becomes of a NaN.
//!
//! 6. Space may be parted instead of primitives. Cut a box by a plane: because of the pad the plane is met as the far
//!    side of one part no earlier than as the near side of the other, so every `t` in the box's interval lies in that
//!    of a part. Hence a primitive listed in every cell that its box overlaps is met in time, whatever the cells,
//!    provided that a walk visits each cell whose interval is not empty. A triangle may be left out of a cell that it
//!    does not overlap ([`overlap`]): its `t` is that of a point on it, but for `10u E`, which the pad covers, and for
//!    what cancellation does to the weights, less than `2^-13` of the triangle's extent, which the overlap test adds
//!    to the triangle. (In f64 the weights are right to `2^-51`; in f32 the test allows products of 512 times their
//!    sum, so that the weights are wrong by `512u` at most.)
//!
//!    The two do not add up, neither in the pad nor in the margin. Let `P` be the ray's point at `t`, and `Q` that
//!    point of the triangle. (Clamping `t` moves `P` towards the place on the ray that is next to `Q`, which is in the
//!    interval by rule 4, so it brings nothing new.) On the way from `Q` to `P` is a point that is no farther along any
//!    axis from `Q` than `2^-13` of the extent and from `P` than `10u E`. Let `R` be that point clipped to the
//!    primitive's own box. `Q` is in that box, so `R` is no farther from `Q`, and the cell that `R` is in lists the
//!    triangle. The cell's interval holds `t`. On an axis on which `R` was not clipped, the cell's sides are around
//!    `R`, and the pad covers what `P` may lie beyond them. On one on which it was, `R` is on a side of the box and `P`
//!    beyond it. The cell reaches to that side or farther, and the box's interval holds `t` (rule 3): so, by monotony,
//!    does the cell's as to its side there. Its other side is on the other side of `R`, and so of `P`.
//!
//! `f32::min`, `max` and fused multiply-add are therefore absent by rule, not by accident.

pub mod aabb;
pub mod cone;
pub mod hit;
pub mod lattice;
pub mod overlap;
pub mod place;
pub mod ray;
pub(crate) mod root;
pub mod sphere;
pub mod triangle;
pub(crate) mod vec;

pub use aabb::Aabb;
pub use cone::{Cone, Cylinder};
pub use hit::Hit;
pub use ray::Ray;
pub use sphere::Sphere;
pub use triangle::Triangle;

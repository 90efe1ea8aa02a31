//! Answers.

/// Where a ray meets a primitive.
///
/// ```
/// use flashray::Hit;
/// let hit = Hit { t: 2.0, u: 0.25, v: 0.5, prim: 7 };
/// // On a triangle the point is (1 - u - v) v0 + u v1 + v v2.
/// assert_eq!(1.0 - hit.u - hit.v, 0.25);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray in units of its `dir`; finite, never `-0.0`.
    pub t: f32,
    /// Weight of the triangle's second vertex, in `[0, 1]`; 0 on other primitives.
    pub u: f32,
    /// Weight of the triangle's third vertex, in `[0, 1]`; 0 on other primitives.
    pub v: f32,
    /// The caller's own number of the primitive: for a mesh, the triangle's index in the order given.
    pub prim: u32,
}

/// A crossing of one primitive, before anyone asks which primitive it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// As [`Hit::t`].
    pub t: f32,
    /// As [`Hit::u`].
    pub u: f32,
    /// As [`Hit::v`].
    pub v: f32,
    /// Whether the ray comes from the side on which the triangle's corners run counter-clockwise: the outside of a
    /// closed mesh. Decided where the crossing itself is, so on a closed mesh entries and exits always balance. `true`
    /// on other primitives.
    pub enters: bool,
}

//! The input of every builder.
use super::BuildError;
use crate::blob::MAX_PRIMS;
use crate::blob::prims::Primitive;
use crate::geom::vec::{Vec3, sub};
use crate::geom::{Aabb, Cone, Cylinder, Sphere, Triangle};
use crate::num::{count, index, wide};

/// A scene to build from, borrowed: triangles by index, and analytic primitives.
///
/// Primitives are numbered through: triangles first, then spheres, boxes, cylinders and cones.
///
/// A triangle without area keeps its number and is never hit: it is stored as three times its first corner. (Left as it
/// is, one with three distinct corners on a line could be hit, because in a ray's frame rounding makes a sliver of it.
/// A closed mesh with such faces has the crack there that it would have without them.)
///
/// ```
/// use flashray::Sphere;
/// use flashray::build::Mesh;
/// let ball = [Sphere { center: [0.0; 3], radius: 1.0 }];
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]).spheres(&ball);
/// assert_eq!(mesh.len(), Ok(2)); // the sphere is primitive 1
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Mesh<'a> {
    positions: &'a [[f32; 3]],
    triangles: &'a [[u32; 3]],
    spheres: &'a [Sphere],
    boxes: &'a [Aabb],
    cylinders: &'a [Cylinder],
    cones: &'a [Cone],
}

impl<'a> Mesh<'a> {
    /// Triangles: each names three of the positions.
    #[must_use]
    pub const fn new(positions: &'a [[f32; 3]], triangles: &'a [[u32; 3]]) -> Self {
        Self { positions, triangles, spheres: &[], boxes: &[], cylinders: &[], cones: &[] }
    }

    /// With spheres.
    #[must_use]
    pub const fn spheres(mut self, spheres: &'a [Sphere]) -> Self {
        self.spheres = spheres;
        self
    }

    /// With axis-aligned boxes.
    #[must_use]
    pub const fn boxes(mut self, boxes: &'a [Aabb]) -> Self {
        self.boxes = boxes;
        self
    }

    /// With cylinders.
    #[must_use]
    pub const fn cylinders(mut self, cylinders: &'a [Cylinder]) -> Self {
        self.cylinders = cylinders;
        self
    }

    /// With truncated cones.
    #[must_use]
    pub const fn cones(mut self, cones: &'a [Cone]) -> Self {
        self.cones = cones;
        self
    }

    /// Number of primitives.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] if there are 2^28 or more.
    pub fn len(&self) -> Result<u32, BuildError> {
        let n = self.counts().iter().try_fold(0usize, |sum, &n| sum.checked_add(n));
        n.filter(|&n| n <= index(MAX_PRIMS)).map(count).ok_or(BuildError::TooLarge)
    }

    /// Whether there is no primitive.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.counts() == [0; 5]
    }

    /// Numbers of triangles, spheres, boxes, cylinders and cones.
    pub(super) const fn counts(&self) -> [usize; 5] {
        [self.triangles.len(), self.spheres.len(), self.boxes.len(), self.cylinders.len(), self.cones.len()]
    }

    /// Whether there are primitives that take much longer to test than a triangle.
    pub(super) const fn has_tubes(&self) -> bool {
        !(self.cylinders.is_empty() && self.cones.is_empty())
    }

    /// Primitive `number` relative to `local`, and the number of its kind; not checked.
    ///
    /// # Errors
    /// [`BuildError::Index`] if a triangle names a vertex that does not exist.
    pub(super) fn get(&self, number: u32, local: Vec3) -> Result<(u32, Primitive), BuildError> {
        let missing = BuildError::Primitive { prim: number };
        let [triangles, spheres, boxes, cylinders, _] = self.counts();
        let at = index(number);
        if at < triangles {
            return Ok((0, Primitive::Triangle(self.triangle(number, local)?)));
        }
        let at = at - triangles;
        if let Some(p) = self.spheres.get(at) {
            return Ok((1, Primitive::Sphere(Sphere { center: sub(p.center, local), ..*p })));
        }
        let at = at.checked_sub(spheres).ok_or(missing)?;
        if let Some(p) = self.boxes.get(at) {
            return Ok((2, Primitive::Box(Aabb { min: sub(p.min, local), max: sub(p.max, local) })));
        }
        let at = at.checked_sub(boxes).ok_or(missing)?;
        if let Some(p) = self.cylinders.get(at) {
            let (base, top) = (sub(p.base, local), sub(p.top, local));
            return Ok((3, Primitive::Cylinder(Cylinder { base, top, ..*p })));
        }
        let at = at.checked_sub(cylinders).ok_or(missing)?;
        let p = self.cones.get(at).ok_or(missing)?;
        let (base, top) = (sub(p.base, local), sub(p.top, local));
        Ok((4, Primitive::Cone(Cone { base, top, ..*p })))
    }

    /// A triangle relative to `local`: three times its first corner, if it has no area.
    #[inline]
    pub(super) fn triangle(&self, number: u32, local: Vec3) -> Result<Triangle, BuildError> {
        let v = self.corners(number, local)?;
        Ok(Triangle { v: if has_area(v) { v } else { [v[0]; 3] } })
    }

    /// The corners of a triangle relative to `local`, whether it has an area or not.
    #[inline]
    pub(super) fn corners(&self, number: u32, local: Vec3) -> Result<[Vec3; 3], BuildError> {
        let vertex = |vertex: u32| {
            let error = BuildError::Index { triangle: number, vertex, vertices: self.positions.len() };
            self.positions.get(index(vertex)).map(|&p| sub(p, local)).ok_or(error)
        };
        let &[a, b, c] = self.triangles.get(index(number)).ok_or(BuildError::Primitive { prim: number })?;
        Ok([vertex(a)?, vertex(b)?, vertex(c)?])
    }
}

/// 2^-40: far more than what rounding in f64 can do.
const CLEAR: f64 = 1.0 / 1_099_511_627_776.0;

/// Whether the corners are not on one line, exactly. True for NaN, which is not this function's to judge.
fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    // Most are told by their normal. In f64 its two products, of differences, are wrong by 2^-51 at most; so it is not 0
    // where they differ by more. A NaN is left to the rest.
    let (p, q) = ([0, 1, 2].map(|k| wide(b[k]) - wide(a[k])), [0, 1, 2].map(|k| wide(c[k]) - wide(a[k])));
    let clear = |i: usize, j: usize| {
        let (left, right) = (p[i] * q[j], p[j] * q[i]);
        (left - right).abs() > (left.abs() + right.abs()) * CLEAR
    };
    if clear(0, 1) || clear(1, 2) || clear(2, 0) {
        return true;
    }
    // Products of two f32 are exact in f64.
    let product = |p: Vec3, i: usize, q: Vec3, j: usize| wide(p[i]) * wide(q[j]);
    let cross = |i: usize, j: usize| {
        [
            product(b, i, c, j),
            -product(b, j, c, i),
            product(c, i, a, j),
            -product(c, j, a, i),
            product(a, i, b, j),
            -product(a, j, b, i),
        ]
    };
    !(sum_is_zero(cross(0, 1)) && sum_is_zero(cross(1, 2)) && sum_is_zero(cross(2, 0)))
}

/// Whether the numbers add up to 0, without rounding: the sum is kept as parts that do not overlap (Shewchuk, "Adaptive
/// Precision Floating-Point Arithmetic", Discrete and Computational Geometry 18, 1997, grow-expansion).
fn sum_is_zero(terms: [f64; 6]) -> bool {
    let mut parts = [0.0f64; 6];
    for (n, mut rest) in terms.into_iter().enumerate() {
        for part in parts.iter_mut().take(n) {
            let sum = rest + *part;
            let took = sum - rest;
            *part = (rest - (sum - took)) + (*part - took);
            rest = sum;
        }
        if let Some(last) = parts.get_mut(n) {
            *last = rest;
        }
    }
    parts.iter().all(|&part| part == 0.0)
}

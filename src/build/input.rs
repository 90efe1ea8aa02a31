//! A mesh that was found good, as builders see it.
use super::{BuildError, Config, Mesh};
use crate::blob::prims::Primitive;
use crate::geom::place::longest_side;
use crate::geom::vec::{Vec3, finite, most};
use crate::geom::{Aabb, Triangle};
use crate::grid::Shape;
use crate::num::count;

/// Primitives reach no farther than this from the local origin, along each axis. So the extent of a scene is a number,
/// and so are all planes of a structure that parts it.
const REACH: f32 = 85_070_591_730_234_615_865_843_651_857_942_052_864.0; // 2^126

/// What no number of a primitive means.
const NONE: Triangle = Triangle { v: [[0.0; 3]; 3] };

/// A checked mesh relative to its local origin.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    mesh: &'a Mesh<'a>,
    local: Vec3,
    /// Whether some triangle has no area: else none need be asked again.
    flat: bool,
    /// Number of primitives.
    pub len: u32,
    /// Box around all of them; a point at 0 if there is none.
    pub bounds: Aabb,
    /// Longest side of the boxes of triangles.
    pub longest: f32,
}

impl<'a> Input<'a> {
    /// Checks every primitive.
    ///
    /// # Errors
    /// The first thing that is wrong with the configuration or the mesh.
    pub(super) fn new(mesh: &'a Mesh<'a>, config: &Config) -> Result<Self, BuildError> {
        config.check()?;
        let len = mesh.len()?;
        let triangles = count(mesh.counts()[0]);
        let (mut all, mut flat, mut longest) = (Aabb::EMPTY, false, 0.0);
        let room = Aabb { min: [-REACH; 3], max: [REACH; 3] };
        for prim in 0..triangles {
            let triangle = mesh.triangle(prim, config.local)?;
            let ([a, b, c], bounds) = (triangle.v, triangle.bounds());
            if !(finite(a) && finite(b) && finite(c) && room.contains(&bounds)) {
                return Err(BuildError::Primitive { prim });
            }
            flat |= a == b && a == c;
            longest = most(longest_side(&bounds), longest);
            all = all.join(&bounds);
        }
        for prim in triangles..len {
            let (_, primitive) = mesh.get(prim, config.local)?;
            let bounds = primitive.bounds();
            // The box of a huge primitive may overflow although its own numbers do not.
            if !primitive.is_valid() || !bounds.is_valid() || !room.contains(&bounds) {
                return Err(BuildError::Primitive { prim });
            }
            all = all.join(&bounds);
        }
        let bounds = if len == 0 { Aabb { min: [0.0; 3], max: [0.0; 3] } } else { all };
        Ok(Self { mesh, local: config.local, flat, len, bounds, longest })
    }

    /// What the test of a primitive is reckoned to cost, in triangle tests: the unit of what cells are chosen by.
    ///
    /// Measured on a host: a triangle takes 5 ns, a sphere 8, a cylinder 30. Where there are such, six served scenes of
    /// all kinds best.
    #[must_use]
    pub fn test_cost(&self) -> f32 {
        let [_, others @ ..] = self.mesh.counts();
        if others == [0; 4] { 1.0 } else { 6.0 }
    }

    /// Primitive `number`, relative to the local origin.
    #[must_use]
    pub fn prim(&self, number: u32) -> Primitive {
        self.get(number).1
    }

    /// The number of its kind, too.
    pub(super) fn get(&self, number: u32) -> (u32, Primitive) {
        // Every number below `len` was looked up before.
        let other = || self.mesh.get(number, self.local).unwrap_or((0, Primitive::Triangle(NONE)));
        self.triangle(number).map_or_else(other, |triangle| (0, Primitive::Triangle(triangle)))
    }

    /// Triangle `number`.
    #[inline]
    pub(super) fn triangle(&self, number: u32) -> Option<Triangle> {
        if self.flat {
            return self.mesh.triangle(number, self.local).ok();
        }
        self.mesh.corners(number, self.local).ok().map(|v| Triangle { v })
    }

    /// How many cells of a grid each primitive has a part in, summed up; `None` from `limit` on, without counting
    /// further.
    pub fn count_listings(&self, shape: &Shape, limit: u32) -> Option<u32> {
        let mut listed = 0;
        for number in 0..self.len {
            let prim = self.prim(number);
            shape
                .touched(&prim, &prim.bounds(), |_, _, bounds| {
                    listed += u32::from(prim.overlaps(bounds));
                    if listed < limit { Ok(()) } else { Err(()) }
                })
                .ok()?;
        }
        Some(listed)
    }

    /// Calls `each` with every cell of a grid and every primitive that has a part in it, primitive by primitive.
    pub fn listings(&self, shape: &Shape, mut each: impl FnMut(u32, u32)) {
        for number in 0..self.len {
            let prim = self.prim(number);
            let listed = shape.touched(&prim, &prim.bounds(), |_, cell, bounds| {
                if prim.overlaps(bounds) {
                    each(cell, number);
                }
                Ok::<(), core::convert::Infallible>(())
            });
            match listed {
                Ok(()) => {}
            }
        }
    }
}

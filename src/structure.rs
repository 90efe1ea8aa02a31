//! The structure of a blob, whichever it is.
use crate::blob::prims::Prims;
use crate::blob::{Blob, BlobError, Kind};
use crate::bvh::group::Boxes;
use crate::geom::Aabb;
use crate::walk::group::{Group, Rays};
use crate::walk::{Isa, Part, Stop, Tally};
use crate::{bsp, bvh, grid, nested, octree, sphere, voxel, wide};

/// The structure of a blob, by kind.
#[derive(Clone, Copy, Debug)]
pub enum Structure<'a> {
    List,
    Bvh(bvh::View<'a>),
    Grid(grid::View<'a>),
    Voxel(voxel::View<'a>),
    Nested(nested::View<'a>),
    Octree(octree::View<'a>),
    Bsp(bsp::View<'a>),
    Sphere(sphere::View<'a>),
    Wide(wide::View<'a>),
    Wide4(wide::View<'a, 4>),
}

impl<'a> Structure<'a> {
    /// What the sections of a blob of this kind hold, and the most steps of a walk. O(1).
    ///
    /// # Errors
    /// A rule that the sections break.
    pub fn parse(kind: Kind, blob: &Blob<'a>, prims: &Prims<'a>) -> Result<(Self, u32), BlobError> {
        Ok(match kind {
            Kind::List => (Self::List, prims.len),
            Kind::Bvh => {
                let view = bvh::View::parse(blob)?;
                (Self::Bvh(view), view.steps(prims))
            }
            Kind::Grid => {
                let view = grid::View::parse(blob)?;
                (Self::Grid(view), view.steps())
            }
            Kind::Voxel => {
                let view = voxel::View::parse(blob)?;
                (Self::Voxel(view), view.steps())
            }
            Kind::Nested => {
                let view = nested::View::parse(blob)?;
                (Self::Nested(view), view.steps())
            }
            Kind::Octree => {
                let view = octree::View::parse(blob)?;
                (Self::Octree(view), view.steps())
            }
            Kind::Bsp => {
                let view = bsp::View::parse(blob)?;
                (Self::Bsp(view), view.steps())
            }
            Kind::Sphere => {
                let view = sphere::View::parse(blob)?;
                (Self::Sphere(view), view.steps(prims))
            }
            Kind::Wide if wide::has_four(blob) => {
                let view = wide::View::parse(blob)?;
                (Self::Wide4(view), view.steps(prims))
            }
            Kind::Wide => {
                let view = wide::View::parse(blob)?;
                (Self::Wide(view), view.steps(prims))
            }
        })
    }

    /// Checks all of it: O(n). Returns the deepest stack of a walk.
    ///
    /// # Errors
    /// A rule that the bytes break.
    pub fn check(&self, prims: &Prims<'_>, bounds: &Aabb) -> Result<u32, BlobError> {
        match self {
            Self::List => Ok(0),
            Self::Bvh(view) => view.check(prims, bounds),
            Self::Grid(view) => view.check(prims),
            Self::Voxel(view) => view.check(prims),
            Self::Nested(view) => view.check(prims),
            Self::Octree(view) => view.check(prims),
            Self::Bsp(view) => view.check(prims),
            Self::Sphere(view) => view.check(prims, bounds),
            Self::Wide(view) => view.check(prims, bounds),
            Self::Wide4(view) => view.check(prims, bounds),
        }
    }

    /// Calls `each` with every node and cell.
    pub fn parts(&self, prims: &Prims<'_>, bounds: &Aabb, each: &mut impl FnMut(Part)) {
        match self {
            Self::List => each(Part { bounds: *bounds, level: 0, listed: Some(prims.len) }),
            Self::Bvh(view) => view.parts(prims, bounds, each),
            Self::Grid(view) => view.parts(each),
            Self::Voxel(view) => view.parts(each),
            Self::Nested(view) => view.parts(each),
            Self::Octree(view) => view.parts(each),
            Self::Bsp(view) => view.parts(each),
            Self::Sphere(view) => view.parts(prims, bounds, each),
            Self::Wide(view) => view.parts(prims, bounds, each),
            Self::Wide4(view) => view.parts(prims, bounds, each),
        }
    }

    /// A group of rays, walked together if that is worth it. Returns whether they were.
    ///
    /// # Errors
    /// [`Stop`] if the meter runs out or the bytes contradict themselves. Then there are no answers.
    pub fn group<const ANY: bool, const LISTS: bool>(
        &self,
        rays: Rays<'_, 'a>,
        isa: Isa,
        meter: &mut Tally,
    ) -> Result<bool, Stop> {
        if rays.prims.len == 0 || !rays.are_near() {
            return Ok(false);
        }
        let (prims, bounds) = (rays.prims, rays.place.bounds);
        match self {
            Self::Bvh(view) => {
                isa.run(Group::<_, ANY, LISTS> { tree: Boxes { nodes: view.nodes, prims, bounds }, rays, meter })?;
            }
            Self::Octree(view) => {
                isa.run(Group::<_, ANY, LISTS> { tree: octree::group::Cells { view, prims }, rays, meter })?;
            }
            Self::Bsp(view) => {
                isa.run(Group::<_, ANY, LISTS> { tree: bsp::group::Cells { view, prims }, rays, meter })?;
            }
            Self::Sphere(view) => {
                isa.run(Group::<_, ANY, LISTS> { tree: Boxes { nodes: view.nodes, prims, bounds }, rays, meter })?;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }
}

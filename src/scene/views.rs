//! The structure of a scene, for those who look into it.
use super::Scene;
use crate::structure::Structure;
use crate::{bsp, bvh, grid, nested, octree, voxel};

impl<'a> Scene<'a> {
    /// The hierarchy, if this is one.
    #[must_use]
    pub const fn bvh(&self) -> Option<bvh::View<'a>> {
        if let Structure::Bvh(view) = self.structure { Some(view) } else { None }
    }

    /// The grid, if this is one.
    #[must_use]
    pub const fn grid(&self) -> Option<grid::View<'a>> {
        if let Structure::Grid(view) = self.structure { Some(view) } else { None }
    }

    /// The sparse voxels, if this is them.
    #[must_use]
    pub const fn voxel(&self) -> Option<voxel::View<'a>> {
        if let Structure::Voxel(view) = self.structure { Some(view) } else { None }
    }

    /// The hierarchy of grids, if this is one.
    #[must_use]
    pub const fn nested(&self) -> Option<nested::View<'a>> {
        if let Structure::Nested(view) = self.structure { Some(view) } else { None }
    }

    /// The octree, if this is one.
    #[must_use]
    pub const fn octree(&self) -> Option<octree::View<'a>> {
        if let Structure::Octree(view) = self.structure { Some(view) } else { None }
    }

    /// The binary space partition, if this is one.
    #[must_use]
    pub const fn bsp(&self) -> Option<bsp::View<'a>> {
        if let Structure::Bsp(view) = self.structure { Some(view) } else { None }
    }

    /// The longest side of the boxes of triangles, as the blob tells it; 0 if it does not. It belongs to the answer: where the
    /// triangle test can do without f64 is decided with it.
    #[must_use]
    pub const fn longest_side(&self) -> f32 {
        self.place.longest
    }
}

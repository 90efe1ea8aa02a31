//! The rays of a group as they are given, and whether they are worth one.
use crate::blob::prims::Prims;
use crate::geom::place::Place;
use crate::geom::vec::{least3, most3, size, sub};
use crate::geom::{Aabb, Hit, Ray};

/// Fewer rays are no group.
const LEAST: usize = 8;
/// Rays are near to each other if so many times the box of their origins is no longer than the scene.
const NEAR: f32 = 2.0;

/// Up to 64 rays of a query.
#[allow(clippy::struct_field_names)] // the rays themselves, and what belongs to them
pub struct Rays<'q, 'a> {
    /// What they may meet.
    pub prims: &'q Prims<'a>,
    /// The rays.
    pub rays: &'q [Ray],
    /// As many places for answers.
    pub hits: &'q mut [Option<Hit>],
    /// Where the scene is.
    pub place: &'q Place<'q>,
}

impl Rays<'_, '_> {
    /// Whether they are worth a group: their origins are near to each other, as the scene goes.
    pub fn are_near(&self) -> bool {
        let all = origins(self.rays);
        let (origins, scene) = (sub(all.max, all.min), sub(self.place.bounds.max, self.place.bounds.min));
        let most = size(scene);
        self.rays.len() >= LEAST && size(origins) * NEAR <= most
    }

    /// Whether the signs of all directions are alike.
    pub fn are_alike(&self) -> bool {
        let signs = |ray: &Ray| ray.dir.map(|d| d < 0.0);
        let first = self.rays.first().map(signs);
        self.rays.iter().all(|ray| Some(signs(ray)) == first)
    }
}

/// The box of where rays start.
#[inline(always)]
pub(super) fn origins(rays: &[Ray]) -> Aabb {
    // What is NaN counts for nothing.
    rays.iter().fold(Aabb::EMPTY, |all, ray| Aabb { min: least3(ray.origin, all.min), max: most3(ray.origin, all.max) })
}

//! What a group of rays asks of a tree.
use crate::geom::Aabb;
use crate::geom::ray::Prepared;
use crate::walk::{Best, Meter, Stop};

/// The slots of a leaf.
#[derive(Clone, Copy)]
pub enum Slots<'a> {
    /// So many from the first.
    Run(u32, u32),
    /// These.
    List(&'a [u32]),
}

/// A tree whose nodes have boxes.
pub trait Tree<'a> {
    /// A node or leaf.
    type Place: Copy;

    /// The root and its box.
    fn root(&self) -> (Self::Place, Aabb);

    /// Fetches what is at a place. The slots of a leaf; for a node, calls `child` with its children, those last that rays of
    /// this heading meet first.
    ///
    /// # Errors
    /// What `child` says, and [`Stop::Corrupt`] if there is nothing.
    fn open(
        &self,
        at: Self::Place,
        bounds: &Aabb,
        heading: &Heading,
        child: impl FnMut(Self::Place, Aabb) -> Result<(), Stop>,
    ) -> Result<Option<Slots<'a>>, Stop>;

    /// Whether a place is a node to be fetched. Where not, it is a leaf of at least one slot.
    #[inline(always)]
    fn costs(&self, _: Self::Place) -> bool {
        true
    }

    /// One ray from a place on. Returns whether the walk ended at a hit.
    ///
    /// # Errors
    /// [`Stop`] if the meter runs out or the bytes contradict themselves.
    fn alone<const ANY: bool>(
        &self,
        at: Self::Place,
        bounds: &Aabb,
        ray: &Prepared,
        best: &mut Best,
        meter: &mut impl Meter,
    ) -> Result<bool, Stop>;
}

/// Where a group goes, about.
#[derive(Clone, Copy, Debug, Default)]
pub struct Heading(pub(super) [f32; 3]);

impl Heading {
    /// Whether it goes down along an axis.
    #[inline(always)]
    #[must_use]
    pub fn is_negative(&self, k: usize) -> bool {
        self.0.get(k).is_some_and(|&d| d < 0.0)
    }

    /// Whether it comes to the second box first.
    #[inline(always)]
    #[must_use]
    pub fn swaps(&self, a: &Aabb, b: &Aabb) -> bool {
        let along = |k: usize| ((b.min[k] + b.max[k]) - (a.min[k] + a.max[k])) * self.0[k];
        along(0) + along(1) + along(2) < 0.0
    }
}

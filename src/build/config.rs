//! What to build.
use super::BuildError;
use crate::blob::Kind;
use crate::bvh::MAX_LEAF;
use crate::geom::vec::finite;

/// Most cells along the longest side of a grid.
pub const MOST_CELLS: u32 = 1024;

/// How a structure chooses its splits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Rule {
    /// The textbook's: axes in turn, the box halved, objects to the side of their centre.
    Seed,
    /// The least expected cost: the surface-area heuristic for trees, the best of several densities for grids.
    Sah,
}

/// How much time [`Rule::Sah`] may take for a hierarchy of boxes or spheres. The answers are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quality {
    /// Builds fastest.
    Fast,
    /// Rays go faster than by [`Quality::Fast`].
    Default,
    /// Takes the time it needs: every split weighed, and subtrees moved until no move helps.
    High,
}

/// What to build, and how.
///
/// ```
/// use flashray::Kind;
/// use flashray::build::{Config, Quality, Rule};
/// let config = Config::new(Kind::Bvh).quality(Quality::High).leaf(4);
/// assert_eq!((config.rule, config.leaf), (Rule::Sah, 4));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Config {
    /// The structure.
    pub kind: Kind,
    /// How it splits.
    pub rule: Rule,
    /// Most primitives of a leaf, from 1 to 15: of bvh and sphere. By [`Rule::Seed`] octree and bsp cut what has more
    /// where that helps; by [`Rule::Sah`] octree looks one cut farther ahead there, and bsp goes by cost alone. The
    /// others have no such limit.
    pub leaf: u32,
    /// How much time [`Rule::Sah`] may take for bvh, sphere and wide.
    pub quality: Quality,
    /// Most children of a node of wide: 8 or 4; 0 is 8. No other structure has a width ([`BuildError::Width`]).
    pub width: u32,
    /// Cells along the longest side of a grid, of voxels or of the outermost of nested grids, at most 1024; 0 leaves it
    /// to the rule. Where the scene is a cube a grid has too many from 646 on ([`BuildError::TooLarge`]).
    pub cells: u32,
    /// Most primitives of a cell of nested grids that gets no grid of its own; 0 leaves it to the rule: 2 for
    /// [`Rule::Seed`], 4 for [`Rule::Sah`].
    pub threshold: u32,
    /// Subtracted from every coordinate before it is stored, and from every ray's origin: for scenes far from 0.
    pub local: [f32; 3],
}

impl Config {
    /// The defaults: the surface-area heuristic, a leaf limit of 8 primitives, no local origin.
    #[must_use]
    pub const fn new(kind: Kind) -> Self {
        let (rule, quality, local) = (Rule::Sah, Quality::Default, [0.0; 3]);
        Self { kind, rule, leaf: 8, quality, width: 0, cells: 0, threshold: 0, local }
    }

    /// With another rule.
    #[must_use]
    pub const fn rule(mut self, rule: Rule) -> Self {
        self.rule = rule;
        self
    }

    /// With leaves of up to so many primitives, from 1 to 15, where the structure has such a limit.
    #[must_use]
    pub const fn leaf(mut self, leaf: u32) -> Self {
        self.leaf = leaf;
        self
    }

    /// With another quality.
    #[must_use]
    pub const fn quality(mut self, quality: Quality) -> Self {
        self.quality = quality;
        self
    }

    /// With nodes of up to so many children, 8 or 4: for [`Kind::Wide`] alone.
    ///
    /// ```
    /// # #[cfg(feature = "alloc")] {
    /// use flashray::build::{BuildError, Config, Mesh, to_vec};
    /// use flashray::{Kind, Scene};
    ///
    /// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]; 20]);
    /// let blob = to_vec(&mesh, &Config::new(Kind::Wide).width(4))?;
    /// assert_eq!(Scene::from_bytes(&blob).unwrap().width(), Some(4));
    /// assert_eq!(to_vec(&mesh, &Config::new(Kind::Bvh).width(4)), Err(BuildError::Width { found: 4 }));
    /// # }
    /// # Ok::<(), flashray::build::BuildError>(())
    /// ```
    #[must_use]
    pub const fn width(mut self, width: u32) -> Self {
        self.width = width;
        self
    }

    /// With so many cells along the longest side.
    #[must_use]
    pub const fn cells(mut self, cells: u32) -> Self {
        self.cells = cells;
        self
    }

    /// With grids only in cells of more than so many primitives.
    #[must_use]
    pub const fn threshold(mut self, threshold: u32) -> Self {
        self.threshold = threshold;
        self
    }

    /// With a local origin.
    #[must_use]
    pub fn local(mut self, local: impl Into<[f32; 3]>) -> Self {
        self.local = local.into();
        self
    }

    /// Whether the structure comes in the width.
    const fn fits(&self) -> bool {
        matches!((self.kind, self.width), (_, 0) | (Kind::Wide, 4 | 8))
    }

    /// Children of a wide node, as asked for.
    pub(crate) const fn children(&self) -> usize {
        if self.width == 4 { 4 } else { 8 }
    }

    pub(super) fn check(&self) -> Result<(), BuildError> {
        match () {
            () if self.leaf == 0 || self.leaf > MAX_LEAF => Err(BuildError::Leaf { found: self.leaf }),
            () if !self.fits() => Err(BuildError::Width { found: self.width }),
            () if self.cells > MOST_CELLS => Err(BuildError::Cells { found: self.cells }),
            () if !finite(self.local) => Err(BuildError::Local),
            () => Ok(()),
        }
    }
}

//! Builders: from a mesh to a blob.
//!
//! [`into`] works in memory that the caller lends and never allocates; [`to_vec`] (feature `alloc`) sizes itself. Both
//! run the same code and write the same bytes, on every machine.

mod config;
mod error;
mod input;
mod mesh;
pub(crate) mod parts;
mod refs;
mod write;

#[cfg(feature = "alloc")]
mod owned;
pub(crate) mod sah;

pub use config::{Config, MOST_CELLS, Quality, Rule};
pub use error::{BuildError, What};
pub use input::Input;
pub use mesh::Mesh;
#[cfg(feature = "alloc")]
pub use owned::{to_buffer, to_vec};
pub use refs::Ref;
pub use sah::{NODE_COST, NODE_COST_TUBES};

use crate::blob::Kind;
use crate::blob::write::{Facts, Layout};
use crate::bsp;
use crate::bvh::{self, Node};
use crate::grid;
use crate::nested;
use crate::num::index;
use crate::octree;
use crate::voxel;
use crate::wide;
use heapless::VecView;
use parts::Parts;

/// Memory that a builder works in, lent by the caller. [`Needs`] says how much it takes.
///
/// ```
/// use flashray::build::{Arena, Config, Mesh, Needs, into};
/// use flashray::{Kind, Ray, Scene};
///
/// #[repr(align(64))]
/// struct Out([u8; 1024]);
/// let (mut refs, mut nodes) = (heapless::Vec::<_, 8>::new(), heapless::Vec::<_, 8>::new());
/// let (mut cells, mut slots) = (heapless::Vec::<_, 8>::new(), heapless::Vec::<_, 8>::new());
/// let mut arena = Arena { refs: &mut refs, nodes: &mut nodes, cells: &mut cells, slots: &mut slots };
/// let mut out = Out([0; 1024]);
///
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
/// let blob = into(&mesh, &Config::new(Kind::Bvh), &mut arena, &mut out.0)?;
/// assert!(Scene::from_bytes(blob).unwrap().any_hit(&Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0])));
/// # Ok::<(), flashray::build::BuildError>(())
/// ```
#[derive(Debug)]
pub struct Arena<'a> {
    /// One per primitive; 2.5 for a binary space partition.
    pub refs: &'a mut VecView<Ref>,
    /// One per inner node of a hierarchy of boxes or spheres.
    pub nodes: &'a mut VecView<Node>,
    /// Words of the tables of a structure that parts space, or of a wide hierarchy's plan.
    pub cells: &'a mut VecView<u32>,
    /// Words for what such a structure lists. A grid and voxels need one each time that they list a primitive; the
    /// others get a fixed budget and keep within it: nested grids as many as the outermost lists and 16 a primitive, an
    /// octree 17 a primitive and 64, a binary space partition 8 a primitive and 64.
    pub slots: &'a mut VecView<u32>,
}

/// How much memory a build can take at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Needs {
    /// Entries of [`Arena::refs`].
    pub refs: usize,
    /// Entries of [`Arena::nodes`].
    pub nodes: usize,
    /// Entries of [`Arena::cells`].
    pub cells: usize,
    /// Entries of [`Arena::slots`].
    pub slots: usize,
    /// Bytes of the blob; `usize::MAX` if the most nodes would make it 4 GiB or longer.
    pub bytes: usize,
}

impl Needs {
    /// What a mesh and a configuration can need at most. For a structure that parts space this counts, which takes
    /// about as long as building.
    ///
    /// # Errors
    /// Those of the build, but [`BuildError::Full`].
    pub fn new(mesh: &Mesh<'_>, config: &Config) -> Result<Self, BuildError> {
        let input = Input::new(mesh, config)?;
        Ok(Self::of(mesh, &input, config, &Shape::new(&input, config)?))
    }

    fn of(mesh: &Mesh<'_>, input: &Input<'_>, config: &Config, shape: &Shape) -> Self {
        let refs = if let Shape::Bsp(budget) = shape { budget.refs } else { index(input.len) };
        let (nodes, cells, slots) = match shape {
            Shape::List => (0, 0, 0),
            Shape::Tree => (index(bvh::build::most_nodes(input.len)), 0, 0),
            Shape::Wide => {
                let nodes = index(bvh::build::most_nodes(input.len));
                (nodes, nodes.saturating_mul(wide::build::WORDS), 0)
            }
            Shape::Grid(plan) => (0, plan.words(), index(plan.listed)),
            Shape::Voxel(plan) => (0, plan.words(), plan.slots()),
            Shape::Nested(plan) => (0, plan.words(), plan.listed()),
            Shape::Octree(plan) => (0, plan.words(), plan.slots()),
            Shape::Bsp(budget) => (0, budget.words(), index(budget.slots)),
        };
        let scratch = if let Shape::Voxel(plan) = shape { plan.scratch() } else { 0 };
        let bytes = match shape {
            Shape::Wide => write::most_wide_bytes(mesh, nodes, wide::build::section(config.children()).1),
            _ => write::most_bytes(mesh, config.kind, nodes, cells + slots - scratch),
        };
        Self { refs, nodes, cells, slots, bytes }
    }
}

/// Builds a blob in `out`, working in `arena`: no heap. Returns the part of `out` that it takes.
///
/// `out` should start at a multiple of 4 in memory, better 64, if the blob is to be loaded where it is.
///
/// # Errors
/// [`BuildError::Full`] if the arena or `out` is too small, with what would be enough; the other variants if the mesh
/// is not one. `out` is not touched then.
pub fn into<'o>(
    mesh: &Mesh<'_>,
    config: &Config,
    arena: &mut Arena<'_>,
    out: &'o mut [u8],
) -> Result<&'o [u8], BuildError> {
    let input = Input::new(mesh, config)?;
    let shape = Shape::new(&input, config)?;
    let needs = Needs::of(mesh, &input, config, &shape);
    let lent = Lent {
        refs: lend(arena.refs, needs.refs, What::Refs)?,
        // The most nodes are rarely needed: lend what there is, and let the builder say if it was not enough.
        nodes: lend(arena.nodes, arena.nodes.capacity().min(needs.nodes), What::Nodes)?,
        cells: lend(arena.cells, needs.cells, What::Cells)?,
        slots: lend(arena.slots, needs.slots, What::Slots)?,
    };
    let plan = Plan::new(&input, mesh, config, &shape, lent)?;
    let had = out.len();
    plan.write(out).ok_or(BuildError::Full { what: What::Out, needed: plan.layout.len(), had })
}

/// The first `n` entries of a caller's vector.
fn lend<T: bytemuck::Zeroable + Clone>(view: &mut VecView<T>, n: usize, what: What) -> Result<&mut [T], BuildError> {
    let full = BuildError::Full { what, needed: n, had: view.capacity() };
    view.resize(n, T::zeroed()).map_err(|_| full)?;
    view.get_mut(..n).ok_or(full)
}

/// What is decided about a structure before there is memory for it.
enum Shape {
    List,
    Tree,
    Wide,
    Grid(grid::build::Plan),
    Voxel(voxel::build::Plan),
    Nested(nested::build::Plan),
    Octree(octree::build::Plan),
    Bsp(bsp::build::Budget),
}

impl Shape {
    fn new(input: &Input<'_>, config: &Config) -> Result<Self, BuildError> {
        Ok(match config.kind {
            Kind::List => Self::List,
            Kind::Bvh | Kind::Sphere => Self::Tree,
            Kind::Wide => Self::Wide,
            Kind::Grid => Self::Grid(grid::build::Plan::new(input, config)?),
            Kind::Voxel => Self::Voxel(voxel::build::Plan::new(input, config)?),
            Kind::Nested => Self::Nested(nested::build::Plan::new(input, config)?),
            Kind::Octree => Self::Octree(octree::build::Plan::new(input)),
            Kind::Bsp => Self::Bsp(bsp::build::Budget::of(input.len)),
        })
    }
}

/// Memory for a build, as much as [`Needs`] says; of the nodes perhaps less.
struct Lent<'p> {
    refs: &'p mut [Ref],
    nodes: &'p mut [Node],
    cells: &'p mut [u32],
    slots: &'p mut [u32],
}

/// A finished structure that has not been written yet: its exact length is known.
struct Plan<'p> {
    input: &'p Input<'p>,
    built: Built<'p>,
    layout: Layout,
    facts: Facts,
}

/// A structure as its builder left it.
enum Built<'p> {
    List,
    Bvh(bvh::build::Tree<'p>),
    Sphere(bvh::build::Tree<'p>),
    Wide(wide::build::Tree<'p>),
    Parts(Parts<'p>),
}

impl<'p> Plan<'p> {
    #[allow(clippy::needless_pass_by_value)] // it is memory to fill: what it lends is consumed
    fn new(
        input: &'p Input<'p>,
        mesh: &Mesh<'_>,
        config: &Config,
        shape: &Shape,
        lent: Lent<'p>,
    ) -> Result<Self, BuildError> {
        refs::fill(input, lent.refs);
        let built = match shape {
            Shape::List => Built::List,
            Shape::Tree => {
                let tree = bvh::build::build(config, lent.refs, lent.nodes, &input.bounds, mesh.has_tubes())?;
                if config.kind == Kind::Sphere { Built::Sphere(tree) } else { Built::Bvh(tree) }
            }
            Shape::Wide => {
                let blocks = write::all_triangles(mesh);
                let bounds = &input.bounds;
                Built::Wide(wide::build::build(config, lent.refs, lent.nodes, lent.cells, bounds, blocks)?)
            }
            Shape::Grid(plan) => Built::Parts(grid::build::build(input, plan, lent.refs, lent.cells, lent.slots)),
            Shape::Voxel(plan) => Built::Parts(voxel::build::build(input, plan, lent.refs, lent.cells, lent.slots)),
            Shape::Nested(plan) => Built::Parts(nested::build::build(input, plan, lent.refs, lent.cells, lent.slots)),
            Shape::Octree(plan) => {
                Built::Parts(octree::build::build(input, config, plan, lent.refs, lent.cells, lent.slots))
            }
            Shape::Bsp(_) => Built::Parts(bsp::build::build(input, config, lent.refs, lent.cells, lent.slots)),
        };
        let layout = write::layout(mesh, &built)?;
        let (stack, steps) = built.limits(input.len);
        let Input { len: prims, bounds, longest, .. } = *input;
        let facts = Facts { kind: config.kind, prims, stack, steps, bounds, local: config.local, longest };
        Ok(Self { input, built, layout, facts })
    }
}

impl Built<'_> {
    /// Deepest stack and most steps of a walk.
    fn limits(&self, prims: u32) -> (u32, u32) {
        match self {
            Self::List => (0, prims),
            Self::Bvh(tree) | Self::Sphere(tree) => (tree.stack, tree.len.saturating_add(prims)),
            Self::Wide(tree) => (tree.stack, tree.len.saturating_add(prims)),
            Self::Parts(parts) => (parts.stack, parts.steps),
        }
    }
}

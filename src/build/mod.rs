//! Builders: from a mesh to a blob.
//!
//! [`into`] works in memory that the caller lends and never allocates; [`to_vec`] (feature `alloc`) sizes itself. Both
//! run the same code and write the same bytes, on every machine.

mod config;
mod error;
mod mesh;
mod refs;
mod write;

#[cfg(feature = "alloc")]
mod owned;
pub(crate) mod sah;

pub use config::{Config, Rule};
pub use error::{BuildError, What};
pub use mesh::Mesh;
#[cfg(feature = "alloc")]
pub use owned::to_vec;
pub use refs::Ref;

use crate::blob::Kind;
use crate::bvh::{self, Node};
use heapless::VecView;

/// Memory that a builder works in, lent by the caller. [`Needs`] says how much it takes.
///
/// ```
/// use flashray::build::{Arena, Config, Mesh, Needs, into};
/// use flashray::{Kind, Ray, Scene};
///
/// #[repr(align(64))]
/// struct Out([u8; 1024]);
/// let (mut refs, mut nodes) = (heapless::Vec::<_, 8>::new(), heapless::Vec::<_, 8>::new());
/// let mut arena = Arena { refs: &mut refs, nodes: &mut nodes };
/// let mut out = Out([0; 1024]);
///
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
/// let blob = into(&mesh, &Config::new(Kind::Bvh), &mut arena, &mut out.0)?;
/// assert!(Scene::from_bytes(blob).unwrap().any_hit(&Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0])));
/// # Ok::<(), flashray::build::BuildError>(())
/// ```
#[derive(Debug)]
pub struct Arena<'a> {
    /// One per primitive.
    pub refs: &'a mut VecView<Ref>,
    /// One per inner node.
    pub nodes: &'a mut VecView<Node>,
}

/// How much memory a build can take at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Needs {
    /// Entries of [`Arena::refs`].
    pub refs: usize,
    /// Entries of [`Arena::nodes`].
    pub nodes: usize,
    /// Bytes of the blob; `usize::MAX` if the most nodes would make it 4 GiB or longer.
    pub bytes: usize,
}

impl Needs {
    /// What a mesh and a configuration can need at most.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] if there are 2^28 primitives or more.
    pub fn new(mesh: &Mesh<'_>, config: &Config) -> Result<Self, BuildError> {
        let prims = mesh.len()?;
        let nodes = match config.kind {
            Kind::List => 0,
            Kind::Bvh => bvh::build::most_nodes(prims),
        };
        let bytes = write::layout(mesh, nodes, config.kind).map_or(usize::MAX, |layout| layout.len());
        Ok(Self { refs: crate::num::index(prims), nodes: crate::num::index(nodes), bytes })
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
    let needs = Needs::new(mesh, config)?;
    let refs = lend(arena.refs, needs.refs, What::Refs)?;
    // The most nodes are rarely needed: lend what there is, and let the builder say if it was not enough.
    let nodes = arena.nodes.capacity().min(needs.nodes);
    let nodes = lend(arena.nodes, nodes, What::Nodes)?;
    let plan = Plan::new(mesh, config, refs, nodes)?;
    let had = out.len();
    plan.write(out).ok_or(BuildError::Full { what: What::Out, needed: plan.layout.len(), had })
}

/// The first `n` entries of a caller's vector.
fn lend<T: bytemuck::Zeroable + Clone>(view: &mut VecView<T>, n: usize, what: What) -> Result<&mut [T], BuildError> {
    let full = BuildError::Full { what, needed: n, had: view.capacity() };
    view.resize(n, T::zeroed()).map_err(|_| full)?;
    view.get_mut(..n).ok_or(full)
}

/// A finished structure that has not been written yet: its exact length is known.
struct Plan<'p> {
    mesh: &'p Mesh<'p>,
    built: Built<'p>,
    layout: crate::blob::write::Layout,
    facts: crate::blob::write::Facts,
}

/// A structure as its builder left it.
enum Built<'p> {
    List(&'p [Ref]),
    Bvh(bvh::build::Tree<'p>),
}

impl<'p> Plan<'p> {
    fn new(
        mesh: &'p Mesh<'p>,
        config: &Config,
        refs: &'p mut [Ref],
        nodes: &'p mut [Node],
    ) -> Result<Self, BuildError> {
        config.check()?;
        let bounds = refs::fill(mesh, config, refs)?;
        let prims = crate::num::count(refs.len());
        let (built, nodes, stack) = match config.kind {
            Kind::List => (Built::List(refs), 0, 0),
            Kind::Bvh => {
                let tree = bvh::build::build(config, refs, nodes, &bounds, mesh.has_tubes())?;
                (Built::Bvh(tree), tree.len, tree.stack)
            }
        };
        let layout = write::layout(mesh, nodes, config.kind)?;
        let steps = nodes.saturating_add(prims);
        let facts = crate::blob::write::Facts { kind: config.kind, prims, stack, steps, bounds, local: config.local };
        Ok(Self { mesh, built, layout, facts })
    }
}

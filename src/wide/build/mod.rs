//! The builder: the binary tree of [`crate::bvh`], collapsed.
//!
//! Which binary nodes become wide ones, and which subtrees leaves, is chosen for the least expected cost by dynamic
//! programming from the leaves up (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", HPG 2017, section 3.1): for each subtree, the least cost of a forest of one to eight roots
//! that stands for it, each root a wide node or a leaf. A forest of one is a leaf, or a node over the best forest of
//! eight; a larger one is parted between the two children, or is one of fewer roots. A node costs the same wherever it
//! is; a leaf costs so much for each block of its triangles, because four are tested at a time. For nodes of four the same
//! is done with four for eight.
//!
//! Memory: that of the binary tree, and [`WORDS`] words for each of its nodes.

mod forests;
mod tree;

pub use tree::Tree;

use super::{Node, STACK, WIDTH};
use crate::blob::{Section, block};
use crate::build::{BuildError, Config, Ref};
use crate::bvh;
use crate::bvh::build::Leaves;
use crate::geom::Aabb;
use crate::geom::vec::{size, sub};
use forests::{Forests, Known, plan};

/// Words of memory for each node of the binary tree.
pub const WORDS: usize = size_of::<Forests>() / 4;

/// Cost of visiting a node.
pub const NODE_COST: f32 = 1.0;
/// Cost of testing a block of triangles, or one primitive where there are no blocks.
pub const BLOCK_COST: f32 = 0.6;

/// The section for nodes of a width, and the bytes of each.
#[must_use]
pub const fn section(width: usize) -> (Section, usize) {
    match width {
        4 => (Section::Wide4Nodes, size_of::<Node<4>>()),
        _ => (Section::WideNodes, size_of::<Node>()),
    }
}

/// Builds a tree over `refs`; `blocks` says that all are triangles. `words` has [`WORDS`] for each of `nodes`.
///
/// # Errors
/// [`BuildError::Full`] if `nodes` is too short, with the most nodes that any tree could need.
pub fn build<'n>(
    config: &Config,
    refs: &'n mut [Ref],
    nodes: &'n mut [bvh::Node],
    words: &'n mut [u32],
    bounds: &Aabb,
    blocks: bool,
) -> Result<Tree<'n>, BuildError> {
    let lanes = if blocks { block::LANES } else { 1 };
    let forests: &mut [Forests] = bytemuck::cast_slice_mut(words);
    let leaves = Leaves { whole: 1, most: config.leaf, lanes: lanes.trailing_zeros() };
    let mut made = bvh::build::grow(config, refs, nodes, bounds, leaves)?;
    // Areas in units of the scene, so that they neither overflow nor vanish.
    let unit = 1.0 / size(sub(bounds.max, bounds.min));
    let none = Known { nodes: &[], forests: &[], width: config.children(), lanes, unit };
    let mut stack = plan(Known { nodes: nodes.get(..made).unwrap_or(&[]), ..none }, forests, bounds, config.leaf);
    if stack > STACK {
        // Rare: primitives of very unlike sizes. A tree halved by count is never deep.
        made = bvh::build::halved(refs, nodes, bounds)?;
        stack = plan(Known { nodes: nodes.get(..made).unwrap_or(&[]), ..none }, forests, bounds, config.leaf);
    }
    Ok(Tree::new(refs, Known { nodes: nodes.get(..made).unwrap_or(&[]), forests, ..none }, stack))
}

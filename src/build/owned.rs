//! Building with an allocator.
use super::{BuildError, Config, Input, Lent, Mesh, Needs, Plan, Ref, Shape, What};
use crate::bvh::Node;
use alloc::vec;
use alloc::vec::Vec;
use bytemuck::Zeroable;

/// Builds a blob, sizing all memory itself. The same bytes as [`into`](super::into).
///
/// A `Vec<u8>` may start anywhere: to load the blob in place, copy or read it to a multiple of 4, better 64.
///
/// # Errors
/// See [`BuildError`]; never [`BuildError::Full`].
pub fn to_vec(mesh: &Mesh<'_>, config: &Config) -> Result<Vec<u8>, BuildError> {
    let input = Input::new(mesh, config)?;
    let shape = Shape::new(&input, config)?;
    let needs = Needs::of(mesh, &input, config, &shape);
    let (mut refs, mut nodes) = (vec![Ref::zeroed(); needs.refs], vec![Node::zeroed(); needs.nodes]);
    let (mut cells, mut slots) = (vec![0; needs.cells], vec![0; needs.slots]);
    let lent = Lent { refs: &mut refs, nodes: &mut nodes, cells: &mut cells, slots: &mut slots };
    let plan = Plan::new(&input, mesh, config, &shape, lent)?;
    let needed = plan.layout.len();
    let mut out = vec![0; needed];
    match plan.write(&mut out) {
        Some(_) => Ok(out),
        None => Err(BuildError::Full { what: What::Out, needed, had: out.len() }),
    }
}

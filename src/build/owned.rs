//! Building with an allocator.
use super::{BuildError, Config, Mesh, Needs, Plan, Ref, What};
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
    let needs = Needs::new(mesh, config)?;
    let mut refs = vec![Ref::zeroed(); needs.refs];
    let mut nodes = vec![Node::zeroed(); needs.nodes];
    let plan = Plan::new(mesh, config, &mut refs, &mut nodes)?;
    let needed = plan.layout.len();
    let mut out = vec![0; needed];
    match plan.write(&mut out) {
        Some(_) => Ok(out),
        None => Err(BuildError::Full { what: What::Out, needed, had: out.len() }),
    }
}

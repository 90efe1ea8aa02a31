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
    let (mut refs, mut nodes) = (zeroed::<Ref>(needs.refs)?, zeroed::<Node>(needs.nodes)?);
    let (mut cells, mut slots) = (zeroed(needs.cells)?, zeroed(needs.slots)?);
    let lent = Lent { refs: &mut refs, nodes: &mut nodes, cells: &mut cells, slots: &mut slots };
    let plan = Plan::new(&input, mesh, config, &shape, lent)?;
    let needed = plan.layout.len();
    let mut out = zeroed(needed)?;
    match plan.write(&mut out) {
        Some(_) => Ok(out),
        None => Err(BuildError::Full { what: What::Out, needed, had: out.len() }),
    }
}

/// Zeros, if an address space has room for so many: on a 32-bit machine it may not.
fn zeroed<T: Zeroable + Clone>(n: usize) -> Result<Vec<T>, BuildError> {
    let bytes = n.checked_mul(size_of::<T>()).and_then(|bytes| isize::try_from(bytes).ok());
    bytes.map(|_| vec![T::zeroed(); n]).ok_or(BuildError::TooLarge)
}

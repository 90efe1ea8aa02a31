//! Building with an allocator.
use super::{BuildError, Config, Input, Lent, Mesh, Needs, Plan, Ref, Shape, What};
use crate::blob::Buffer;
use crate::bvh::Node;
use alloc::vec::Vec;
use bytemuck::Zeroable;
use core::ops::DerefMut;

/// Builds a blob, sizing all memory itself. The same bytes as [`into`](super::into).
///
/// A `Vec<u8>` may start anywhere: to load the blob where it is built, take [`to_buffer`].
///
/// # Errors
/// See [`BuildError`]; never [`BuildError::Full`].
pub fn to_vec(mesh: &Mesh<'_>, config: &Config) -> Result<Vec<u8>, BuildError> {
    build(mesh, config, zeroed)
}

/// The same in a [`Buffer`], which can be loaded as it is.
///
/// ```
/// use flashray::build::{Config, Mesh, to_buffer};
/// use flashray::{Kind, Ray, Scene};
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
/// let blob = to_buffer(&mesh, &Config::new(Kind::Wide))?;
/// assert!(Scene::from_bytes(&blob).unwrap().any_hit(&Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0])));
/// # Ok::<(), flashray::build::BuildError>(())
/// ```
///
/// # Errors
/// As for [`to_vec`].
pub fn to_buffer(mesh: &Mesh<'_>, config: &Config) -> Result<Buffer, BuildError> {
    build(mesh, config, |len| Buffer::try_zeroed(len).ok_or(BuildError::TooLarge))
}

/// Builds into what `room` gives for so many bytes.
fn build<O: DerefMut<Target = [u8]>>(
    mesh: &Mesh<'_>,
    config: &Config,
    room: impl FnOnce(usize) -> Result<O, BuildError>,
) -> Result<O, BuildError> {
    let input = Input::new(mesh, config)?;
    let shape = Shape::new(&input, config)?;
    let needs = Needs::of(mesh, &input, config, &shape);
    let (mut refs, mut nodes) = (zeroed::<Ref>(needs.refs)?, zeroed::<Node>(needs.nodes)?);
    let (mut cells, mut slots) = (zeroed(needs.cells)?, zeroed(needs.slots)?);
    let lent = Lent { refs: &mut refs, nodes: &mut nodes, cells: &mut cells, slots: &mut slots };
    let plan = Plan::new(&input, mesh, config, &shape, lent)?;
    let needed = plan.layout.len();
    let mut out = room(needed)?;
    match plan.write(&mut out) {
        Some(_) => Ok(out),
        None => Err(BuildError::Full { what: What::Out, needed, had: out.len() }),
    }
}

/// Zeros, if there is memory for so many. They come as the system has them: nothing is written.
fn zeroed<T: Zeroable>(n: usize) -> Result<Vec<T>, BuildError> {
    bytemuck::allocation::try_zeroed_vec(n).map_err(|()| BuildError::TooLarge)
}

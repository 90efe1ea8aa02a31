//! Every primitive against every ray: the oracle that all other structures are held against, and the right choice
//! for a handful of primitives.
//!
//! The blob has no section beyond the primitives. A query takes as many steps as there are primitives, and no stack.
use crate::blob::prims::Prims;
use crate::geom::ray::Prepared;
use crate::walk::{Best, Meter, Stop, test};

/// Tests all primitives, in slot order.
///
/// # Errors
/// [`Stop`] if the meter does not allow as many tests, or the bytes contradict themselves.
#[inline]
pub fn walk<const ANY: bool>(
    prims: &Prims<'_>,
    ray: &Prepared,
    best: &mut Best,
    meter: &mut impl Meter,
) -> Result<bool, Stop> {
    test::<ANY>(prims, (0, prims.len), ray, best, meter)
}

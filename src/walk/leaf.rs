//! A run of slots against a ray.
use super::{Best, Mailbox, Meter, Stop};
use crate::blob::prims::{Primitive, Prims};
use crate::geom::hit::Crossing;
use crate::geom::ray::Prepared;
use crate::num::{count, index};

/// Tests the primitives in `len` slots from `first`. Returns whether the walk is over: with `ANY`, at the first hit.
///
/// # Errors
/// [`Stop::Fuel`] if the meter does not allow `len` tests, [`Stop::Corrupt`] if the slots do not exist.
#[inline(always)]
pub fn test<const ANY: bool>(
    prims: &Prims<'_>,
    (first, len): (u32, u32),
    ray: &Prepared,
    best: &mut Best,
    meter: &mut impl Meter,
) -> Result<bool, Stop> {
    if !meter.prims(len) {
        return Err(Stop::Fuel);
    }
    if !prims.refs.is_empty() {
        // By value both ways: a ray and a best hit that nobody points to can stay in registers.
        let (over, left, found) = mixed::<ANY>(prims, (first, len), *ray, *best)?;
        *best = found;
        meter.untested(left);
        return Ok(over);
    }
    let run = prims.triangles.get(index(first)..).and_then(|t| t.get(..index(len))).ok_or(Stop::Corrupt)?;
    for (i, triangle) in run.iter().enumerate() {
        if let Some(crossing) = triangle.crossing(ray, best.t) {
            best.offer(crossing, prims.id(first.wrapping_add(count(i))));
            if ANY {
                meter.untested(len.wrapping_sub(count(i)).wrapping_sub(1));
                return Ok(true);
            }
        }
    }
    Ok(false)
}

/// Tests the primitives in the slots that a cell lists, but for those that `mailbox` remembers. Returns whether the
/// walk is over: with `ANY`, at the first hit.
///
/// # Errors
/// [`Stop::Fuel`] if the meter does not allow as many tests, [`Stop::Corrupt`] if a slot does not exist.
#[inline(always)]
pub fn test_listed<const ANY: bool>(
    prims: &Prims<'_>,
    slots: &[u32],
    ray: &Prepared,
    best: &mut Best,
    meter: &mut impl Meter,
    mailbox: &mut impl Mailbox,
) -> Result<bool, Stop> {
    if !meter.prims(count(slots.len())) {
        return Err(Stop::Fuel);
    }
    let mut rest = slots.iter();
    while let Some(&slot) = rest.next() {
        if mailbox.seen(slot) {
            meter.spared();
            continue;
        }
        if !prims.refs.is_empty() {
            let (over, _, found) = mixed::<ANY>(prims, (slot, 1), *ray, *best)?;
            *best = found;
            if over {
                meter.untested(count(rest.len()));
                return Ok(true);
            }
            continue;
        }
        let triangle = prims.triangles.get(index(slot)).ok_or(Stop::Corrupt)?;
        if let Some(crossing) = triangle.crossing(ray, best.t) {
            best.offer(crossing, prims.id(slot));
            if ANY {
                meter.untested(count(rest.len()));
                return Ok(true);
            }
        }
    }
    Ok(false)
}

/// A run of slots where other kinds stand among the triangles: whether the walk is over, and how many slots were then
/// left. Out of line: a scene of triangles alone never gets here.
#[inline(never)]
fn mixed<const ANY: bool>(
    prims: &Prims<'_>,
    (first, len): (u32, u32),
    ray: Prepared,
    mut best: Best,
) -> Result<(bool, u32, Best), Stop> {
    let end = first.saturating_add(len);
    for slot in first..end {
        let at_t = |t| Crossing { t, u: 0.0, v: 0.0, enters: true };
        let crossing = match prims.get(slot).ok_or(Stop::Corrupt)? {
            Primitive::Triangle(p) => p.crossing(&ray, best.t),
            Primitive::Sphere(p) => p.crossing(&ray, best.t).map(at_t),
            Primitive::Box(p) => p.crossing(&ray, best.t).map(at_t),
            Primitive::Cylinder(p) => p.as_cone().crossing(&ray, best.t).map(at_t),
            Primitive::Cone(p) => p.crossing(&ray, best.t).map(at_t),
        };
        if let Some(crossing) = crossing {
            best.offer(crossing, prims.id(slot));
            if ANY {
                return Ok((true, end.wrapping_sub(slot).wrapping_sub(1), best));
            }
        }
    }
    Ok((false, 0, best))
}

//! A run of slots against a ray.
use super::mailbox::NoMailbox;
use super::{Best, Mailbox, Meter, Stop};
use crate::blob::prims::Prims;
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
        let tested = mixed::<ANY>(prims, first..first.saturating_add(len), *ray, *best, &mut NoMailbox)?;
        return Ok(tested.settle(best, meter));
    }
    let run = prims.triangles.get(index(first)..).and_then(|t| t.get(..index(len))).ok_or(Stop::Corrupt)?;
    for (i, triangle) in run.iter().enumerate() {
        if let Some(crossing) = triangle.crossing(ray, best.t) {
            best.offer(crossing, prims.id_outside_blocks(first.wrapping_add(count(i))));
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
    if !prims.refs.is_empty() {
        let tested = mixed::<ANY>(prims, slots.iter().copied(), *ray, *best, mailbox)?;
        return Ok(tested.settle(best, meter));
    }
    let mut rest = slots.iter();
    while let Some(&slot) = rest.next() {
        if mailbox.seen(slot) {
            meter.spared(1);
            continue;
        }
        let triangle = prims.triangles.get(index(slot)).ok_or(Stop::Corrupt)?;
        if let Some(crossing) = triangle.crossing(ray, best.t) {
            best.offer(crossing, prims.id_outside_blocks(slot));
            if ANY {
                meter.untested(count(rest.len()));
                return Ok(true);
            }
        }
    }
    Ok(false)
}

/// What [`mixed`] did.
struct Tested {
    /// Whether the walk is over.
    over: bool,
    /// How many slots a mailbox remembered.
    spared: u32,
    /// How many slots were left when the walk was over.
    left: u32,
    best: Best,
}

impl Tested {
    #[inline(always)]
    fn settle(self, best: &mut Best, meter: &mut impl Meter) -> bool {
        *best = self.best;
        meter.spared(self.spared);
        meter.untested(self.left);
        self.over
    }
}

/// Slots where other kinds stand among the triangles. Out of line: a scene of triangles alone never gets here.
#[inline(never)]
fn mixed<const ANY: bool>(
    prims: &Prims<'_>,
    mut slots: impl ExactSizeIterator<Item = u32>,
    ray: Prepared,
    best: Best,
    mailbox: &mut impl Mailbox,
) -> Result<Tested, Stop> {
    let mut tested = Tested { over: false, spared: 0, left: 0, best };
    while let Some(slot) = slots.next() {
        if mailbox.seen(slot) {
            tested.spared = tested.spared.wrapping_add(1);
            continue;
        }
        if let Some(crossing) = crossing(prims, slot, &ray, tested.best.t)? {
            tested.best.offer(crossing, prims.id_outside_blocks(slot));
            if ANY {
                (tested.over, tested.left) = (true, count(slots.len()));
                return Ok(tested);
            }
        }
    }
    Ok(tested)
}

/// Where a ray crosses the primitive in a slot.
///
/// In place: a [`Primitive`](crate::blob::prims::Primitive) is copied in other pieces than it is read in, and to wait
/// for those took longer than the test.
#[inline(always)]
pub(super) fn crossing(prims: &Prims<'_>, slot: u32, ray: &Prepared, t_max: f32) -> Result<Option<Crossing>, Stop> {
    let (kind, at) = prims.referred(slot).ok_or(Stop::Corrupt)?;
    let at_t = |t| Crossing { t, u: 0.0, v: 0.0, enters: true };
    let found = match kind {
        0 => prims.triangles.get(at).map(|p| p.crossing(ray, t_max)),
        1 => prims.spheres.get(at).map(|p| p.crossing(ray, t_max).map(at_t)),
        2 => prims.boxes.get(at).map(|p| p.crossing(ray, t_max).map(at_t)),
        3 => prims.cylinders.get(at).map(|p| p.as_cone().crossing(ray, t_max).map(at_t)),
        4 => prims.cones.get(at).map(|p| p.crossing(ray, t_max).map(at_t)),
        _ => None,
    };
    found.ok_or(Stop::Corrupt)
}

//! Short runs, at any place.
use super::{Extent, Parted, Scale, Span};
use crate::build::Ref;
use crate::geom::Aabb;
use crate::num::{byte, count, index};
use bytemuck::Zeroable;

/// Parts a run of two, if that costs less than `whole`: along each axis that is the same.
pub fn pair(run: &mut [Ref], scale: &Scale<'_>, whole: f32) -> Parted {
    let [a, b] = run else { return None };
    if !(scale.tests(&Span::of(a), 1) + scale.tests(&Span::of(b), 1) < whole) {
        return None;
    }
    if key(b, 0) < key(a, 0) {
        core::mem::swap(a, b);
    }
    let [left, right] = [a, b].map(|r| Extent { bounds: r.bounds, centers: Aabb::EMPTY });
    Some((1, left, right))
}

/// Parts a run of at most `N`, a power of 2, at the best of all places, if that costs less than `whole`.
pub fn parted<const N: usize>(run: &mut [Ref], scale: &Scale<'_>, whole: f32) -> Parted {
    let n = run.len().min(N);
    let mut copy = [Ref::zeroed(); N];
    copy.iter_mut().zip(run.iter()).for_each(|(copy, r)| *copy = *r);
    let (mut least, mut place) = (whole, None);
    let orders = [0, 1, 2].map(|axis| order(&copy, n, axis));
    for (axis, order) in orders.iter().enumerate() {
        let span = |i: usize| Span::of(&copy[usize::from(order[i % N]) % N]);
        let mut after = [0.0; N];
        let mut right = Span::empty();
        for at in (1..n).rev() {
            right.add(&span(at));
            after[at % N] = scale.tests(&right, count(n - at));
        }
        let mut left = Span::empty();
        for at in 1..n {
            left.add(&span(at - 1));
            let tests = scale.tests(&left, count(at)) + after[at % N];
            if tests < least {
                (least, place) = (tests, Some((axis, at)));
            }
        }
    }
    let (axis, at) = place?;
    for (r, &from) in run.iter_mut().zip(&orders[axis % 3]) {
        *r = copy[usize::from(from) % N];
    }
    let (left, right) = run.split_at_checked(at)?;
    let [left, right] = [left, right].map(|run| Extent { bounds: bounds_of(run), centers: Aabb::EMPTY });
    Some((at, left, right))
}

/// The box of a run.
fn bounds_of(run: &[Ref]) -> Aabb {
    let mut all = Span::empty();
    for r in run {
        all.add(&Span::of(r));
    }
    all.bounds()
}

/// The places of the first `n` references, by their centres along an axis; ties by place.
#[inline(always)]
fn order<const N: usize>(run: &[Ref; N], n: usize, axis: usize) -> [u8; N] {
    let mut keys = [i32::MAX - 1; N];
    for (place, r) in keys.iter_mut().zip(run).take(n) {
        *place = key(r, axis);
    }
    // Each is as many places from the front as there are others before it. All of `N` are counted at once, without a
    // branch: for so few that is quicker than any sorting.
    let mut places = [0i32; N];
    for i in 0..n {
        let key = keys[i % N];
        for j in 0..N {
            places[j] += i32::from(key < keys[j] + i32::from(i < j));
        }
    }
    let mut order = [0; N];
    for (i, &place) in places.iter().enumerate().take(n) {
        order[index(place.cast_unsigned()) % N] = byte(i);
    }
    order
}

/// What a reference is ordered by along an axis, as by `total_cmp` of centres.
#[inline(always)]
fn key(r: &Ref, axis: usize) -> i32 {
    let bits = r.center2()[axis % 3].to_bits().cast_signed();
    bits ^ ((bits >> 31) & i32::MAX)
}

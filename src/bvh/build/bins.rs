//! Where to part a run of references: quickly, with hardly a worse tree.
//!
//! Long runs are parted between bins (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", IEEE RT
//! 2007): one pass puts each reference into one of 8 to 32 bins of equal width along each axis, by its centre, and only
//! the places between bins are weighed. A second pass parts the run, and finds the boxes of both sides' centres. Short
//! runs are swept: all places along each axis are weighed.
//!
//! Whatever is summed up in parts is so in the order of the references, so that the result does not depend on how
//! many threads have a part in it.
use crate::build::Ref;
use crate::build::sah::{area, halve};
use crate::geom::Aabb;
use crate::geom::vec::{Vec3, least3, most3, size, sub};
use crate::num::{count, float, index, low};
use bytemuck::Zeroable;

/// Most bins along an axis, a power of 2.
const BINS: usize = 32;
/// The bins of a run along each axis.
type Bins = [[Bin; BINS]; 3];
const EMPTY: Bins = [[Bin::EMPTY; BINS]; 3];
/// Runs of up to so many are swept.
const SWEPT: usize = 16;
/// A split that saves less than this share of the tests is no better than chance.
const GAIN: f32 = 0.9999;
/// Added to a number from 0 to 2^20, it leaves the nearest whole number in the lowest bits.
const WHOLE: f32 = 12_582_912.0; // 1.5 x 2^23

/// What a leaf is to be.
#[derive(Clone, Copy, Debug)]
pub struct Leaves {
    /// Runs of up to so many are left whole.
    pub whole: u32,
    /// Runs of up to so many are, if no split saves tests.
    pub most: u32,
    /// So many primitives, as a power of 2, are tested at a time.
    pub lanes: u32,
}

impl Leaves {
    /// Tests of a leaf of so many primitives.
    const fn tests(&self, n: u32) -> f32 {
        float(n.saturating_add((1 << self.lanes) - 1) >> self.lanes)
    }
}

/// A run's box, and that of twice the centres, which short runs need not have.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Around all of each.
    pub bounds: Aabb,
    /// Around twice the centres.
    pub centers: Aabb,
}

impl Extent {
    /// That of a run.
    pub fn of(run: &[Ref]) -> Self {
        Self { bounds: bounds_of(run), centers: run.iter().fold(Aabb::EMPTY, |all, r| all.with(r.center2())) }
    }
}

/// The box of a run.
fn bounds_of(run: &[Ref]) -> Aabb {
    let mut all = Bin::EMPTY;
    for r in run {
        all.add(&Bin::of(r));
    }
    all.bounds()
}

/// How a run was parted: before the reference at this place, into what has these extents.
pub type Parted = Option<(usize, Extent, Extent)>;

/// Parts a run where that is expected to cost least; `None` if it is to be a leaf.
pub fn part(run: &mut [Ref], extent: &Extent, leaves: &Leaves) -> Parted {
    let n = count(run.len());
    if n <= leaves.whole.max(1) {
        return None;
    }
    // Areas in units of the run, so that they neither overflow nor vanish.
    let scale = Scale { unit: 1.0 / size(sub(extent.bounds.max, extent.bounds.min)), leaves };
    let whole = leaves.tests(n) * area(&extent.bounds, scale.unit) * GAIN;
    let parted = if run.len() <= SWEPT {
        swept(run, &scale, whole)
    } else {
        Map::new(extent, run.len()).parted(run, &scale, whole)
    };
    if parted.is_some() || n <= leaves.most { parted } else { in_half(run) }
}

/// Parts a run in the middle.
pub fn in_half(run: &mut [Ref]) -> Parted {
    let _ = halve(run);
    let at = run.len() / 2;
    let (left, right) = run.split_at_checked(at)?;
    Some((at, Extent::of(left), Extent::of(right)))
}

/// A box and a number of references, in lanes as they stand in a reference: of `low` the last, of `high` the first
/// means nothing.
#[derive(Clone, Copy)]
struct Bin {
    low: [f32; 4],
    high: [f32; 4],
    len: u32,
}

impl Bin {
    const EMPTY: Self = Self { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4], len: 0 };

    const fn of(r: &Ref) -> Self {
        let Aabb { min: a, max: b } = r.bounds;
        Self { low: [a[0], a[1], a[2], b[0]], high: [a[2], b[0], b[1], b[2]], len: 1 }
    }

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        for (all, new) in self.low.iter_mut().zip(other.low) {
            *all = if new < *all { new } else { *all };
        }
        for (all, new) in self.high.iter_mut().zip(other.high) {
            *all = if new > *all { new } else { *all };
        }
        self.len += other.len;
    }

    const fn bounds(&self) -> Aabb {
        let ([a, b, c, _], [_, d, e, f]) = (self.low, self.high);
        Aabb { min: [a, b, c], max: [d, e, f] }
    }
}

/// Which bin a centre belongs to.
struct Map {
    min: Vec3,
    /// Bins a length.
    scale: Vec3,
    bins: usize,
}

impl Map {
    fn new(extent: &Extent, len: usize) -> Self {
        let bins = match len {
            ..64 => BINS / 4,
            64..512 => BINS / 2,
            _ => BINS,
        };
        // A little less, so that the greatest centre is in the last bin.
        let scale = sub(extent.centers.max, extent.centers.min).map(|size| float(count(bins)) * 0.9999 / size);
        Self { min: extent.centers.min, scale, bins }
    }

    /// The bin along an axis. In an axis without extent, and in a scene too large to subtract, it is any.
    #[inline(always)]
    fn bin(&self, center: Vec3, axis: usize) -> usize {
        let at = (center[axis] - self.min[axis]) * self.scale[axis];
        index(((at - 0.4999) + WHOLE).to_bits()) % BINS
    }

    /// All bins of a run.
    #[cfg(feature = "parallel")]
    fn fill(&self, run: &[Ref]) -> Bins {
        use rayon::prelude::*;
        /// References to a thread.
        const SHARE: usize = 1 << 15;
        if run.len() < 2 * SHARE {
            return self.filled(run);
        }
        run.par_chunks(SHARE).map(|run| self.filled(run)).reduce(
            || EMPTY,
            |mut all, more| {
                for (all, more) in all.as_flattened_mut().iter_mut().zip(more.as_flattened()) {
                    all.add(more);
                }
                all
            },
        )
    }

    #[cfg(not(feature = "parallel"))]
    fn fill(&self, run: &[Ref]) -> Bins {
        self.filled(run)
    }

    fn filled(&self, run: &[Ref]) -> Bins {
        let mut bins = EMPTY;
        for r in run {
            let (one, center) = (Bin::of(r), r.center2());
            bins[0][self.bin(center, 0)].add(&one);
            bins[1][self.bin(center, 1)].add(&one);
            bins[2][self.bin(center, 2)].add(&one);
        }
        bins
    }

    /// Parts a run at the best place between bins, if that costs less than `whole`.
    fn parted(&self, run: &mut [Ref], scale: &Scale<'_>, whole: f32) -> Parted {
        let all = self.fill(run);
        let (mut least, mut place) = (whole, None);
        for (axis, bins) in all.iter().enumerate() {
            let bins = bins.get(..self.bins).unwrap_or(bins);
            let mut after = [0.0; BINS];
            let mut right = Bin::EMPTY;
            for (bin, after) in bins.iter().zip(&mut after).rev() {
                right.add(bin);
                *after = scale.tests(&right);
            }
            let mut left = Bin::EMPTY;
            for (at, (bin, after)) in (1..).zip(bins.iter().zip(after.iter().skip(1))) {
                left.add(bin);
                let tests = scale.tests(&left) + after;
                // Passes over the NaN of an empty side.
                if tests < least {
                    (least, place) = (tests, Some((axis, at)));
                }
            }
        }
        let (axis, at) = place?;
        let (left, right) = all[axis % 3].split_at_checked(at)?;
        let bounds = [left, right].map(|bins| {
            let mut all = Bin::EMPTY;
            for bin in bins {
                all.add(bin);
            }
            all.bounds()
        });
        Some(self.partition(run, axis % 3, at, bounds))
    }

    /// Moves what belongs before a bin to the front.
    fn partition(&self, run: &mut [Ref], axis: usize, before: usize, bounds: [Aabb; 2]) -> (usize, Extent, Extent) {
        let mut at = 0;
        let mut centers = [Aabb::EMPTY; 2];
        for i in 0..run.len() {
            let Some(r) = run.get(i) else { break };
            let center = r.center2();
            let first = self.bin(center, axis) < before;
            // No branch: there is no foretelling which side it is.
            let only = |yes: bool, else_: f32| center.map(|c| if yes { c } else { else_ });
            let [left, right] = &mut centers;
            (left.min, left.max) =
                (least3(only(first, f32::INFINITY), left.min), most3(only(first, f32::NEG_INFINITY), left.max));
            (right.min, right.max) =
                (least3(only(!first, f32::INFINITY), right.min), most3(only(!first, f32::NEG_INFINITY), right.max));
            run.swap(i, at);
            at += usize::from(first);
        }
        let [left, right] = [0, 1].map(|side| Extent { bounds: bounds[side], centers: centers[side] });
        (at, left, right)
    }
}

/// How areas and leaves are weighed.
struct Scale<'l> {
    /// Areas are in units of the run, so that they neither overflow nor vanish.
    unit: f32,
    leaves: &'l Leaves,
}

impl Scale<'_> {
    fn tests(&self, bin: &Bin) -> f32 {
        area(&bin.bounds(), self.unit) * self.leaves.tests(bin.len)
    }
}

/// Parts a short run at the best of all places, if that costs less than `whole`.
fn swept(run: &mut [Ref], scale: &Scale<'_>, whole: f32) -> Parted {
    let n = run.len();
    let (mut least, mut place) = (whole, None);
    let orders = [sorted(run, 0), sorted(run, 1), sorted(run, 2)];
    for (axis, order) in orders.iter().enumerate() {
        let order = order.get(..n)?;
        let bin = |key: i64| run.get(place_of(key)).map_or(Bin::EMPTY, Bin::of);
        let mut after = [0.0; SWEPT];
        let mut right = Bin::EMPTY;
        for (&key, after) in order.iter().zip(&mut after).rev() {
            right.add(&bin(key));
            *after = scale.tests(&right);
        }
        let mut left = Bin::EMPTY;
        for (at, (&key, after)) in (1..).zip(order.iter().zip(after.iter().skip(1)).take(n - 1)) {
            left.add(&bin(key));
            let tests = scale.tests(&left) + after;
            if tests < least {
                (least, place) = (tests, Some((axis, at)));
            }
        }
    }
    let (axis, at) = place?;
    let order = orders[axis % 3];
    let mut copy = [Ref::zeroed(); SWEPT];
    copy.get_mut(..n)?.copy_from_slice(run);
    for (r, key) in run.iter_mut().zip(order) {
        *r = copy[place_of(key)];
    }
    let (left, right) = run.split_at_checked(at)?;
    let [left, right] = [left, right].map(|run| Extent { bounds: bounds_of(run), centers: Aabb::EMPTY });
    Some((at, left, right))
}

/// The places of a short run's references, by their centres along an axis; the key of the n-th is the n-th.
fn sorted(run: &[Ref], axis: usize) -> [i64; SWEPT] {
    let mut keys = [i64::MAX; SWEPT];
    for (place, (key, r)) in (0..).zip(keys.iter_mut().zip(run)) {
        // The order of total_cmp; ties by place.
        let bits = r.center2()[axis % 3].to_bits();
        let ordered = if bits >> 31 == 0 { bits } else { bits ^ 0x7fff_ffff };
        *key = i64::from(ordered.cast_signed()) << 32 | place;
    }
    if let Some(keys) = keys.get_mut(..run.len()) {
        keys.sort_unstable();
    }
    keys
}

/// The place that a key is of.
const fn place_of(key: i64) -> usize {
    index(low(key)) % SWEPT
}

//! Where to part a run of references: quickly, with hardly a worse tree.
//!
//! Long runs are parted between bins (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", IEEE RT
//! 2007): one pass puts each reference into one of 8 to 32 bins of equal width along each axis, by its centre, and only
//! the places between bins are weighed. A second pass parts the run, and finds the boxes of both sides' centres. Short
//! runs are swept: all places along each axis are weighed.
//!
//! Whatever is summed up in parts is so in the order of the references, so that the result does not depend on how
//! many threads have a part in it.

mod map;
mod short;

use crate::build::Ref;
use crate::build::sah::halve;
use crate::geom::Aabb;
use crate::geom::vec::{size, sub};
use crate::num::{count, float};
use crate::walk::lanes::{Four, Lanes};
use map::Map;
use short::{pair, parted};

/// A split that saves less than this share of the tests is no better than chance.
const GAIN: f32 = 0.9999;

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
    #[inline(always)]
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
        let (mut bounds, mut centers) = (Span::empty(), Span::empty());
        for r in run {
            bounds.add(&Span::of(r));
            let center = center2(r);
            centers.add(&Span { low: center, high: center });
        }
        Self { bounds: bounds.bounds(), centers: centers.bounds() }
    }
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
    let whole = scale.tests(&Span::around(&extent.bounds), n) * GAIN;
    let parted = match run.len() {
        2 => pair(run, &scale, whole),
        3..=4 => parted::<4>(run, &scale, whole),
        5..=8 => parted::<8>(run, &scale, whole),
        9..=16 => parted::<16>(run, &scale, whole),
        17..64 => Map::<8>::new(extent).parted(run, &scale, whole),
        64..512 => Map::<16>::new(extent).parted(run, &scale, whole),
        _ => Map::<32>::new(extent).parted(run, &scale, whole),
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

/// A box in lanes, of which the last means nothing: what follows a reference's corner in memory may stand there.
#[derive(Clone, Copy, Debug)]
struct Span {
    low: Four,
    high: Four,
}

impl Span {
    #[inline(always)]
    fn empty() -> Self {
        Self { low: Four::splat(f32::INFINITY), high: Four::splat(f32::NEG_INFINITY) }
    }

    #[inline(always)]
    fn of(r: &Ref) -> Self {
        Self { low: four::<0>(r), high: four::<3>(r) }
    }

    #[inline(always)]
    fn around(bounds: &Aabb) -> Self {
        let row = |[x, y, z]: [f32; 3]| Four::load(&[x, y, z, 0.0]);
        Self { low: row(bounds.min), high: row(bounds.max) }
    }

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        self.low = other.low.least(self.low);
        self.high = other.high.most(self.high);
    }

    #[inline(always)]
    fn bounds(&self) -> Aabb {
        let ([a, b, c, _], [d, e, f, _]) = (self.low.store(), self.high.store());
        Aabb { min: [a, b, c], max: [d, e, f] }
    }
}

/// Four numbers of a reference from the `AT`-th on: the least corner from 0, the greatest from 3.
#[inline(always)]
fn four<const AT: usize>(r: &Ref) -> Four {
    let row: &[f32; 8] = bytemuck::cast_ref(r);
    row.get(AT..).and_then(<[f32]>::first_chunk).map_or(Four::splat(0.0), Four::load)
}

/// Twice the centre of a reference's box, as [`Ref::center2`].
#[inline(always)]
fn center2(r: &Ref) -> Four {
    four::<0>(r) + four::<3>(r)
}

/// How areas and leaves are weighed.
struct Scale<'l> {
    /// Areas are in units of the run, so that they neither overflow nor vanish.
    unit: f32,
    leaves: &'l Leaves,
}

impl Scale<'_> {
    /// Tests of a leaf of so many primitives, by a ray that meets what has area 1.
    #[inline(always)]
    fn tests(&self, span: &Span, n: u32) -> f32 {
        // As `sah::area` has it.
        let [x, y, z, _] = (span.high - span.low).store();
        let (x, y, z) = (x * self.unit, y * self.unit, z * self.unit);
        (x * y + (y * z + z * x)) * self.leaves.tests(n)
    }
}

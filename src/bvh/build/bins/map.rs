//! Long runs, between bins.
use super::{Extent, Parted, Scale, Span, center2};
use crate::build::Ref;
use crate::geom::Aabb;
use crate::geom::vec::{Vec3, sub};
use crate::num::{count, float, index};
use crate::walk::lanes::{Four, Lanes};

/// Added to a number from 0 to 2^20, it leaves the nearest whole number in the lowest bits.
const WHOLE: f32 = 12_582_912.0; // 1.5 x 2^23

/// The bins along an axis: a box, and a number of references.
type Axis<const N: usize> = ([Span; N], [u32; N]);
/// Those along each.
type Bins<const N: usize> = [Axis<N>; 3];

/// Which of `N` bins, a power of 2, a centre belongs to.
pub struct Map<const N: usize> {
    min: Vec3,
    /// Bins a length.
    scale: Vec3,
}

impl<const N: usize> Map<N> {
    pub fn new(extent: &Extent) -> Self {
        // A little less, so that the greatest centre is in the last bin.
        let scale = sub(extent.centers.max, extent.centers.min).map(|size| float(count(N)) * 0.9999 / size);
        Self { min: extent.centers.min, scale }
    }

    /// The bin along an axis. In an axis without extent, and in a scene too large to subtract, it is any.
    #[inline(always)]
    fn bin(&self, center: f32, axis: usize) -> usize {
        let at = (center - self.min[axis]) * self.scale[axis];
        index(((at - 0.4999) + WHOLE).to_bits()) % N
    }

    fn empty() -> Bins<N> {
        [([Span::empty(); N], [0; N]); 3]
    }

    /// All bins of a run.
    #[cfg(feature = "parallel")]
    fn fill(&self, run: &[Ref]) -> Bins<N> {
        use rayon::prelude::*;
        /// References to a thread.
        const SHARE: usize = 1 << 15;
        if run.len() < 2 * SHARE {
            return self.filled(run);
        }
        run.par_chunks(SHARE).map(|run| self.filled(run)).reduce(Self::empty, |mut all, more| {
            join(&mut all, &more);
            all
        })
    }

    #[cfg(not(feature = "parallel"))]
    fn fill(&self, run: &[Ref]) -> Bins<N> {
        self.filled(run)
    }

    fn filled(&self, run: &[Ref]) -> Bins<N> {
        let mut bins = Self::empty();
        let row = self.rows();
        if N < 16 || !Four::AT_ONCE {
            for r in run {
                row.put(r, &mut bins);
            }
            return bins;
        }
        // Neighbours are often in the same bin, and would wait for each other: so the halves take turns.
        let (first, second) = run.split_at_checked(run.len() / 2).unwrap_or((run, &[]));
        let mut more = Self::empty();
        for (a, b) in first.iter().zip(second) {
            row.put(a, &mut bins);
            row.put(b, &mut more);
        }
        second.iter().skip(first.len()).for_each(|r| row.put(r, &mut more));
        join(&mut bins, &more);
        bins
    }

    /// For all axes at once.
    fn rows(&self) -> Rows<N> {
        // What stands in the last lane is no number to multiply: so little that it takes long.
        let row = |[x, y, z]: Vec3, last| Four::load(&[x, y, z, last]);
        Rows { min: row(self.min, 1.0), scale: row(self.scale, 0.0) }
    }

    /// Parts a run at the best place between bins, if that costs less than `whole`.
    pub fn parted(&self, run: &mut [Ref], scale: &Scale<'_>, whole: f32) -> Parted {
        let all = self.fill(run);
        let (mut least, mut place) = (whole, None);
        for (axis, (spans, lens)) in all.iter().enumerate() {
            let mut after = [0.0; N];
            let (mut right, mut n) = (Span::empty(), 0);
            for ((span, len), after) in spans.iter().zip(lens).zip(&mut after).rev() {
                right.add(span);
                n += len;
                *after = scale.tests(&right, n);
            }
            let (mut left, mut n) = (Span::empty(), 0);
            for (at, ((span, len), after)) in (1..).zip(spans.iter().zip(lens).zip(after.iter().skip(1))) {
                left.add(span);
                n += len;
                let tests = scale.tests(&left, n) + after;
                // Passes over the NaN of an empty side.
                if tests < least {
                    (least, place) = (tests, Some((axis, at)));
                }
            }
        }
        let (axis, at) = place?;
        let (left, right) = all[axis % 3].0.split_at_checked(at)?;
        let bounds = |spans: &[Span]| {
            let mut all = Span::empty();
            for span in spans {
                all.add(span);
            }
            all.bounds()
        };
        Some(self.partition(run, axis % 3, at, [bounds(left), bounds(right)]))
    }

    /// Moves what belongs before a bin to the front.
    fn partition(&self, run: &mut [Ref], axis: usize, before: usize, bounds: [Aabb; 2]) -> (usize, Extent, Extent) {
        /// What is added to centres of the other side, and to those of a side: no number is less or more than NaN, and
        /// with -0 all stay what they are. No branch: there is no foretelling which side it is.
        const ONLY: [f32; 2] = [f32::NAN, -0.0];
        let only = ONLY.map(Four::splat);
        let mut at = 0;
        let mut centers = [Span::empty(); 2];
        for i in 0..run.len() {
            let Some(r) = run.get(i) else { break };
            let row: &[f32; 8] = bytemuck::cast_ref(r);
            let first = usize::from(self.bin(row[axis % 3] + row[axis % 3 + 3], axis % 3) < before);
            let center = center2(r);
            let (left, right) = (center + only[first], center + only[1 - first]);
            centers[0].add(&Span { low: left, high: left });
            centers[1].add(&Span { low: right, high: right });
            run.swap(i, at);
            at += first;
        }
        let [left, right] = [0, 1].map(|side: usize| Extent { bounds: bounds[side], centers: centers[side].bounds() });
        (at, left, right)
    }
}

/// Adds bins of what comes after.
fn join<const N: usize>(bins: &mut Bins<N>, more: &Bins<N>) {
    for ((spans, lens), (more_spans, more_lens)) in bins.iter_mut().zip(more) {
        spans.iter_mut().zip(more_spans).for_each(|(all, more)| all.add(more));
        lens.iter_mut().zip(more_lens).for_each(|(all, more)| *all += more);
    }
}

/// A [`Map`] in lanes.
struct Rows<const N: usize> {
    min: Four,
    scale: Four,
}

impl<const N: usize> Rows<N> {
    /// Puts a reference into its bins.
    #[inline(always)]
    fn put(&self, r: &Ref, bins: &mut Bins<N>) {
        let (span, center) = (Span::of(r), center2(r));
        let at = (((center - self.min) * self.scale - Four::splat(0.4999)) + Four::splat(WHOLE)).store();
        for axis in 0..3 {
            let (spans, lens) = &mut bins[axis];
            let at = index(at[axis].to_bits()) % N;
            spans[at].add(&span);
            lens[at] += 1;
        }
    }
}

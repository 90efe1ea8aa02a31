//! Sixty-four rays at once.
//!
//! "Nodes and objects within are loaded once for each group of rays" (Mahovsky and Wyvill's lecture; Mahovsky, "Ray Tracing
//! with Reduced-Precision Bounding Volume Hierarchies", `PhD` thesis, Calgary 2005). The rays of a group that meet a node are a
//! mask of 64 bits, and the stack holds such masks beside the nodes that wait. A node's box is tested where it leaves the
//! stack, so that what was hit meanwhile counts. Where all directions have the same signs, one interval test speaks for the
//! whole group first (Reshetov, Soupikov and Hurley, "Multi-Level Ray Tracing Algorithm", ACM TOG 24(3), 2005). What that
//! leaves is tested eight rays at a time. A node that few rays meet they walk alone from there.
//!
//! A walk may visit more than a ray alone would: each test on a primitive is that of [`crate::geom`], so what is found is the
//! same, whoever else is in the group.
mod bundle;
mod leaf;

use super::lanes::{Lanes, Work};
use super::{Best, Meter, Stop, Tally};
use crate::blob::MAX_STACK;
use crate::blob::prims::Prims;
use crate::geom::ray::Prepared;
use crate::geom::vec::{least3, most3, size, sub};
use crate::geom::{Aabb, Hit, Ray};
use crate::num::{count, index};
use bundle::Bundle;

/// Most rays of a group.
pub const RAYS: usize = 64;
/// Rays that are tested at a time.
const AT_ONCE: usize = 8;
/// So often in a group.
const CHUNKS: usize = RAYS / AT_ONCE;
/// With so many rays left, each goes on alone.
const FEW: u32 = 2;
/// Fewer rays are no group.
const LEAST: usize = 8;
/// Rays are near to each other if so many times the box of their origins is no longer than the scene.
const NEAR: f32 = 2.0;

/// Most numbers in all lists: those of as many nodes as can wait, and the last.
const LISTED: usize = RAYS * (index(MAX_STACK) + 2);

/// Bytes of stack that a group takes, but for the walk of its tree.
pub const SCRATCH: usize = size_of::<State>();
const _: () = assert!(SCRATCH <= 17_000);

/// The slots of a leaf.
#[derive(Clone, Copy)]
pub enum Slots<'a> {
    /// So many from the first.
    Run(u32, u32),
    /// These.
    List(&'a [u32]),
}

/// A tree whose nodes have boxes.
pub trait Tree<'a> {
    /// A node or leaf.
    type Place: Copy;

    /// The root and its box.
    fn root(&self) -> (Self::Place, Aabb);

    /// Fetches what is at a place. The slots of a leaf; for a node, calls `child` with its children, those last that rays of
    /// this heading meet first.
    ///
    /// # Errors
    /// What `child` says, and [`Stop::Corrupt`] if there is nothing.
    fn open(
        &self,
        at: Self::Place,
        bounds: &Aabb,
        heading: &Heading,
        child: impl FnMut(Self::Place, Aabb) -> Result<(), Stop>,
    ) -> Result<Option<Slots<'a>>, Stop>;

    /// Whether a place is a node to be fetched. Where not, it is a leaf of at least one slot.
    #[inline(always)]
    fn costs(&self, _: Self::Place) -> bool {
        true
    }

    /// One ray from a place on. Returns whether the walk ended at a hit.
    ///
    /// # Errors
    /// [`Stop`] if the meter runs out or the bytes contradict themselves.
    fn alone<const ANY: bool>(
        &self,
        at: Self::Place,
        bounds: &Aabb,
        ray: &Prepared,
        best: &mut Best,
        meter: &mut impl Meter,
    ) -> Result<bool, Stop>;
}

/// Where a group goes, about.
#[derive(Clone, Copy, Debug, Default)]
pub struct Heading([f32; 3]);

impl Heading {
    /// Whether it goes down along an axis.
    #[inline(always)]
    #[must_use]
    pub fn is_negative(&self, k: usize) -> bool {
        self.0.get(k).is_some_and(|&d| d < 0.0)
    }

    /// Whether it comes to the second box first.
    #[inline(always)]
    #[must_use]
    pub fn swaps(&self, a: &Aabb, b: &Aabb) -> bool {
        let along = |k: usize| ((b.min[k] + b.max[k]) - (a.min[k] + a.max[k])) * self.0[k];
        along(0) + along(1) + along(2) < 0.0
    }
}

/// The numbers of the rays in a mask.
#[inline(always)]
fn each(mut rays: u64) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let first = rays.trailing_zeros();
        rays &= rays.wrapping_sub(1);
        (first < 64).then_some(index(first))
    })
}

/// Up to 64 rays of a query.
#[allow(clippy::struct_field_names)] // the rays themselves, and what belongs to them
pub struct Rays<'q, 'a> {
    /// What they may meet.
    pub prims: &'q Prims<'a>,
    /// The rays.
    pub rays: &'q [Ray],
    /// As many places for answers.
    pub hits: &'q mut [Option<Hit>],
    /// The scene's box.
    pub bounds: &'q Aabb,
    /// Its local origin.
    pub local: &'q [f32; 3],
}

impl Rays<'_, '_> {
    /// Whether they are worth a group: their origins are near to each other, as the scene goes.
    pub fn are_near(&self) -> bool {
        let mut all = Aabb::EMPTY;
        for ray in self.rays {
            // What is NaN counts for nothing.
            all = Aabb { min: least3(ray.origin, all.min), max: most3(ray.origin, all.max) };
        }
        let (origins, scene) = (sub(all.max, all.min), sub(self.bounds.max, self.bounds.min));
        let most = size(scene);
        self.rays.len() >= LEAST && size(origins) * NEAR <= most
    }
}

/// A query to be compiled for each instruction set.
pub(crate) struct Group<'q, 'a, T, const ANY: bool, const LISTS: bool> {
    pub tree: T,
    pub rays: Rays<'q, 'a>,
    pub meter: &'q mut Tally,
}

/// The rays, and what is known of them.
struct State {
    /// Which of those asked for each is.
    number: [u8; RAYS],
    /// So many places are taken.
    len: usize,
    bundle: Bundle,
    best: [Best; RAYS],
    /// The rays one by one, where lanes are not done at once.
    rays: heapless::Vec<Prepared, RAYS>,
    heading: Heading,
}

impl<'a, T: Tree<'a>, const ANY: bool, const LISTS: bool> Work for Group<'_, 'a, T, ANY, LISTS> {
    type Output = Result<(), Stop>;

    #[inline(always)]
    fn run<L8: Lanes<8>, L4: Lanes<4>>(self) -> Self::Output {
        let mut state = State {
            number: [0; RAYS],
            len: 0,
            bundle: Bundle::new(),
            best: [Best::new(0.0); RAYS],
            rays: heapless::Vec::new(),
            heading: Heading::default(),
        };
        let Rays { prims, rays, hits, bounds, local } = self.rays;
        hits.fill(None);
        state.sort(rays);
        let (alive, odd) = state.gather::<L8>(rays, bounds, local);
        if LISTS {
            state.walk_lists::<T, ANY, L8>(&self.tree, prims, alive, self.meter)?;
        } else {
            state.walk::<T, ANY, L8>(&self.tree, prims, alive, self.meter)?;
        }
        for i in each(alive) {
            if let Some(place) = hits.get_mut(usize::from(state.number[i % RAYS])) {
                *place = state.best[i % RAYS].hit();
            }
        }
        for number in each(odd) {
            let (Some(ray), Some(place)) = (rays.get(number), hits.get_mut(number)) else { continue };
            let Some(ray) = Prepared::new(ray, bounds, *local) else { continue };
            let ((at, bounds), mut best) = (self.tree.root(), Best::new(ray.t_max));
            self.tree.alone::<ANY>(at, &bounds, &ray, &mut best, self.meter)?;
            *place = best.hit().map(|hit| Hit { t: hit.t * ray.unit, ..hit });
        }
        Ok(())
    }
}

impl State {
    /// Brings those of the same signs and the same steepest axis next to each other.
    #[inline(always)]
    fn sort(&mut self, rays: &[Ray]) {
        let mut class = [0u8; RAYS];
        let mut starts = [0u8; 25];
        for (class, ray) in class.iter_mut().zip(rays) {
            *class = class_of(ray);
            if let Some(n) = starts.get_mut(usize::from(*class).wrapping_add(1)) {
                *n = n.wrapping_add(1);
            }
        }
        let mut sum = 0u8;
        for n in &mut starts {
            sum = sum.wrapping_add(*n);
            *n = sum;
        }
        for (number, &class) in (0u8..).zip(class.iter().take(rays.len())) {
            if let Some(next) = starts.get_mut(usize::from(class)) {
                self.number[usize::from(*next) % RAYS] = number;
                *next = next.wrapping_add(1);
            }
        }
    }

    /// Prepares the rays. Returns those that make sense, and those that are to be looked at alone.
    #[inline(always)]
    fn gather<L: Lanes<8>>(&mut self, rays: &[Ray], bounds: &Aabb, local: &[f32; 3]) -> (u64, u64) {
        if !L::AT_ONCE {
            return self.gather_one_by_one::<L>(rays, bounds, local);
        }
        let Some(first) = rays.first() else { return (0, 0) };
        let (mut alive, mut odd) = (0, 0);
        let chunks = rays.len().div_ceil(AT_ONCE).min(CHUNKS);
        for (chunk, numbers) in self.number.as_chunks::<AT_ONCE>().0.iter().enumerate().take(chunks) {
            let left = rays.len().saturating_sub(chunk * AT_ONCE);
            let live = if left < AT_ONCE { (1u32 << left).wrapping_sub(1) } else { 255 };
            let eight = numbers.map(|n| rays.get(usize::from(n)).unwrap_or(first));
            let good = self.bundle.set::<L>(chunk, eight, live, bounds, local);
            alive |= u64::from(good) << (chunk * AT_ONCE);
            for lane in each(u64::from(live & !good)) {
                odd |= 1 << (numbers[lane % AT_ONCE] % 64);
            }
        }
        self.len = rays.len();
        self.heading = Heading(self.bundle.survey::<L>(rays.len()));
        for (best, &t) in self.best.iter_mut().zip(self.bundle.t.as_flattened()) {
            *best = Best::new(t);
        }
        (alive, odd)
    }

    /// The same without lanes.
    #[inline(always)]
    fn gather_one_by_one<L: Lanes<8>>(&mut self, rays: &[Ray], bounds: &Aabb, local: &[f32; 3]) -> (u64, u64) {
        let (mut n, mut odd) = (0usize, 0);
        for number in self.number.into_iter().take(rays.len()) {
            let ray = rays.get(usize::from(number)).and_then(|ray| Prepared::new(ray, bounds, *local));
            let Some(ray) = ray.filter(|ray| ray.unit == 1.0) else {
                odd |= 1 << (number % 64);
                continue;
            };
            let _ = self.rays.push(ray);
            self.bundle.put(n, &ray);
            self.best[n % RAYS] = Best::new(ray.t_max);
            self.number[n % RAYS] = number;
            n = n.wrapping_add(1);
        }
        self.len = n;
        self.heading = Heading(self.bundle.survey::<L>(n));
        (u64::MAX.checked_shr(count(RAYS.saturating_sub(n))).unwrap_or(0), odd)
    }

    /// All rays, node by node.
    #[inline(always)]
    fn walk<'a, T: Tree<'a>, const ANY: bool, L: Lanes<8>>(
        &mut self,
        tree: &T,
        prims: &Prims<'a>,
        mut alive: u64,
        meter: &mut Tally,
    ) -> Result<(), Stop> {
        let mut stack = heapless::Vec::<(T::Place, Aabb, u64), { index(2 * MAX_STACK) }>::new();
        let (root, bounds) = tree.root();
        stack.push((root, bounds, alive)).map_err(|_| Stop::Corrupt)?;
        while let Some((at, bounds, waiting)) = stack.pop() {
            let rays = self.bundle.may_meet::<L>(&bounds, waiting & alive);
            if rays == 0 {
                continue;
            }
            if rays.count_ones() <= FEW {
                alive &= !self.alone::<T, ANY>(tree, at, &bounds, rays, meter)?;
                self.bundle.shrink::<L>(self.len);
                continue;
            }
            if tree.costs(at) && !meter.node() {
                return Err(Stop::Fuel);
            }
            let opened = tree.open(at, &bounds, &self.heading, |child, bounds| {
                stack.push((child, bounds, rays)).map_err(|_| Stop::Corrupt)
            })?;
            if let Some(slots) = opened {
                let rays = if self.bundle.is_alike() { self.bundle.met::<L>(&bounds, rays) } else { rays };
                alive &= !self.leaf::<ANY, L>(prims, slots, rays, meter)?;
                self.bundle.shrink::<L>(self.len);
            }
        }
        Ok(())
    }

    /// The same with lists for masks: the lecture's stack of references to rays. A node's rays are a run of the list; those
    /// that meet a child are copied above it, and taken off when the child is done.
    #[inline(always)]
    fn walk_lists<'a, T: Tree<'a>, const ANY: bool, L: Lanes<8>>(
        &mut self,
        tree: &T,
        prims: &Prims<'a>,
        mut alive: u64,
        meter: &mut Tally,
    ) -> Result<(), Stop> {
        let mut stack = heapless::Vec::<(T::Place, Aabb, usize, usize), { index(2 * MAX_STACK) }>::new();
        let mut list = heapless::Vec::<u8, LISTED>::new();
        for i in (0u8..64).filter(|i| alive >> i & 1 == 1) {
            list.push(i).map_err(|_| Stop::Corrupt)?;
        }
        let (root, bounds) = tree.root();
        stack.push((root, bounds, 0, list.len())).map_err(|_| Stop::Corrupt)?;
        while let Some((at, bounds, first, last)) = stack.pop() {
            list.truncate(last);
            let mut rays = 0;
            for place in first..last {
                let i = list.get(place).copied().unwrap_or(0) % 64;
                if alive >> i & 1 == 1 && self.bundle.meets_box(usize::from(i), &bounds) {
                    list.push(i).map_err(|_| Stop::Corrupt)?;
                    rays |= 1 << i;
                }
            }
            if rays == 0 {
                continue;
            }
            if list.len().saturating_sub(last) <= index(FEW) {
                alive &= !self.alone::<T, ANY>(tree, at, &bounds, rays, meter)?;
                continue;
            }
            if tree.costs(at) && !meter.node() {
                return Err(Stop::Fuel);
            }
            let (first, last) = (last, list.len());
            let opened = tree.open(at, &bounds, &self.heading, |child, bounds| {
                stack.push((child, bounds, first, last)).map_err(|_| Stop::Corrupt)
            })?;
            if let Some(slots) = opened {
                alive &= !self.leaf::<ANY, L>(prims, slots, rays, meter)?;
            }
        }
        Ok(())
    }

    /// Each of some rays by itself, from a place on. Returns those that are done: with `ANY`, that have hit.
    #[inline(always)]
    fn alone<'a, T: Tree<'a>, const ANY: bool>(
        &mut self,
        tree: &T,
        at: T::Place,
        bounds: &Aabb,
        rays: u64,
        meter: &mut Tally,
    ) -> Result<u64, Stop> {
        let mut done = 0;
        for i in each(rays) {
            let ray = self.rays.get(i).copied().unwrap_or_else(|| self.bundle.ray(i));
            let best = &mut self.best[i % RAYS];
            if tree.alone::<ANY>(at, bounds, &ray, best, meter)? {
                done |= 1 << i;
            }
            self.bundle.set_t(i, best.t);
        }
        Ok(done)
    }
}

/// The lanes of a chunk.
#[inline(always)]
#[allow(clippy::as_conversions, clippy::cast_possible_truncation)]
const fn low_byte(rays: u64) -> u32 {
    (rays & 255) as u32
}

/// Signs and steepest axis of a direction, from 0 to 23.
#[inline(always)]
fn class_of(ray: &Ray) -> u8 {
    let [x, y, z] = ray.dir;
    let signs = u8::from(x < 0.0) | u8::from(y < 0.0) << 1 | u8::from(z < 0.0) << 2;
    let (x, y, z) = (x.abs(), y.abs(), z.abs());
    let steepest = if z > x && z > y { 2 } else { u8::from(y > x) };
    signs.wrapping_mul(3).wrapping_add(steepest)
}

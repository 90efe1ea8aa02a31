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
mod lists;
mod loops;
mod rays;
mod tree;

pub use rays::Rays;
pub use tree::{Heading, Slots, Tree};

use super::lanes::{Lanes, Work};
use super::{Best, Meter, Stop, Tally};
use crate::blob::MAX_STACK;
use crate::blob::prims::Prims;
use crate::geom::place::Place;
use crate::geom::ray::Prepared;
use crate::geom::vec::sub;
use crate::geom::{Aabb, Hit, Ray};
use crate::num::index;
use bundle::Bundle;
use rays::origins;

/// Most rays of a group.
pub const RAYS: usize = 64;
/// Rays that are tested at a time.
const AT_ONCE: usize = 8;
/// So often in a group.
const CHUNKS: usize = RAYS / AT_ONCE;
/// With so many rays left, each goes on alone.
const FEW: u32 = 2;

/// Bytes of stack that a group takes, but for the walk of its tree.
pub const SCRATCH: usize = size_of::<State>();
const _: () = assert!(SCRATCH <= 17_000);

/// The numbers of the rays in a mask.
#[inline(always)]
fn each(mut rays: u64) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let first = rays.trailing_zeros();
        rays &= rays.wrapping_sub(1);
        (first < 64).then_some(index(first))
    })
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
            heading: Heading::default(),
        };
        let Rays { prims, rays, hits, place } = self.rays;
        hits.fill(None);
        state.sort(rays);
        let (alive, odd) = state.gather::<L8>(rays, place);
        if LISTS {
            state.walk_lists::<T, ANY, L8>(&self.tree, prims, alive, self.meter)?;
        } else {
            state.walk::<T, ANY, L8>(&self.tree, prims, alive, self.meter)?;
        }
        for i in each(alive) {
            if let Some(answer) = hits.get_mut(usize::from(state.number[i % RAYS])) {
                *answer = state.best[i % RAYS].hit();
            }
        }
        for number in each(odd) {
            let (Some(ray), Some(answer)) = (rays.get(number), hits.get_mut(number)) else { continue };
            let Some(ray) = Prepared::new(ray, place) else { continue };
            let ((at, bounds), mut best) = (self.tree.root(), Best::new(ray.t_max));
            self.tree.alone::<ANY>(at, &bounds, &ray, &mut best, self.meter)?;
            *answer = best.hit().map(|hit| Hit { t: hit.t * ray.unit, ..hit });
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
    fn gather<L: Lanes<8>>(&mut self, rays: &[Ray], place: &Place<'_>) -> (u64, u64) {
        let Some(first) = rays.first() else { return (0, 0) };
        let (mut alive, mut odd) = (0, 0);
        let chunks = rays.len().div_ceil(AT_ONCE).min(CHUNKS);
        for (chunk, numbers) in self.number.as_chunks::<AT_ONCE>().0.iter().enumerate().take(chunks) {
            let left = rays.len().saturating_sub(chunk * AT_ONCE);
            let live = if left < AT_ONCE { (1u32 << left).wrapping_sub(1) } else { 255 };
            let eight = numbers.map(|n| rays.get(usize::from(n)).unwrap_or(first));
            let good = if L::AT_ONCE {
                self.bundle.set::<L>(chunk, eight, live, place)
            } else {
                self.bundle.set_in_loops(chunk, eight, live, place)
            };
            alive |= u64::from(good) << (chunk * AT_ONCE);
            for lane in each(u64::from(live & !good)) {
                odd |= 1 << (numbers[lane % AT_ONCE] % 64);
            }
        }
        self.len = rays.len();
        let all = origins(rays);
        self.bundle.origins = Aabb { min: sub(all.min, place.local), max: sub(all.max, place.local) };
        self.heading = Heading(self.bundle.survey::<L>(rays.len()));
        for (best, &t) in self.best.iter_mut().zip(self.bundle.t.as_flattened()) {
            *best = Best::new(t);
        }
        (alive, odd)
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
            let ray = self.bundle.ray(i);
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

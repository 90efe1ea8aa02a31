//! A query: which walk suits its ray, and where its answer goes.
use super::many::Answer;
use super::walk::{Rest, walk};
use super::{In, Node, View, Wide};
use crate::blob::prims::Prims;
use crate::geom::Hit;
use crate::geom::place::Place;
use crate::geom::ray::Prepared;
use crate::walk::lanes::{Lanes, Work};
use crate::walk::prepare::{Entered, Given, prepare};
use crate::walk::{Best, Meter, Stop};

/// A query, to be compiled for each instruction set.
pub(crate) struct Query<'q, 'a, M, const ANY: bool, const W: usize> {
    pub view: &'q View<'a, W>,
    pub prims: &'q Prims<'a>,
    pub ray: Given,
    pub place: &'q Place<'q>,
    pub meter: M,
}

impl<M: Meter, const ANY: bool, const W: usize> Work for Query<'_, '_, M, ANY, W>
where
    Node<W>: Wide<W>,
{
    type Output = Result<Option<Hit>, Stop>;

    #[inline(always)]
    fn run<L8: Lanes<8>, L4: Lanes<4>>(self) -> Self::Output {
        match self.enter::<L8, L4>() {
            Entry::Quick(ray) => Ok(self.quick::<L8, L4>(&ray)?.hit()),
            Entry::Miss => Ok(None),
            // There it is not the rare way.
            Entry::Whole if !In::<W, L8, L4>::QUICK => self.whole::<false, L8, L4>(),
            Entry::Whole => L8::call(Whole::<_, ANY, W, false>(self)),
            Entry::Mixed => L8::call(Whole::<_, ANY, W, true>(self)),
        }
    }
}

/// How a query goes on.
enum Entry {
    /// With the quick box test.
    Quick(Prepared),
    /// The ray misses the scene's box.
    Miss,
    /// The quick box test is not for this ray, or not of this machine.
    Whole,
    /// Not all are triangles in blocks.
    Mixed,
}

impl<M: Meter, const ANY: bool, const W: usize> Query<'_, '_, M, ANY, W>
where
    Node<W>: Wide<W>,
{
    #[inline(always)]
    fn enter<L8: Lanes<8>, L4: Lanes<4>>(&self) -> Entry {
        if !In::<W, L8, L4>::QUICK || !self.ray.is_quick(self.place) {
            return Entry::Whole;
        }
        match Entered::<L4>::fine(&self.ray, self.place) {
            None => Entry::Miss,
            Some(_) if self.prims.blocks.is_empty() => Entry::Mixed,
            Some(entered) => Entry::Quick(entered.prepared()),
        }
    }

    /// The best hit in blocks.
    #[inline(always)]
    fn quick<L8: Lanes<8>, L4: Lanes<4>>(self, ray: &Prepared) -> Result<Best, Stop> {
        let Self { view, prims, ray: given, place, mut meter } = self;
        let (mut best, mut rest) = (Best::new(ray.t_max), Rest::new());
        walk::<W, ANY, true, false, In<W, L8, L4>, L4>(
            view,
            prims,
            (ray, (&given, place)),
            &mut rest,
            &mut best,
            &mut meter,
        )?;
        Ok(best)
    }

    /// The hit among primitives of any kind. Their tests point to the ray, so all of it is kept at hand.
    #[inline(always)]
    fn whole<const QUICK: bool, L8: Lanes<8>, L4: Lanes<4>>(self) -> Result<Option<Hit>, Stop> {
        let Self { view, prims, ray, place, mut meter } = self;
        let Some(ray) = prepare::<L4>(&ray, place) else { return Ok(None) };
        let (mut best, mut rest) = (Best::new(ray.t_max), Rest::new());
        walk::<W, ANY, QUICK, true, In<W, L8, L4>, L4>(view, prims, (&ray, ()), &mut rest, &mut best, &mut meter)?;
        Ok(best.hit().map(|hit| Hit { t: hit.t * ray.unit, ..hit }))
    }

    /// Puts the answer where it belongs: handed back it would be moved as a whole right after it was written number by number,
    /// and waited for.
    #[inline(always)]
    pub(super) fn put<A: Answer, L8: Lanes<8>, L4: Lanes<4>>(self, answer: &mut A) {
        *answer = A::new(None);
        let hit = match self.enter::<L8, L4>() {
            Entry::Quick(ray) => {
                if let Ok(best) = self.quick::<L8, L4>(&ray) {
                    *answer = A::new(best.hit());
                }
                return;
            }
            Entry::Miss => return,
            Entry::Whole if !In::<W, L8, L4>::QUICK => self.whole::<false, L8, L4>(),
            Entry::Whole => L8::call(Whole::<_, ANY, W, false>(self)),
            Entry::Mixed => L8::call(Whole::<_, ANY, W, true>(self)),
        };
        *answer = A::new(hit.unwrap_or(None));
    }
}

/// A query out of line.
struct Whole<'q, 'a, M, const ANY: bool, const W: usize, const QUICK: bool>(Query<'q, 'a, M, ANY, W>);

impl<M: Meter, const ANY: bool, const W: usize, const QUICK: bool> Work for Whole<'_, '_, M, ANY, W, QUICK>
where
    Node<W>: Wide<W>,
{
    type Output = Result<Option<Hit>, Stop>;

    #[inline(always)]
    fn run<L8: Lanes<8>, L4: Lanes<4>>(self) -> Self::Output {
        self.0.whole::<QUICK, L8, L4>()
    }
}

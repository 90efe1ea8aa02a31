//! Many rays a call: how they are answered.
use super::group::{AT_ONCE, Group, RAYS};
use super::packet::Packets;
use super::stream::{Crowd, Stream};
use super::team::Team;
use super::{Node, Query, View, Wide};
use crate::blob::prims::Prims;
use crate::geom::place::Place;
use crate::geom::vec::{size, sub};
use crate::geom::{Hit, Ray};
use crate::num::{count, index};
use crate::walk::heading::{Heading, PacketSize};
use crate::walk::lanes::{Lanes, Work};
use crate::walk::prepare::Given;
use crate::walk::{Fuel, Isa, Meter, Tally};

/// Of eight rays so many must have one heading.
const MOST: usize = 6;
/// So many rays make a stream.
const STREAM: u32 = 8;
/// So many make the first of a call, for which the scratch has to be cleared.
const FIRST_STREAM: u32 = 32;
/// The longest spell without a try of groups, in groups.
const SPELL: u32 = 16;
/// From a ray to one an eighth of the group on, so many steps of seven may be far.
const FAR_STEPS: usize = 1;
/// A step in place is far from this share of the scene on, and one in direction from this share of its largest part.
const FAR: f32 = 0.04;

/// Bytes of stack that a call for many rays takes at most beyond those of a query: a stream's and a group's.
pub const SCRATCH: usize = size_of::<Option<Crowd>>() + size_of::<Option<Team>>();

/// What is given for a ray.
pub(crate) trait Answer {
    /// From the best hit.
    fn new(hit: Option<Hit>) -> Self;
}

impl Answer for Option<Hit> {
    #[inline(always)]
    fn new(hit: Option<Hit>) -> Self {
        hit
    }
}

impl Answer for bool {
    #[inline(always)]
    fn new(hit: Option<Hit>) -> Self {
        hit.is_some()
    }
}

/// What queries are paid from: each by itself, or all counted together.
pub(crate) trait Purse {
    /// What one of them, or those of one heading, may spend.
    type Open<'m>: Meter
    where
        Self: 'm;

    /// With so much fuel.
    fn open(&mut self, fuel: u32) -> Self::Open<'_>;
}

/// Nobody counts.
pub(crate) struct Uncounted;

impl Purse for Uncounted {
    // By value: what nobody looks at afterwards can stay in a register.
    type Open<'m> = Fuel;

    #[inline(always)]
    fn open(&mut self, fuel: u32) -> Fuel {
        Fuel(fuel)
    }
}

impl Purse for Tally {
    type Open<'m> = &'m mut Self;

    #[inline(always)]
    fn open(&mut self, fuel: u32) -> &mut Self {
        self.fuel = Fuel(fuel);
        self
    }
}

/// A query whose answer goes to its place within the walk.
struct Placed<'r, 'q, 'a, A, M, const ANY: bool, const W: usize> {
    query: Query<'q, 'a, M, ANY, W>,
    answer: &'r mut A,
}

impl<A: Answer, M: Meter, const ANY: bool, const W: usize> Work for Placed<'_, '_, '_, A, M, ANY, W>
where
    Node<W>: Wide<W>,
{
    type Output = ();

    #[inline(always)]
    fn run<L8: Lanes<8>, L4: Lanes<4>>(self) {
        self.query.put::<A, L8, L4>(self.answer);
    }
}

/// Where and how rays are answered.
#[derive(Clone, Copy)]
pub(crate) struct Many<'q, 'a, const W: usize> {
    pub view: &'q View<'a, W>,
    pub prims: &'q Prims<'a>,
    pub place: &'q Place<'q>,
    pub fuel: u32,
    pub isa: Isa,
}

impl<const W: usize> Many<'_, '_, W>
where
    Node<W>: Wide<W>,
{
    /// Answers in groups or streams or ray by ray, as it suits the rays. `answers` are as many as `rays`.
    // Each form is compiled by itself: in one function with groups, rays alone were 8 % slower.
    #[allow(clippy::unnecessary_lazy_evaluations)] // a crowd is some 25 KiB, to be made once
    pub(crate) fn groups<A: Answer, P: Purse, const ANY: bool>(self, rays: &[Ray], answers: &mut [A], purse: &mut P) {
        // The scratch of streams and of groups, which a call without them need not set to nothing.
        let (mut crowd, mut team) = (None, None);
        let (mut pause, mut spell) = (0u32, 1u32);
        for (rays, answers) in rays.chunks(RAYS).zip(answers.chunks_mut(RAYS)) {
            let mut left = u64::MAX >> (RAYS - rays.len().clamp(1, RAYS));
            // Where a group was of no use the next are not tried for a spell, each four times as long as that before.
            pause = pause.saturating_sub(1);
            if pause == 0 {
                left = self.group::<A, P, ANY>(rays, answers, &mut team, purse);
                spell = if left.count_ones() * 2 > count(rays.len()) { (spell * 4).min(SPELL) } else { 1 };
                pause = spell;
            }
            let least = if crowd.is_some() { STREAM } else { FIRST_STREAM };
            if left.count_ones() >= least && !self.prims.blocks.is_empty() {
                let crowd = crowd.get_or_insert_with(|| Crowd::EMPTY);
                let (many, which) = (self, left);
                left = self.isa.run(Stream::<_, _, ANY, W> { many, rays, answers, which, crowd, purse });
            }
            self.alone::<A, P, ANY>(left, rays, answers, purse);
        }
    }

    /// Tries up to 64 rays as a group. Returns those that are not answered.
    #[inline(always)]
    fn group<A: Answer, P: Purse, const ANY: bool>(
        self,
        rays: &[Ray],
        answers: &mut [A],
        team: &mut Option<Team>,
        purse: &mut P,
    ) -> u64 {
        if self.prims.blocks.is_empty() {
            return u64::MAX >> (RAYS - rays.len().clamp(1, RAYS));
        }
        self.isa.run(Group::<_, _, ANY, W> { many: self, rays, answers, team, purse })
    }

    /// Answers in packets of a given size, ray by ray where headings differ. `answers` are as many as `rays`.
    pub(crate) fn packets<A: Answer, const ANY: bool>(self, of: PacketSize, rays: &[Ray], answers: &mut [A]) {
        for (rays, answers) in rays.chunks(of.rays()).zip(answers.chunks_mut(of.rays())) {
            let mut alone = u64::MAX;
            if !self.prims.blocks.is_empty() {
                alone = self.isa.run(Packets::<_, ANY, W> { many: self, of, rays, answers });
            }
            self.alone::<A, _, ANY>(alone, rays, answers, &mut Uncounted);
        }
    }

    /// Some of up to 64 rays, one after another.
    #[inline(always)]
    fn alone<A: Answer, P: Purse, const ANY: bool>(
        self,
        mut which: u64,
        rays: &[Ray],
        answers: &mut [A],
        purse: &mut P,
    ) {
        let Self { view, prims, place, fuel, isa } = self;
        loop {
            let i = index(which.trailing_zeros());
            let (Some(ray), Some(answer)) = (rays.get(i), answers.get_mut(i)) else { return };
            which &= which - 1;
            let query = Query::<_, ANY, W> { view, prims, ray: Given::new(ray), place, meter: purse.open(fuel) };
            isa.run(Placed { query, answer });
        }
    }

    /// The heading that most rays have, as far as eight of them tell; none if those differ, or if rays are far apart.
    #[inline(always)]
    pub(super) fn shared<L: Lanes<8>>(self, rays: &[Ray]) -> Option<Heading> {
        let last = rays.len().saturating_sub(1);
        if last < AT_ONCE {
            return None;
        }
        let (mut from, mut to) = ([rays.first()?; AT_ONCE], [rays.last()?; AT_ONCE]);
        for i in 0..AT_ONCE {
            from[i] = rays.get(i * last / (AT_ONCE - 1))?;
            to[i.saturating_sub(1)] = from[i];
        }
        let (first, second) = (Heading::new(from[0]), Heading::new(from[4]));
        let common = if second == Heading::new(from[3]) { second } else { first }?;
        let (origin, dir, ..) = Ray::columns::<AT_ONCE, L>(from);
        if index(common.is::<AT_ONCE, L>(&dir).count_ones()) < MOST {
            return None;
        }
        let (to_origin, to_dir, ..) = Ray::columns::<AT_ONCE, L>(to);
        let bounds = self.place.bounds;
        let far = L::splat(size(sub(bounds.max, bounds.min)) * FAR);
        let (a, b) = (largest::<L>(&dir), largest::<L>(&to_dir));
        let (mut step, mut turn) = (dir, dir);
        for k in 0..3 {
            step[k] = origin[k] - to_origin[k];
            turn[k] = dir[k] * b - to_dir[k] * a;
        }
        let is_far = far.lt(largest::<L>(&step)) | (a * b * L::splat(FAR)).lt(largest::<L>(&turn));
        (index(is_far.count_ones()) <= FAR_STEPS).then_some(common)
    }
}

/// The largest size among the components.
#[inline(always)]
fn largest<L: Lanes<8>>(v: &[L; 3]) -> L {
    v[2].abs().most(v[1].abs().most(v[0].abs()))
}

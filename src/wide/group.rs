//! Sixty-four rays at once.
//!
//! Where rays are alike, what is fetched and decided is so for all of them. Eight stand side by side in a packet, and up to
//! eight packets walk together. A child's box is tested in interval arithmetic: first all children of a node against the
//! whole group, then each that is left against all packets, a packet in each lane. The distance of a plane from any of some
//! rays is no less than that from the extreme origin times the extreme inverse (Reshetov, Soupikov and Hurley,
//! "Multi-Level Ray Tracing Algorithm", ACM TOG 24(3), 2005), and since every step rounds monotonically, an interval never
//! leaves out what a ray of it meets. A triangle's own box goes the same way before the rays of a packet are tested, eight
//! at a time: a hit is one only if the ray meets that box, too (`admitted` in [`crate::geom::triangle`]).
//!
//! Why an interval may be trusted, on an axis of positive directions (the other is its mirror image): a ray's own distance
//! of a nearer plane `p` is `(p - o) * inv`, rounded twice. The interval has `x = p - o'` with `o' >= o`, so `x` is no
//! greater than the ray's difference; and `x * inv` lies between `x * small` and `x * large`, both rounded, because
//! multiplication is monotone. So the lesser of the two is no greater than the ray's distance. NaN comes of `0 * large`
//! alone, where a ray runs along the plane: then the extreme of the two products is NaN, too, and constrains nothing, as
//! for the ray.
use super::many::{Answer, Many, Purse};
use super::team::Team;
use super::{In, Node, STACK, View, Wide};
use crate::blob::block::{Block, LANES};
use crate::blob::prims::Prims;
use crate::bvh::tree::root;
use crate::bvh::walk::Rows;
use crate::bvh::{Child, Face};
use crate::geom::Ray;
use crate::num::index;
use crate::walk::heading::Heading;
use crate::walk::lanes::{Lanes, Work};
use crate::walk::packet::Boxes;
use crate::walk::{Meter, Stop};

/// Rays of a group.
pub const RAYS: usize = 64;
/// Rays of a packet.
pub(super) const AT_ONCE: usize = 8;
/// Packets of a group.
pub(super) const PACKETS: usize = RAYS / AT_ONCE;
/// Of one heading there must be so many to walk together.
const LEAST: u32 = 8;

/// What a group may spend before its rays go on alone, in triangle tests of eight rays: about what these would take. Rays that
/// ask for any hit end sooner alone, and their origins may lie apart though they are going the same way.
const PATIENCE: u32 = 2400;
const PATIENCE_ANY: u32 = 600;
/// What a node counts.
const NODE_WORK: u32 = 6;

/// A query of up to 64 rays, to be compiled for each instruction set.
pub(super) struct Group<'q, 'a, 'r, A, P, const ANY: bool, const W: usize> {
    pub many: Many<'q, 'a, W>,
    pub rays: &'r [Ray],
    pub answers: &'r mut [A],
    pub team: &'r mut Option<Team>,
    pub purse: &'r mut P,
}

impl<A: Answer, P: Purse, const ANY: bool, const W: usize> Work for Group<'_, '_, '_, A, P, ANY, W>
where
    Node<W>: Wide<W>,
{
    /// The rays that are not answered.
    type Output = u64;

    #[inline(always)]
    fn run<L8: Lanes<8>, L4: Lanes<4>>(self) -> u64 {
        let Self { many, rays, answers, team, purse } = self;
        let all = u64::MAX >> (RAYS - rays.len().clamp(1, RAYS));
        let Some(mut heading) = many.shared::<L8>(rays) else { return all };
        let team = team.get_or_insert_with(|| Team::EMPTY);
        // All are tried together, and if they are not of one heading, those of each.
        let (mut mine, mut left, mut alone) = (all, all, 0);
        loop {
            if team.set::<L8>(rays, mine, heading, many.place) {
                // Also where an unchecked blob contradicts itself: rays that do not come there get an answer.
                let meter = purse.open(many.fuel);
                let ok = team.walk::<ANY, W, L8, L4, In<W, L8, L4>>(many.view, many.prims, heading, meter).is_ok();
                if ok && mine == all {
                    for (packet, answers) in team.packets.iter().zip(answers.chunks_mut(AT_ONCE)) {
                        answers.iter_mut().enumerate().for_each(|(lane, answer)| *answer = A::new(packet.hit(lane)));
                    }
                    return 0;
                }
                let mut rest = mine;
                for packet in &team.packets {
                    for lane in 0..AT_ONCE {
                        let i = index(rest.trailing_zeros());
                        let Some(answer) = answers.get_mut(i) else { break };
                        let hit = packet.hit(lane);
                        // A hit is enough for any.
                        alone |= u64::from(!(ok || ANY && hit.is_some())) << i;
                        *answer = A::new(hit);
                        rest &= rest - 1;
                    }
                }
                left &= !mine;
            } else if mine != all {
                alone |= mine;
                left &= !mine;
            }
            loop {
                let Some(ray) = rays.get(index(left.trailing_zeros())) else { return alone };
                let next = Heading::new(ray);
                mine = if next.is_some() { of_heading(rays, next) & left } else { left & left.wrapping_neg() };
                match next {
                    Some(next) if mine.count_ones() >= LEAST && mine != all => {
                        heading = next;
                        break;
                    }
                    _ => (alone, left) = (alone | mine, left & !mine),
                }
            }
        }
    }
}

/// The rays that have a heading.
fn of_heading(rays: &[Ray], heading: Option<Heading>) -> u64 {
    rays.iter().rev().fold(0, |all, ray| all << 1 | u64::from(Heading::new(ray) == heading))
}

/// A child that waits: where its box begins at the earliest, and the packets that may meet it.
type Waiting = (Child, f32, u32);

impl Team {
    /// All rays, node by node.
    #[inline(always)]
    fn walk<const ANY: bool, const W: usize, L: Lanes<8>, L4: Lanes<4>, LW: Lanes<W>>(
        &mut self,
        view: &View<'_, W>,
        prims: &Prims<'_>,
        heading: Heading,
        mut meter: impl Meter,
    ) -> Result<(), Stop> {
        let rows = Rows::of(heading.negative);
        let range = self.range::<L>(heading);
        let mut stack = heapless::Vec::<Waiting, { index(STACK) }>::new();
        let (mut at, mut packets) = (root(view.nodes, prims.len), self.used);
        let mut farthest = L::load(&self.t).greatest();
        let mut patience = if ANY { PATIENCE_ANY } else { PATIENCE };
        loop {
            if at.is_node() {
                if !meter.node() {
                    return Err(Stop::Fuel);
                }
                patience = patience.checked_sub(NODE_WORK).ok_or(Stop::Fuel)?;
                let node = view.nodes.get(index(at.number())).ok_or(Stop::Corrupt)?;
                let one = packets.is_power_of_two();
                let row = |face: Face| &node.planes[face.at()];
                let (first, last) = (rows.near.map(row), rows.far.map(row));
                let (mut maybe, near) = if one {
                    let packet = packets.trailing_zeros();
                    self.one(packet).meet::<W, LW>(first, last, self.t[index(packet) % PACKETS])
                } else {
                    range.meet::<W, LW>(first, last, farthest)
                };
                let near = near.store();
                let mut sorted = 0usize;
                while maybe != 0 {
                    let lane = index(maybe.trailing_zeros()) % W;
                    maybe &= maybe - 1;
                    let plane = |face: Face| node.planes[face.at()][lane];
                    let met =
                        if one { packets } else { packets & self.meet::<L>(rows.near.map(plane), rows.far.map(plane)) };
                    if met == 0 {
                        continue;
                    }
                    stack.push((node.child[lane], near[lane], met)).map_err(|_| Stop::Corrupt)?;
                    let mut place = stack.len().saturating_sub(1);
                    for _ in 0..sorted {
                        match stack.get_mut(place.wrapping_sub(1)..=place) {
                            Some([below, above]) if below.1 < above.1 => core::mem::swap(below, above),
                            _ => break,
                        }
                        place = place.wrapping_sub(1);
                    }
                    sorted = sorted.saturating_add(1);
                }
            } else {
                if !meter.prims(at.len()) {
                    return Err(Stop::Fuel);
                }
                let work = at.len().wrapping_mul(packets.count_ones());
                patience = patience.checked_sub(work).ok_or(Stop::Fuel)?;
                let first = index(at.number());
                let blocks = prims.blocks.get(first..).and_then(|b| b.get(..index(at.len().div_ceil(LANES))));
                if self.leaf::<ANY, L, L4>(heading, blocks.ok_or(Stop::Corrupt)?, at.len(), packets) {
                    farthest = L::load(&self.t).greatest();
                }
            }
            (at, packets) = loop {
                let Some((child, near, met)) = stack.pop() else { return Ok(()) };
                let met = met & L::splat(near).le(L::load(&self.t));
                if met != 0 {
                    break (child, met);
                }
            };
        }
    }

    /// Some packets against a leaf. Returns whether any ray hit.
    #[inline(always)]
    fn leaf<const ANY: bool, L: Lanes<8>, L4: Lanes<4>>(
        &mut self,
        heading: Heading,
        blocks: &[Block],
        mut left: u32,
        packets: u32,
    ) -> bool {
        let mut any = false;
        let (one, alone) = (packets.is_power_of_two(), index(packets.trailing_zeros()) % PACKETS);
        for block in blocks {
            let boxes = Boxes::new::<L4>(heading, block);
            let here = u32::MAX >> (32 - left.clamp(1, LANES));
            left = left.saturating_sub(LANES);
            // One packet meets four boxes at a time, more meet one.
            let mut lanes = here;
            if one {
                let (first, last) = (boxes.first.each_ref(), boxes.last.each_ref());
                lanes &= self.one(packets.trailing_zeros()).meet::<4, L4>(first, last, self.t[alone]).0;
            }
            while lanes != 0 {
                let lane = index(lanes.trailing_zeros()) % 4;
                lanes &= lanes - 1;
                let plane = |row: [f32; 4]| row[lane];
                let mut met =
                    if one { packets } else { packets & self.meet::<L>(boxes.first.map(plane), boxes.last.map(plane)) };
                while met != 0 {
                    let c = index(met.trailing_zeros()) % PACKETS;
                    met &= met - 1;
                    let packet = &mut self.packets[c];
                    if packet.test::<ANY, L>(heading, block, lane, &boxes) != 0 {
                        self.t[c] = packet.farthest::<L>();
                        any = true;
                    }
                }
            }
        }
        any
    }
}

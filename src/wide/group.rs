//! Sixty-four rays at once.
//!
//! Where rays are alike, what is fetched and decided is so for all of them. Eight stand side by side in a packet, and up to
//! eight packets walk together. A child's box is tested in interval arithmetic: first all children of a node against the
//! whole group, then each that is left against all packets, a packet in each lane. The distance of a plane from any of some
//! rays is no less than that from the extreme origin times the extreme inverse (Reshetov, Soupikov and Hurley,
//! "Multi-Level Ray Tracing Algorithm", ACM TOG 24(3), 2005), and since every step rounds monotonically, an interval never
//! leaves out what a ray of it meets. Rays themselves are tested against triangles alone, eight at a time.
//!
//! Why an interval may be trusted, on an axis of positive directions (the other is its mirror image): a ray's own distance
//! of a nearer plane `p` is `(p - o) * inv`, rounded twice. The interval has `x = p - o'` with `o' >= o`, so `x` is no
//! greater than the ray's difference; and `x * inv` lies between `x * small` and `x * large`, both rounded, because
//! multiplication is monotone. So the lesser of the two is no greater than the ray's distance. NaN comes of `0 * large`
//! alone, where a ray runs along the plane: then the extreme of the two products is NaN, too, and constrains nothing, as
//! for the ray.
use super::many::{Answer, Many, Purse};
use super::{In, Node, STACK, View, Wide};
use crate::blob::block::{Block, LANES};
use crate::blob::prims::Prims;
use crate::bvh::Child;
use crate::bvh::tree::root;
use crate::bvh::walk::Rows;
use crate::geom::Ray;
use crate::geom::place::Place;
use crate::num::{count, index};
use crate::walk::heading::Heading;
use crate::walk::lanes::{Lanes, Work};
use crate::walk::packet::{Packet, Range};
use crate::walk::{Meter, Stop};

/// Rays of a group.
pub const RAYS: usize = 64;
/// Rays of a packet.
pub(super) const AT_ONCE: usize = 8;
/// Packets of a group.
const PACKETS: usize = RAYS / AT_ONCE;
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
    /// The heading that most of them seem to have.
    pub heading: Heading,
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
        let Self { many, rays, answers, mut heading, purse } = self;
        let all = u64::MAX >> (RAYS - rays.len().clamp(1, RAYS));
        // All are tried together, and if they are not of one heading, those of each.
        let (mut mine, mut left, mut alone) = (all, all, 0);
        loop {
            let mut team = Team::EMPTY;
            if team.set::<L8>(rays, mine, heading, many.place) {
                // Also where an unchecked blob contradicts itself: rays that do not come there get an answer.
                let meter = purse.open(many.fuel);
                let ok = team.walk::<ANY, W, L8, In<W, L8, L4>>(many.view, many.prims, heading, meter).is_ok();
                let mut slot = 0usize;
                for (i, answer) in answers.iter_mut().enumerate() {
                    if mine >> i & 1 == 1 {
                        let hit = team.packets[slot / AT_ONCE % PACKETS].hit(slot % AT_ONCE);
                        // A hit is enough for any.
                        if !(ok || ANY && hit.is_some()) {
                            alone |= 1 << i;
                        }
                        *answer = A::new(hit);
                        slot = slot.wrapping_add(1);
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

/// A number of each packet.
type Each = [f32; PACKETS];

/// Packets that walk together.
#[cfg_attr(target_arch = "x86_64", repr(align(32)))]
pub(super) struct Team {
    packets: [Packet<AT_ONCE>; PACKETS],
    /// Which packets there are.
    used: u32,
    /// Their extremes.
    near_origin: [Each; 3],
    far_origin: [Each; 3],
    small: [Each; 3],
    large: [Each; 3],
    t_min: Each,
    /// The farthest that any ray of each still has to look.
    t: Each,
}

/// A child that waits: where its box begins at the earliest, and the packets that may meet it.
type Waiting = (Child, f32, u32);

impl Team {
    const EMPTY: Self = {
        let zero = [0.0; PACKETS];
        Self {
            packets: [Packet::EMPTY; PACKETS],
            used: 0,
            near_origin: [zero; 3],
            far_origin: [zero; 3],
            small: [zero; 3],
            large: [zero; 3],
            t_min: zero,
            t: [f32::NEG_INFINITY; PACKETS],
        }
    };

    /// Takes some of the rays. Returns whether all have the heading.
    #[inline(always)]
    fn set<L: Lanes<8>>(&mut self, rays: &[Ray], mine: u64, heading: Heading, place: &Place<'_>) -> bool {
        let rays_left = index(mine.count_ones());
        let in_row = mine & mine.wrapping_add(1) == 0;
        let (mut good, mut mine) = (true, mine);
        for (c, packet) in self.packets.iter_mut().enumerate().take(rays_left.div_ceil(AT_ONCE)) {
            let live = rays_left.saturating_sub(c * AT_ONCE).clamp(1, AT_ONCE);
            let given = rays.get(c * AT_ONCE..).and_then(|rays| rays.first_chunk::<AT_ONCE>());
            let mut picked = [Ray { origin: [0.0; 3], dir: [0.0; 3], t_min: 0.0, t_max: 0.0 }; AT_ONCE];
            let eight = match given {
                Some(eight) if in_row && live == AT_ONCE => {
                    mine &= u64::MAX.checked_shl(count((c + 1) * AT_ONCE)).unwrap_or(0);
                    eight
                }
                _ => {
                    // Lanes that are left over repeat the last ray: an interval is then no wider for them.
                    for lane in &mut picked {
                        *lane = rays.get(index(mine.trailing_zeros())).copied().unwrap_or(*lane);
                        let rest = mine & mine.wrapping_sub(1);
                        mine = if rest == 0 { mine } else { rest };
                    }
                    &picked
                }
            };
            let own = packet.set::<L>(eight, u32::MAX >> (32 - live), heading, place);
            good &= own & 255 == 255;
            let c = c % PACKETS;
            let range = packet.range::<L>(heading);
            for k in 0..3 {
                self.near_origin[k][c] = range.near_origin[k];
                self.far_origin[k][c] = range.far_origin[k];
                self.small[k][c] = range.small[k];
                self.large[k][c] = range.large[k];
            }
            self.t_min[c] = range.t_min;
            self.t[c] = packet.farthest::<L>();
            self.used |= 1 << c;
        }
        good
    }

    /// The extremes of all packets.
    #[inline(always)]
    fn range(&self, heading: Heading) -> Range {
        let used = |c: usize| self.used >> c & 1 == 1;
        let end = |row: &Each, greatest: bool| {
            let all = row.iter().enumerate().filter(|(c, _)| used(*c)).map(|(_, &x)| x);
            all.reduce(|a, b| if (a > b) == greatest { a } else { b }).unwrap_or(0.0)
        };
        let mut range = Range { t_min: end(&self.t_min, false), ..Range::EMPTY };
        for k in 0..3 {
            let negative = heading.negative[k];
            range.near_origin[k] = end(&self.near_origin[k], !negative);
            range.far_origin[k] = end(&self.far_origin[k], negative);
            range.small[k] = end(&self.small[k], negative);
            range.large[k] = end(&self.large[k], !negative);
        }
        range
    }

    /// The extremes of one packet.
    #[inline(always)]
    fn one(&self, packet: u32) -> Range {
        let c = index(packet) % PACKETS;
        let row = |rows: &[Each; 3]| [rows[0][c], rows[1][c], rows[2][c]];
        Range {
            near_origin: row(&self.near_origin),
            far_origin: row(&self.far_origin),
            small: row(&self.small),
            large: row(&self.large),
            t_min: self.t_min[c],
        }
    }

    /// Which packets may meet a child's box.
    #[inline(always)]
    fn meet<const W: usize, L: Lanes<8>>(&self, rows: Rows, node: &Node<W>, lane: usize) -> u32 {
        let (mut near, mut far) = (L::load(&self.t_min), L::load(&self.t));
        for k in 0..3 {
            let (small, large) = (L::load(&self.small[k]), L::load(&self.large[k]));
            let x = L::splat(node.planes[rows.near[k].at()][lane % W]) - L::load(&self.near_origin[k]);
            near = (x * small).least(x * large).most(near);
            let x = L::splat(node.planes[rows.far[k].at()][lane % W]) - L::load(&self.far_origin[k]);
            far = (x * small).most(x * large).least(far);
        }
        near.le(far)
    }

    /// All rays, node by node.
    #[inline(always)]
    fn walk<const ANY: bool, const W: usize, L: Lanes<8>, LW: Lanes<W>>(
        &mut self,
        view: &View<'_, W>,
        prims: &Prims<'_>,
        heading: Heading,
        mut meter: impl Meter,
    ) -> Result<(), Stop> {
        let rows = Rows::of(heading.negative);
        let range = self.range(heading);
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
                let (mut maybe, near) = if one {
                    let packet = packets.trailing_zeros();
                    self.one(packet).meet::<W, LW>(rows, node, self.t[index(packet) % PACKETS])
                } else {
                    range.meet::<W, LW>(rows, node, farthest)
                };
                let near = near.store();
                let mut sorted = 0usize;
                while maybe != 0 {
                    let lane = index(maybe.trailing_zeros()) % W;
                    maybe &= maybe - 1;
                    let met = if one { packets } else { packets & self.meet::<W, L>(rows, node, lane) };
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
                if self.leaf::<ANY, L>(heading, blocks.ok_or(Stop::Corrupt)?, at.len(), packets) {
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
    fn leaf<const ANY: bool, L: Lanes<8>>(
        &mut self,
        heading: Heading,
        blocks: &[Block],
        len: u32,
        mut packets: u32,
    ) -> bool {
        let mut any = false;
        while packets != 0 {
            let c = index(packets.trailing_zeros()) % PACKETS;
            packets &= packets - 1;
            let packet = &mut self.packets[c];
            let (mut hits, mut left) = (0, len);
            for block in blocks {
                hits |= packet.test::<ANY, L>(heading, block, left);
                left = left.saturating_sub(LANES);
            }
            if hits != 0 {
                self.t[c] = packet.farthest::<L>();
                any = true;
            }
        }
        any
    }
}

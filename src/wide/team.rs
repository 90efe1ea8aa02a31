//! The packets of a group: what is taken of the rays, and the box test of all packets, one in each lane.
use super::group::{AT_ONCE, PACKETS};
use crate::geom::Ray;
use crate::geom::place::Place;
use crate::geom::vec::Vec3;
use crate::num::{count, index};
use crate::walk::heading::Heading;
use crate::walk::lanes::Lanes;
use crate::walk::packet::{Packet, Range, Ranges};

/// A number of each packet.
type Each = [f32; PACKETS];

/// Packets that walk together.
#[cfg_attr(target_arch = "x86_64", repr(align(32)))]
pub(super) struct Team {
    pub(super) packets: [Packet<AT_ONCE>; PACKETS],
    /// Which packets there are.
    pub(super) used: u32,
    /// Their extremes.
    near_origin: [Each; 3],
    far_origin: [Each; 3],
    small: [Each; 3],
    large: [Each; 3],
    t_min: Each,
    /// The farthest that any ray of each still has to look.
    pub(super) t: Each,
}

impl Team {
    pub(super) const EMPTY: Self = {
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

    /// Takes some of the rays. Returns whether all have the heading; if not, nothing is ready.
    #[inline(always)]
    pub(super) fn set<L: Lanes<8>>(&mut self, rays: &[Ray], mine: u64, heading: Heading, place: &Place<'_>) -> bool {
        let taken = index(mine.count_ones());
        let in_row = mine & mine.wrapping_add(1) == 0;
        let mut mine = mine;
        let used = taken.div_ceil(AT_ONCE).min(PACKETS);
        for (c, packet) in self.packets.iter_mut().enumerate().take(used) {
            let live = taken.saturating_sub(c * AT_ONCE).clamp(1, AT_ONCE);
            let given = rays.get(c * AT_ONCE..).and_then(|rays| rays.first_chunk::<AT_ONCE>());
            let picked;
            let eight = match given {
                Some(eight) if in_row && live == AT_ONCE => {
                    mine &= u64::MAX.checked_shl(count((c + 1) * AT_ONCE)).unwrap_or(0);
                    eight
                }
                _ => {
                    (picked, mine) = pick(rays, mine);
                    &picked
                }
            };
            if packet.set::<L>(eight, u32::MAX >> (32 - live), heading, place) & 255 != 255 {
                return false;
            }
        }
        self.used = 255 >> (PACKETS - used);
        // Where there are no more packets stands the first: the interval of all is then no wider for them.
        let mut packets = [&self.packets[0]; PACKETS];
        for c in 1..used {
            packets[c % PACKETS] = &self.packets[c % PACKETS];
        }
        let all = Ranges::<L>::new(packets, heading);
        for k in 0..3 {
            self.near_origin[k] = all.near_origin[k].store();
            self.far_origin[k] = all.far_origin[k].store();
            self.small[k] = all.small[k].store();
            self.large[k] = all.large[k].store();
        }
        self.t_min = all.t_min.store();
        self.t = L::choose(self.used, all.t, L::splat(f32::NEG_INFINITY)).store();
        true
    }

    /// The extremes of all packets.
    #[inline(always)]
    pub(super) fn range<L: Lanes<8>>(&self, heading: Heading) -> Range {
        let mut range = Range { t_min: L::load(&self.t_min).smallest(), ..Range::EMPTY };
        for k in 0..3 {
            let end = |row: &Each, greatest: bool| {
                let row = L::load(row);
                if greatest { row.greatest() } else { row.smallest() }
            };
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
    pub(super) fn one(&self, packet: u32) -> Range {
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

    /// Which packets may meet a box, whose planes stand as the signs order them.
    #[inline(always)]
    pub(super) fn meet<L: Lanes<8>>(&self, first: Vec3, last: Vec3) -> u32 {
        let (mut near, mut far) = (L::load(&self.t_min), L::load(&self.t));
        for k in 0..3 {
            let (small, large) = (L::load(&self.small[k]), L::load(&self.large[k]));
            let x = L::splat(first[k]) - L::load(&self.near_origin[k]);
            near = (x * small).least(x * large).most(near);
            let x = L::splat(last[k]) - L::load(&self.far_origin[k]);
            far = (x * small).most(x * large).least(far);
        }
        near.le(far)
    }
}

/// The next eight rays of those that are `mine`, and what is then left of these. Lanes that are left over repeat the last
/// ray: an interval is then no wider for them.
#[inline(never)]
fn pick(rays: &[Ray], mut mine: u64) -> ([Ray; AT_ONCE], u64) {
    let mut picked = [Ray { origin: [0.0; 3], dir: [0.0; 3], t_min: 0.0, t_max: 0.0 }; AT_ONCE];
    for lane in &mut picked {
        *lane = rays.get(index(mine.trailing_zeros())).copied().unwrap_or(*lane);
        let rest = mine & mine.wrapping_sub(1);
        mine = if rest == 0 { mine } else { rest };
    }
    (picked, mine)
}

//! What all rays of a packet have in common.
use super::{Each, Packet};
use crate::geom::vec::Vec3;
use crate::walk::heading::Heading;
use crate::walk::lanes::Lanes;

/// The extremes of the rays of a packet, or of several: an interval that holds each number of each ray.
#[derive(Clone, Copy)]
pub(crate) struct Range {
    /// The origin from which nearer planes are nearest, and that from which farther planes are farthest.
    pub(crate) near_origin: Vec3,
    pub(crate) far_origin: Vec3,
    /// The inverses of the least and of the greatest size.
    pub(crate) small: Vec3,
    pub(crate) large: Vec3,
    pub(crate) t_min: f32,
}

impl Range {
    pub(crate) const EMPTY: Self =
        Self { near_origin: [0.0; 3], far_origin: [0.0; 3], small: [0.0; 3], large: [0.0; 3], t_min: 0.0 };
}

/// The extremes of the rays of eight packets, a packet in each lane.
pub(crate) struct Ranges<L> {
    pub(crate) near_origin: [L; 3],
    pub(crate) far_origin: [L; 3],
    pub(crate) small: [L; 3],
    pub(crate) large: [L; 3],
    pub(crate) t_min: L,
    /// The farthest that any ray still has to look.
    pub(crate) t: L,
}

impl<L: Lanes<8>> Ranges<L> {
    /// Of all lanes, also of those that are not live.
    #[inline(always)]
    pub(crate) fn new([a, b, c, d, e, f, g, h]: [&Packet<8>; 8], heading: Heading) -> Self {
        // The rays of all packets stand in columns: so one step finds the extreme of two rays for every packet.
        macro_rules! columns {
            ($($row:tt)*) => {
                L::columns([&a$($row)*, &b$($row)*, &c$($row)*, &d$($row)*, &e$($row)*, &f$($row)*, &g$($row)*, &h$($row)*])
            };
        }
        let zero = [L::splat(0.0); 3];
        let (t_min, t) = (least(columns!(.t_min)), most(columns!(.t)));
        let mut all = Self { near_origin: zero, far_origin: zero, small: zero, large: zero, t_min, t };
        for k in 0..3 {
            let (near, far, inv) = (columns!(.near_origin[k]), columns!(.far_origin[k]), columns!(.inv[k]));
            (all.near_origin[k], all.far_origin[k], all.small[k], all.large[k]) = if heading.negative[k] {
                (least(near), most(far), most(inv), least(inv))
            } else {
                (most(near), least(far), least(inv), most(inv))
            };
        }
        all
    }
}

/// The least of each lane.
#[inline(always)]
fn least<L: Lanes<8>>([a, b, c, d, e, f, g, h]: [L; 8]) -> L {
    (a.least(b).least(c.least(d))).least(e.least(f).least(g.least(h)))
}

/// The greatest.
#[inline(always)]
fn most<L: Lanes<8>>([a, b, c, d, e, f, g, h]: [L; 8]) -> L {
    (a.most(b).most(c.most(d))).most(e.most(f).most(g.most(h)))
}

impl<const N: usize> Packet<N> {
    /// The extremes of all lanes, also of those that are not live.
    #[inline(always)]
    pub(crate) fn range<L: Lanes<N>>(&self, heading: Heading) -> Range {
        let mut range = Range { t_min: L::load(&self.t_min).smallest(), ..Range::EMPTY };
        for k in 0..3 {
            let end = |row: &Each<N>, greatest: bool| {
                let row = L::load(row);
                if greatest { row.greatest() } else { row.smallest() }
            };
            let negative = heading.negative[k];
            range.near_origin[k] = end(&self.near_origin[k], !negative);
            range.far_origin[k] = end(&self.far_origin[k], negative);
            range.small[k] = end(&self.inv[k], negative);
            range.large[k] = end(&self.inv[k], !negative);
        }
        range
    }
}

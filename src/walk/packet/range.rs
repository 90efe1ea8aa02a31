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

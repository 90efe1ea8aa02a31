//! Which rays can stand side by side.
use super::lanes::Lanes;
use crate::geom::Ray;
use crate::geom::ray::{Axis, SMALL};
use crate::geom::vec::{Vec3, most};

/// Rays of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PacketSize {
    /// 4
    Four,
    /// 8
    Eight,
    /// 16
    Sixteen,
}

impl PacketSize {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Four, Self::Eight, Self::Sixteen];

    /// How many.
    #[must_use]
    pub const fn rays(self) -> usize {
        match self {
            Self::Four => 4,
            Self::Eight => 8,
            Self::Sixteen => 16,
        }
    }
}

/// What rays must have in common to share a packet: the signs of their directions, and the largest axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Heading {
    pub(crate) negative: [bool; 3],
    pub(super) kz: Axis,
}

impl Heading {
    /// That of a ray; none for one that meets nothing or is prepared in its own way, with a tiny direction.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Option<Self> {
        let dir = [ray.dir[0] + 0.0, ray.dir[1] + 0.0, ray.dir[2] + 0.0];
        let [x, y, z] = dir.map(f32::abs);
        let kz = if y > x { Axis::Y } else { Axis::X };
        let kz = if z > most(y, x) { Axis::Z } else { kz };
        let finite = |v: Vec3| v[0].is_finite() & v[1].is_finite() & v[2].is_finite();
        let good = finite(ray.origin) && finite(dir) && most(z, most(y, x)) >= SMALL && ray.t_min <= ray.t_max;
        good.then_some(Self { negative: dir.map(|x| x < 0.0), kz })
    }

    /// In which lanes it is that of a direction.
    #[inline(always)]
    pub(crate) fn is<const N: usize, L: Lanes<N>>(self, dir: &[L; 3]) -> u32 {
        let [x, y, z] = [dir[0].abs(), dir[1].abs(), dir[2].abs()];
        let largest = z.most(y.most(x));
        let mut same = L::splat(SMALL).le(largest);
        let (second, third) = (x.lt(y), y.most(x).lt(z));
        same &= match self.kz {
            Axis::X => !second & !third,
            Axis::Y => second & !third,
            Axis::Z => third,
        };
        let (zero, infinite) = (L::splat(0.0), L::splat(f32::INFINITY));
        for k in 0..3 {
            same &= dir[k].abs().lt(infinite);
            let negative = dir[k].lt(zero);
            same &= if self.negative[k] { negative } else { !negative };
        }
        same
    }
}

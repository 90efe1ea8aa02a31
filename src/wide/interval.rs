//! The box test of many rays at once: see [`super::group`].
use crate::walk::lanes::Lanes;
use crate::walk::packet::Range;

impl Range {
    /// Which boxes any ray may meet up to `t_max`, and from which distance on. Their planes stand as the signs order them.
    #[inline(always)]
    pub(super) fn meet<const W: usize, L: Lanes<W>>(
        &self,
        first: [&[f32; W]; 3],
        last: [&[f32; W]; 3],
        t_max: f32,
    ) -> (u32, L) {
        let (mut near, mut far) = (L::splat(self.t_min), L::splat(t_max));
        let ends = |planes: &[f32; W], k: usize, origin: f32| {
            let x = L::load(planes) - L::splat(origin);
            (x * L::splat(self.small[k]), x * L::splat(self.large[k]))
        };
        for k in 0..3 {
            let (a, b) = ends(first[k], k, self.near_origin[k]);
            near = a.least(b).most(near);
            let (a, b) = ends(last[k], k, self.far_origin[k]);
            far = a.most(b).least(far);
        }
        (near.le(far), near)
    }
}

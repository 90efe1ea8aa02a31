//! Queries of many rays at once.
use super::Scene;
use crate::geom::{Hit, Ray};
use crate::num::count;
use crate::structure::Structure;
use crate::walk::group::{RAYS, Rays};
use crate::walk::lanes;
use crate::walk::mailbox::NoMailbox;
use crate::walk::{Fuel, Isa, PacketSize, Steps, Tally};
use crate::wide;

/// Whether compilers make vectors of loops for this machine.
const LOOPS: bool = cfg!(any(target_feature = "sse2", target_feature = "neon", target_feature = "simd128"));

impl Scene<'_> {
    /// [`Scene::closest_hit`] for many rays: `hits[i]` becomes the answer to `rays[i]`. Of two lengths the lesser
    /// counts.
    ///
    /// Rays that come from about the same place, 64 after another, are walked together in hierarchies, `octree` and `bsp`
    /// if the scene is made of triangles: each node and triangle is loaded once for all of them. What suits them is found
    /// out from a few. So neighbours should stand side by side, such as pixels in tiles of 8 by 8, those in tiles of
    /// 4 by 4 and of 4 by 2. The answers are the same in any order. Of rays from everywhere 64 go their own ways on `wide`,
    /// in turns, so that one need not wait for another's memory; the more a call has the better, and less than 32 go one after
    /// another. Elsewhere they are answered one after another; so are those in scenes with other primitives, because these
    /// are tested ray by ray, and those of different directions where the library has no lanes
    /// ([`Isa::SCALAR`](crate::walk::Isa::SCALAR)).
    ///
    /// A call takes at most [`STREAM_SCRATCH`](crate::walk::STREAM_SCRATCH) bytes of stack more than a single ray's on
    /// `wide` and [`GROUP_SCRATCH`](crate::walk::GROUP_SCRATCH) elsewhere, however many rays there are.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        if self.wide::<_, _, false>(None, rays, hits, &mut wide::Uncounted) {
            return;
        }
        for (rays, hits) in rays.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
            self.group::<false, false, false>(rays, hits, &mut Steps::default());
        }
    }

    /// [`Scene::any_hit`] for many rays: `hits[i]` becomes the answer to `rays[i]`, in the same way as by
    /// [`Scene::closest_hits`].
    pub fn any_hits(&self, rays: &[Ray], hits: &mut [bool]) {
        if self.wide::<_, _, true>(None, rays, hits, &mut wide::Uncounted) {
            return;
        }
        let mut found = [None; RAYS];
        for (rays, hits) in rays.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
            self.group::<true, false, false>(rays, &mut found, &mut Steps::default());
            hits.iter_mut().zip(&found).take(rays.len()).for_each(|(hit, found)| *hit = found.is_some());
        }
    }

    /// [`Scene::closest_hits`] together with what it cost: what a group loads once is counted once.
    pub fn closest_hits_counted(&self, rays: &[Ray], hits: &mut [Option<Hit>]) -> Steps {
        let mut steps = Steps::default();
        let mut tally = Tally { fuel: Fuel(self.fuel), steps };
        if self.wide::<_, _, false>(None, rays, hits, &mut tally) {
            return tally.steps;
        }
        for (rays, hits) in rays.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
            self.group::<false, true, false>(rays, hits, &mut steps);
        }
        steps
    }

    /// [`Scene::closest_hits_counted`] with lists of rays where that has masks: the lecture's form, to be compared with.
    /// The answers are the same, and so is what is loaded where the signs of directions differ.
    pub fn closest_hits_listed(&self, rays: &[Ray], hits: &mut [Option<Hit>]) -> Steps {
        let mut steps = Steps::default();
        for (rays, hits) in rays.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
            self.group::<false, true, true>(rays, hits, &mut steps);
        }
        steps
    }

    /// [`Scene::any_hits`] together with what it cost, likewise.
    pub fn any_hits_counted(&self, rays: &[Ray], hits: &mut [bool]) -> Steps {
        let (mut steps, mut found) = (Steps::default(), [None; RAYS]);
        let mut tally = Tally { fuel: Fuel(self.fuel), steps };
        if self.wide::<_, _, true>(None, rays, hits, &mut tally) {
            return tally.steps;
        }
        for (rays, hits) in rays.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
            self.group::<true, true, false>(rays, &mut found, &mut steps);
            hits.iter_mut().zip(&found).take(rays.len()).for_each(|(hit, found)| *hit = found.is_some());
        }
        steps
    }

    /// [`Scene::closest_hits`] in packets, whatever the rays: on `wide` each 4, 8 or 16 in a row are tested together
    /// against a box or a triangle. Those with directions of other signs, or with another largest component, make
    /// packets of their own, or go alone. In other structures all go alone.
    ///
    /// The answers are the same. Where rays are alike groups are faster, and where they are not, rays alone: this is for
    /// those who have few rays at a time, or compare.
    ///
    /// ```
    /// # #[cfg(feature = "alloc")] {
    /// # use flashray::{*, build::*, walk::PacketSize};
    /// # let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
    /// # let blob = to_vec(&mesh, &Config::new(Kind::Wide)).unwrap();
    /// # let scene = Scene::from_bytes(&blob).unwrap();
    /// let rays = [0.1, 0.2, 0.7].map(|x| Ray::new([x, 0.5, 1.0], [0.0, 0.0, -1.0]));
    /// let mut hits = [None; 3];
    /// scene.closest_hits_in_packets(PacketSize::Four, &rays, &mut hits);
    /// assert_eq!(hits.map(|hit| hit.is_some()), [true, true, false]);
    /// # }
    /// ```
    pub fn closest_hits_in_packets(&self, of: PacketSize, rays: &[Ray], hits: &mut [Option<Hit>]) {
        if !self.wide::<_, _, false>(Some(of), rays, hits, &mut wide::Uncounted) {
            rays.iter().zip(hits).for_each(|(ray, hit)| *hit = self.closest_hit(ray));
        }
    }

    /// [`Scene::any_hits`] in packets, as [`Scene::closest_hits_in_packets`].
    pub fn any_hits_in_packets(&self, of: PacketSize, rays: &[Ray], hits: &mut [bool]) {
        if !self.wide::<_, _, true>(Some(of), rays, hits, &mut wide::Uncounted) {
            rays.iter().zip(hits).for_each(|(ray, hit)| *hit = self.any_hit(ray));
        }
    }

    /// Up to 64 rays.
    #[inline]
    fn group<const ANY: bool, const COUNTED: bool, const LISTS: bool>(
        &self,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        steps: &mut Steps,
    ) {
        let (prims, place, fuel) = (&self.prims, &self.place, self.fuel);
        let len = rays.len().min(hits.len());
        let (Some(rays), Some(hits)) = (rays.get(..len), hits.get_mut(..len)) else { return };
        // All that a group and each of its rays may spend.
        let mut tally = Tally { fuel: Fuel(fuel.saturating_mul(count(RAYS).saturating_add(1))), steps: *steps };
        let group = Rays { prims, rays, hits: &mut *hits, place };
        // Where not even compilers have lanes, a group saves fetches and no time; where only they do, it does if its rays are
        // alike; and primitives other than triangles are tested ray by ray, so that it costs 10 % there. Those who count get
        // one always.
        let has_lanes = self.isa != Isa::SCALAR || LOOPS && group.are_alike();
        let worth = COUNTED || has_lanes && prims.refs.is_empty();
        if !worth || self.structure.group::<ANY, LISTS>(group, self.isa, &mut tally) != Ok(true) {
            // One by one; also where an unchecked blob contradicts itself: those that do not come there get an answer.
            for (ray, hit) in rays.iter().zip(hits) {
                tally.fuel = Fuel(fuel);
                *hit = if COUNTED {
                    self.query::<ANY>(ray, &mut tally, &mut NoMailbox)
                } else {
                    self.query::<ANY>(ray, Fuel(fuel), &mut NoMailbox)
                }
                .unwrap_or(None);
            }
        }
        *steps = tally.steps;
    }

    /// Many rays on `wide`, in packets or in groups. Returns whether this is one.
    fn wide<A: wide::Answer, P: wide::Purse, const ANY: bool>(
        &self,
        packets: Option<PacketSize>,
        rays: &[Ray],
        answers: &mut [A],
        purse: &mut P,
    ) -> bool {
        match &self.structure {
            Structure::Wide(view) => self.wide_of::<A, P, ANY, 8>(view, packets, rays, answers, purse),
            Structure::Wide4(view) => self.wide_of::<A, P, ANY, 4>(view, packets, rays, answers, purse),
            _ => return false,
        }
        true
    }

    /// The same with nodes of a width.
    fn wide_of<A: wide::Answer, P: wide::Purse, const ANY: bool, const W: usize>(
        &self,
        view: &wide::View<'_, W>,
        packets: Option<PacketSize>,
        rays: &[Ray],
        answers: &mut [A],
        purse: &mut P,
    ) where
        wide::Node<W>: wide::Wide<W>,
    {
        let len = rays.len().min(answers.len());
        let (Some(rays), Some(answers)) = (rays.get(..len), answers.get_mut(..len)) else { return };
        if self.prims.len == 0 {
            return answers.iter_mut().for_each(|answer| *answer = A::new(None));
        }
        if !lanes::HERE {
            for (ray, answer) in rays.iter().zip(answers) {
                *answer = A::new(self.query::<ANY>(ray, purse.open(self.fuel), &mut NoMailbox).unwrap_or(None));
            }
            return;
        }
        let (prims, place) = (&self.prims, &self.place);
        let many = wide::Many { view, prims, place, fuel: self.fuel, isa: self.isa };
        match packets {
            Some(of) => many.packets::<_, ANY>(of, rays, answers),
            None => many.groups::<_, _, ANY>(rays, answers, purse),
        }
    }
}

//! Queries of many rays at once.
use super::Scene;
use crate::geom::{Hit, Ray};
use crate::num::count;
use crate::structure::Structure;
use crate::walk::group::{RAYS, Rays};
use crate::walk::lanes;
use crate::walk::mailbox::NoMailbox;
use crate::walk::packet::Place;
use crate::walk::{Fuel, Isa, PacketSize, Steps, Tally};
use crate::wide;

/// Whether compilers make vectors of loops for this machine.
const LOOPS: bool = cfg!(any(target_feature = "sse2", target_feature = "neon", target_feature = "simd128"));

impl Scene<'_> {
    /// [`Scene::closest_hit`] for many rays: `hits[i]` becomes the answer to `rays[i]`. Of two lengths the lesser
    /// counts.
    ///
    /// Rays that come from about the same place, 64 after another, are walked together where the structure allows that
    /// (hierarchies, `octree`, `bsp`) and the machine has lanes: each node and primitive is loaded once for all of them. What suits them is found
    /// out from a few. So neighbours should stand side by side, such as pixels in tiles of 8 by 8, those in tiles of
    /// 4 by 4 and of 4 by 2. The answers are the same in any order, and rays from everywhere are answered one after
    /// another. A group takes 10 KiB of stack on
    /// `wide` and [`GROUP_SCRATCH`](crate::walk::GROUP_SCRATCH) bytes elsewhere, however many rays there are.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        match &self.structure {
            Structure::Wide(view) => return self.wide::<_, false, 8>(view, None, rays, hits),
            Structure::Wide4(view) => return self.wide::<_, false, 4>(view, None, rays, hits),
            _ => {}
        }
        for (rays, hits) in rays.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
            self.group::<false, false, false>(rays, hits, &mut Steps::default());
        }
    }

    /// [`Scene::any_hit`] for many rays: `hits[i]` becomes the answer to `rays[i]`, in the same way as by
    /// [`Scene::closest_hits`].
    pub fn any_hits(&self, rays: &[Ray], hits: &mut [bool]) {
        match &self.structure {
            Structure::Wide(view) => return self.wide::<_, true, 8>(view, None, rays, hits),
            Structure::Wide4(view) => return self.wide::<_, true, 4>(view, None, rays, hits),
            _ => {}
        }
        let mut found = [None; RAYS];
        for (rays, hits) in rays.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
            self.group::<true, false, false>(rays, &mut found, &mut Steps::default());
            hits.iter_mut().zip(&found).take(rays.len()).for_each(|(hit, found)| *hit = found.is_some());
        }
    }

    /// [`Scene::closest_hits`] together with what it cost: what a group loads once is counted once. In `wide` the rays
    /// are counted one after another.
    pub fn closest_hits_counted(&self, rays: &[Ray], hits: &mut [Option<Hit>]) -> Steps {
        let mut steps = Steps::default();
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
        match &self.structure {
            Structure::Wide(view) => self.wide::<_, false, 8>(view, Some(of), rays, hits),
            Structure::Wide4(view) => self.wide::<_, false, 4>(view, Some(of), rays, hits),
            _ => rays.iter().zip(hits).for_each(|(ray, hit)| *hit = self.closest_hit(ray)),
        }
    }

    /// [`Scene::any_hits`] in packets, as [`Scene::closest_hits_in_packets`].
    pub fn any_hits_in_packets(&self, of: PacketSize, rays: &[Ray], hits: &mut [bool]) {
        match &self.structure {
            Structure::Wide(view) => self.wide::<_, true, 8>(view, Some(of), rays, hits),
            Structure::Wide4(view) => self.wide::<_, true, 4>(view, Some(of), rays, hits),
            _ => rays.iter().zip(hits).for_each(|(ray, hit)| *hit = self.any_hit(ray)),
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
        let (prims, bounds, local, fuel) = (&self.prims, self.bounds, &self.local, self.fuel);
        let len = rays.len().min(hits.len());
        let (Some(rays), Some(hits)) = (rays.get(..len), hits.get_mut(..len)) else { return };
        // All that a group and each of its rays may spend.
        let mut tally = Tally { fuel: Fuel(fuel.saturating_mul(count(RAYS).saturating_add(1))), steps: *steps };
        let group = Rays { prims, rays, hits: &mut *hits, bounds, local };
        // Where not even compilers have lanes, a group saves fetches and no time; where only they do, it does if its rays are
        // alike. Those who count get one always.
        let worth = COUNTED || self.isa != Isa::SCALAR || LOOPS && group.are_alike();
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

    /// Many rays on `wide`, in packets or in groups.
    fn wide<A: wide::Answer, const ANY: bool, const W: usize>(
        &self,
        view: &wide::View<'_, W>,
        packets: Option<PacketSize>,
        rays: &[Ray],
        answers: &mut [A],
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
                *answer = A::new(self.query::<ANY>(ray, Fuel(self.fuel), &mut NoMailbox).unwrap_or(None));
            }
            return;
        }
        let (prims, place) = (&self.prims, Place { bounds: self.bounds, local: &self.local });
        let many = wide::Many { view, prims, place, fuel: self.fuel, isa: self.isa };
        match packets {
            Some(of) => many.packets::<_, ANY>(of, rays, answers),
            None => many.groups::<_, ANY>(rays, answers),
        }
    }
}

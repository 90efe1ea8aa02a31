//! A loaded blob, and the queries on it.

mod many;
mod views;

use crate::blob::prims::{Primitive, Prims};
use crate::blob::{Blob, BlobError, Kind, Rule, Section};
use crate::geom::place::Place;
use crate::geom::ray::Prepared;
use crate::geom::{Aabb, Hit, Ray};
use crate::structure::Structure;
use crate::walk::lanes;
use crate::walk::mailbox::{Mailbox, NoMailbox};
use crate::walk::prepare::Given;
use crate::walk::{Best, Fuel, Isa, Meter, Part, Steps, Stop, Tally};
use crate::{bvh, list, wide};

/// What bounds every query on a blob.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Deepest stack of a walk, in entries; at most [`MAX_STACK`](crate::blob::MAX_STACK).
    pub stack: u32,
    /// Most steps of a walk: nodes visited and primitives tested.
    pub steps: u32,
}

/// A scene read in place: it borrows the blob, owns nothing, and can be copied.
///
/// Queries never panic, never allocate, and stop within as many steps as [`Scene::limits`] says, whatever the ray and
/// whatever the bytes.
///
/// ```
/// # #[cfg(feature = "alloc")] {
/// use flashray::build::{Config, Mesh, to_vec};
/// use flashray::{Kind, Ray, Scene};
///
/// let mesh = Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
/// let blob = to_vec(&mesh, &Config::new(Kind::Bvh))?;
/// let scene = Scene::from_bytes(&blob)?;
/// let hit = scene.closest_hit(&Ray::new([0.25, 0.25, 5.0], [0.0, 0.0, -1.0])).unwrap();
/// assert_eq!((hit.t, hit.u, hit.v, hit.prim), (5.0, 0.25, 0.25, 0));
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    prims: Prims<'a>,
    structure: Structure<'a>,
    place: Place<'a>,
    kind: Kind,
    fuel: u32,
    limits: Limits,
    isa: Isa,
}

impl<'a> Scene<'a> {
    /// Loads a blob after checking everything in it, once: O(n), no heap.
    ///
    /// `bytes` must start at a multiple of 4 in memory; at a multiple of 64 it is fastest.
    ///
    /// # Errors
    /// A rule of `docs/format.md` that the blob breaks, and where.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, BlobError> {
        let blob = Blob::parse(bytes)?;
        let scene = Self::parse(&blob)?;
        blob.check()?;
        scene.check(&blob)?;
        Ok(scene)
    }

    /// Loads a blob without reading beyond its header and section table: O(1).
    ///
    /// Queries are as safe as after [`Scene::from_bytes`], and end within the numbers of nodes and primitives. Only
    /// their answers are no better than the bytes: use this for blobs that were checked before, or that the firmware
    /// itself carries.
    ///
    /// # Errors
    /// One of rules 1 to 13, 24, 25, 30 or 40, if the blob breaks any.
    pub fn trust(bytes: &'a [u8]) -> Result<Self, BlobError> {
        Self::parse(&Blob::parse(bytes)?)
    }

    fn parse(blob: &Blob<'a>) -> Result<Self, BlobError> {
        let header = blob.header();
        let kind = header.kind().ok_or(BlobError::new(Rule::KindKnown, Section::Header))?;
        let prims = Prims::parse(blob)?;
        let (structure, fuel) = Structure::parse(kind, blob, &prims)?;
        if header.steps != fuel {
            return Err(BlobError::new(Rule::StepsTrue, Section::Header).found(header.steps).needed(fuel));
        }
        let limits = Limits { stack: header.stack, steps: header.steps };
        let place = Place::new(&header.bounds, header.local, header.longest);
        Ok(Self { prims, structure, place, kind, fuel, limits, isa: Isa::best() })
    }

    fn check(&self, blob: &Blob<'a>) -> Result<(), BlobError> {
        let header = blob.header();
        self.prims.check(self.place.bounds, header.longest)?;
        let stack = self.structure.check(&self.prims, self.place.bounds)?;
        let error = BlobError::new(Rule::StackTrue, Section::Header).found(header.stack).needed(stack);
        if header.stack == stack { Ok(()) } else { Err(error) }
    }

    /// The hit with the least `t` in the ray's interval; among equal `t`, the one with the least primitive number.
    ///
    /// `None` if there is none, if the ray makes no sense (see [`Ray`]), or if an unchecked blob contradicts itself.
    #[inline(always)] // see `query`
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.query::<false>(ray, Fuel(self.fuel), &mut NoMailbox).unwrap_or(None)
    }

    /// Whether there is a hit in the ray's interval. Cheaper than asking for the closest.
    #[inline(always)] // see `query`
    #[must_use]
    pub fn any_hit(&self, ray: &Ray) -> bool {
        self.query::<true>(ray, Fuel(self.fuel), &mut NoMailbox).is_ok_and(|hit| hit.is_some())
    }

    /// [`Scene::closest_hit`] that spends at most `fuel` steps: one per node visited and per primitive tested.
    ///
    /// # Errors
    /// [`Stop::Fuel`] if that was not enough; [`Stop::Corrupt`] if an unchecked blob contradicts itself.
    ///
    /// ```
    /// # #[cfg(feature = "alloc")] {
    /// # use flashray::{*, build::*};
    /// # let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
    /// # let blob = to_vec(&mesh, &Config::new(Kind::List)).unwrap();
    /// # let scene = Scene::from_bytes(&blob).unwrap();
    /// let ray = Ray::new([0.25, 0.25, 5.0], [0.0, 0.0, -1.0]);
    /// assert_eq!(scene.closest_hit_within(&ray, 0), Err(Stop::Fuel));
    /// assert!(scene.closest_hit_within(&ray, 1).unwrap().is_some());
    /// # }
    /// ```
    pub fn closest_hit_within(&self, ray: &Ray, fuel: u32) -> Result<Option<Hit>, Stop> {
        match self.query::<false>(ray, Fuel(fuel.min(self.fuel)), &mut NoMailbox) {
            // More than there are nodes and primitives: some must have been visited twice.
            Err(Stop::Fuel) if fuel >= self.fuel => Err(Stop::Corrupt),
            answer => answer,
        }
    }

    /// [`Scene::closest_hit`] together with what it cost.
    #[must_use]
    pub fn closest_hit_counted(&self, ray: &Ray) -> (Option<Hit>, Steps) {
        let mut tally = Tally { fuel: Fuel(self.fuel), steps: Steps::default() };
        let hit = self.query::<false>(ray, &mut tally, &mut NoMailbox).unwrap_or(None);
        (hit, tally.steps)
    }

    /// [`Scene::any_hit`] together with what it cost.
    #[must_use]
    pub fn any_hit_counted(&self, ray: &Ray) -> (bool, Steps) {
        let mut tally = Tally { fuel: Fuel(self.fuel), steps: Steps::default() };
        let found = self.query::<true>(ray, &mut tally, &mut NoMailbox).is_ok_and(|hit| hit.is_some());
        (found, tally.steps)
    }

    /// [`Scene::closest_hit_counted`] with a mailbox: the same answer, and in structures that list a primitive in
    /// several cells fewer tests.
    ///
    /// ```
    /// # #[cfg(feature = "alloc")] {
    /// # use flashray::{*, build::*, walk::mailbox::Last8};
    /// # let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
    /// # let blob = to_vec(&mesh, &Config::new(Kind::Grid).cells(8)).unwrap();
    /// # let scene = Scene::from_bytes(&blob).unwrap();
    /// let ray = Ray::new([0.1, 0.7, 0.0], [1.0, 0.0, 0.0]); // along the triangle, and edge-on: no hit
    /// let (hit, steps) = scene.closest_hit_mailed(&ray, &mut Last8::default());
    /// assert_eq!((hit, steps.prims), (None, 1));
    /// assert_eq!(steps.spared + 1, scene.closest_hit_counted(&ray).1.prims);
    /// # }
    /// ```
    #[must_use]
    pub fn closest_hit_mailed(&self, ray: &Ray, mailbox: &mut impl Mailbox) -> (Option<Hit>, Steps) {
        mailbox.clear();
        let mut tally = Tally { fuel: Fuel(self.fuel), steps: Steps::default() };
        let hit = self.query::<false>(ray, &mut tally, mailbox).unwrap_or(None);
        (hit, tally.steps)
    }

    /// [`Scene::any_hit_counted`] with a mailbox: likewise.
    ///
    /// ```
    /// # #[cfg(feature = "alloc")] {
    /// # use flashray::{*, build::*, walk::mailbox::Last8};
    /// # let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
    /// # let blob = to_vec(&mesh, &Config::new(Kind::Grid).cells(8)).unwrap();
    /// # let scene = Scene::from_bytes(&blob).unwrap();
    /// let ray = Ray::new([0.1, 0.7, 0.0], [1.0, 0.0, 0.0]); // as above
    /// let (found, steps) = scene.any_hit_mailed(&ray, &mut Last8::default());
    /// assert_eq!((found, steps.prims), (false, 1));
    /// assert_eq!(steps.spared + 1, scene.any_hit_counted(&ray).1.prims);
    /// # }
    /// ```
    #[must_use]
    pub fn any_hit_mailed(&self, ray: &Ray, mailbox: &mut impl Mailbox) -> (bool, Steps) {
        mailbox.clear();
        let mut tally = Tally { fuel: Fuel(self.fuel), steps: Steps::default() };
        let found = self.query::<true>(ray, &mut tally, mailbox).is_ok_and(|hit| hit.is_some());
        (found, tally.steps)
    }

    /// [`Scene::closest_hit`] with a meter and a mailbox of the caller's: for those who count or draw.
    ///
    /// The meter alone bounds the walk. One that always pays may never end on a blob that was not checked.
    ///
    /// # Errors
    /// [`Stop`], as the meter and the bytes will have it.
    pub fn closest_hit_metered(
        &self,
        ray: &Ray,
        meter: &mut impl Meter,
        mailbox: &mut impl Mailbox,
    ) -> Result<Option<Hit>, Stop> {
        mailbox.clear();
        self.query::<false>(ray, meter, mailbox)
    }

    /// [`Scene::any_hit`] likewise.
    ///
    /// # Errors
    /// [`Stop`], as the meter and the bytes will have it.
    pub fn any_hit_metered(&self, ray: &Ray, meter: &mut impl Meter, mailbox: &mut impl Mailbox) -> Result<bool, Stop> {
        mailbox.clear();
        self.query::<true>(ray, meter, mailbox).map(|hit| hit.is_some())
    }

    // In line down to the call for the instruction set, so that the ray's rows are made where its numbers are at hand. What was
    // just written number by number and is read four at a time has to be waited for: 10 ns a ray where this was called.
    #[inline(always)]
    fn query<const ANY: bool>(
        &self,
        ray: &Ray,
        meter: impl Meter,
        mailbox: &mut impl Mailbox,
    ) -> Result<Option<Hit>, Stop> {
        if lanes::HERE
            && let Structure::Wide(view) = &self.structure
            && self.prims.len != 0
        {
            let (prims, place, ray) = (&self.prims, &self.place, Given::new(ray));
            return self.isa.run(wide::Query::<_, ANY, 8> { view, prims, ray, place, meter });
        }
        // A copy: a ray that is pointed to is kept in memory.
        let copy = *ray;
        self.query_others::<ANY>(if lanes::HERE { &copy } else { ray }, meter, mailbox)
    }

    #[inline]
    fn query_others<const ANY: bool>(
        &self,
        ray: &Ray,
        mut meter: impl Meter,
        mailbox: &mut impl Mailbox,
    ) -> Result<Option<Hit>, Stop> {
        if self.prims.len == 0 {
            return Ok(None);
        }
        if let Structure::Wide4(view) = &self.structure {
            return self.query_four::<ANY>(view, Given::new(ray), meter);
        }
        let Some(ray) = Prepared::new(ray, &self.place) else {
            return Ok(None);
        };
        let mut best = Best::new(ray.t_max);
        match &self.structure {
            Structure::List => list::walk::<ANY>(&self.prims, &ray, &mut best, &mut meter)?,
            Structure::Bvh(view) => bvh::walk::<ANY>(view, &self.prims, &ray, &mut best, &mut meter)?,
            Structure::Grid(view) => view.walk::<ANY>(&self.prims, &ray, &mut best, &mut meter, mailbox)?,
            Structure::Voxel(view) => view.walk::<ANY>(&self.prims, &ray, &mut best, &mut meter, mailbox)?,
            Structure::Nested(view) => view.walk::<ANY>(&self.prims, &ray, &mut best, &mut meter, mailbox)?,
            Structure::Octree(view) => view.walk::<ANY>(&self.prims, &ray, &mut best, &mut meter, mailbox)?,
            Structure::Bsp(view) => view.walk::<ANY>(&self.prims, &ray, &mut best, &mut meter, mailbox)?,
            Structure::Sphere(view) => view.walk::<ANY>(&self.prims, &ray, &mut best, &mut meter)?,
            // With lanes it is answered above, in one piece for each instruction set.
            Structure::Wide(view) => !lanes::HERE && view.walk::<ANY>(&self.prims, &ray, &mut best, &mut meter)?,
            Structure::Wide4(_) => false,
        };
        Ok(best.hit().map(|hit| Hit { t: hit.t * ray.unit, ..hit }))
    }

    // Out of line and off the way of eight, which took nine instructions more with both in one function.
    #[cold]
    #[inline(never)]
    fn query_four<const ANY: bool>(
        &self,
        view: &wide::View<'a, 4>,
        ray: Given,
        meter: impl Meter,
    ) -> Result<Option<Hit>, Stop> {
        let (prims, place) = (&self.prims, &self.place);
        self.isa.run(wide::Query::<_, ANY, 4> { view, prims, ray, place, meter })
    }

    /// The same scene with other instructions: all give the same answers. Only `wide` and groups
    /// of rays use any; the fastest are the default.
    #[must_use]
    pub const fn with_isa(mut self, isa: Isa) -> Self {
        self.isa = isa;
        self
    }

    /// What bounds every query. After [`Scene::trust`] the stack is only what the header claims; no walk uses more than
    /// [`MAX_STACK`](crate::blob::MAX_STACK) entries.
    #[must_use]
    pub const fn limits(&self) -> Limits {
        self.limits
    }

    /// The structure.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        self.kind
    }

    /// Most children of a node of `wide`, 8 or 4; none of other structures, and where there is no node.
    #[must_use]
    pub const fn width(&self) -> Option<u32> {
        match self.structure {
            Structure::Wide(view) if !view.nodes.is_empty() => Some(8),
            Structure::Wide4(_) => Some(4),
            _ => None,
        }
    }

    /// Number of primitives.
    #[must_use]
    pub const fn len(&self) -> u32 {
        self.prims.len
    }

    /// Whether there is no primitive.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.prims.len == 0
    }

    /// The box around all primitives, in blob coordinates: add [`Scene::local_origin`] to get the caller's.
    #[must_use]
    pub const fn bounds(&self) -> Aabb {
        *self.place.bounds
    }

    /// What was subtracted from every coordinate when the blob was built; 0 unless asked for.
    #[must_use]
    pub const fn local_origin(&self) -> [f32; 3] {
        self.place.local
    }

    /// Every primitive with the caller's number of it, in the structure's order, in blob coordinates.
    pub fn primitives(&self) -> impl Iterator<Item = (u32, Primitive)> + use<'a> {
        let prims = self.prims;
        (0..prims.slots()).filter_map(move |slot| Some((prims.id(slot), prims.get(slot)?)))
    }

    /// Calls `each` with every node and cell of the structure: for those who measure or draw it.
    pub fn parts(&self, mut each: impl FnMut(Part)) {
        self.structure.parts(&self.prims, self.place.bounds, &mut each);
    }
}

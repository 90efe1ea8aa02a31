//! The promises of a scene, held against it one ray at a time.
use flashray::blob::prims::{Primitive, Prims, REF_BITS};
use flashray::blob::write::{Facts, Layout, Writer};
use flashray::blob::{Blob, Buffer, MAX_STACK, Section};
use flashray::walk::Isa;
use flashray::{Hit, Kind, Ray, Scene};

/// More fuel than any walk of an honest small blob takes, and little enough to see a loop at once.
const FUEL: u32 = 10_000;

/// Asks a scene whose bytes nobody checked. It may answer anything; it must answer.
pub fn survive(scene: &Scene<'_>, ray: &Ray) {
    // A block of voxels is one step until a walk sees that it has any: then it is 64 parts more.
    let (mut parts, most) = (0, 65 * u64::from(scene.limits().steps) + 1);
    scene.parts(|_| parts += 1);
    assert!(parts <= most, "{parts} parts are told of, and there are {most} at most");
    let hit = scene.closest_hit(ray);
    if let Some(hit) = hit {
        assert!(hit.t >= ray.t_min && hit.t <= ray.t_max && hit.t.is_finite(), "{hit:?} is outside of {ray:?}");
    }
    let _ = scene.any_hit(ray);
    let _ = scene.closest_hit_within(ray, FUEL);
    let (counted, steps) = scene.closest_hit_counted(ray);
    assert!(same(hit, counted), "counting changed the answer from {hit:?} to {counted:?} for {ray:?}");
    // The step that can not be paid is counted too: at most a leaf of a hierarchy, or a list of all references. The
    // steps of the header are true even here.
    let spent = u64::from(steps.nodes) + u64::from(steps.prims);
    let limit = u64::from(scene.limits().steps);
    let most = limit + if matches!(scene.kind(), Kind::List | Kind::Bvh) { 15 } else { limit.max(15) };
    assert!(spent <= most, "{steps:?} is beyond {most} for {ray:?}");
}

/// Rays from where one is, so near to each other that they make a group: it twice, and in each octant.
fn group(ray: &Ray) -> [Ray; 10] {
    std::array::from_fn(|i| {
        let sign = |k: usize| if i < 8 && i >> k & 1 == 1 { -1.0 } else { 1.0 };
        Ray { dir: [ray.dir[0] * sign(0), ray.dir[1] * sign(1), ray.dir[2] * sign(2)], ..*ray }
    })
}

/// Asks a scene whose bytes nobody checked about a group, with every instruction set.
pub fn survive_group(scene: &Scene<'_>, ray: &Ray) {
    let rays = group(ray);
    for isa in Isa::all() {
        let (mut hits, mut any) = ([None::<Hit>; 10], [false; 10]);
        scene.with_isa(isa).closest_hits(&rays, &mut hits);
        scene.with_isa(isa).any_hits(&rays, &mut any);
        for hit in hits.iter().flatten() {
            assert!(hit.t >= ray.t_min && hit.t <= ray.t_max && hit.t.is_finite(), "{hit:?} is outside of {ray:?}");
        }
    }
}

/// Bit for bit.
pub fn same(a: Option<Hit>, b: Option<Hit>) -> bool {
    let bits = |h: Hit| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.prim];
    a.map(bits) == b.map(bits)
}

/// Whether a ray can meet anything at all.
fn sane(ray: &Ray) -> bool {
    let finite = |p: [f32; 3]| p.iter().all(|x| x.is_finite());
    finite(ray.origin) && finite(ray.dir) && ray.dir != [0.0; 3] && ray.t_min <= ray.t_max
}

/// A scene whose bytes were checked, with the list over its own primitives: the oracle.
pub struct Judge<'a> {
    /// The scene that is judged.
    pub scene: Scene<'a>,
    prims: Prims<'a>,
    list: Buffer,
    unique: bool,
}

impl<'a> Judge<'a> {
    /// A judge of `scene`, which was loaded from `bytes` with the full check.
    pub fn new(scene: Scene<'a>, bytes: &'a [u8]) -> Self {
        let blob = Blob::parse(bytes).expect("an accepted blob can be parsed");
        let prims = Prims::parse(&blob).expect("an accepted blob has primitives");
        let limits = scene.limits();
        let most = if scene.kind() == Kind::Wide { flashray::wide::STACK } else { MAX_STACK };
        assert!(limits.stack <= most, "{limits:?} is beyond the library's stack");
        steps_fit(&scene);
        let mut ids: Vec<_> = scene.primitives().map(|(id, _)| id).collect();
        assert_eq!(ids.len(), prims.len as usize, "as many primitives as the header says");
        ids.sort_unstable();
        assert!(ids.last().is_none_or(|&id| id < prims.len), "a number beyond the primitives was accepted: {ids:?}");
        let unique = ids.windows(2).all(|w| w[0] != w[1]);
        let list = list(&scene, &prims);
        assert!(Scene::from_bytes(&list).is_ok(), "the list over the primitives of an accepted blob is accepted");
        Self { scene, prims, list, unique }
    }

    /// Holds every promise for one ray.
    pub fn judge(&self, ray: &Ray) {
        let list = Scene::trust(&self.list).expect("the list was checked");
        let hit = self.hold(ray);
        let oracle = list.closest_hit(ray);
        assert!(self.equal(oracle, hit, ray), "the list answers {oracle:?}, this scene {hit:?} for {ray:?}");
        assert_eq!(list.any_hit(ray), hit.is_some(), "the list and the scene differ about any hit of {ray:?}");
        if let Some(hit) = hit {
            self.trim(ray, hit);
        }
    }

    /// Rays together are answered as each alone is, with every instruction set.
    pub fn judge_group(&self, ray: &Ray) {
        let rays = group(ray);
        for isa in Isa::all() {
            let (mut hits, mut any) = ([None; 10], [false; 10]);
            self.scene.with_isa(isa).closest_hits(&rays, &mut hits);
            self.scene.with_isa(isa).any_hits(&rays, &mut any);
            for ((ray, hit), any) in rays.iter().zip(hits).zip(any) {
                let alone = self.scene.closest_hit(ray);
                assert!(self.equal(alone, hit, ray), "{isa:?}: alone {alone:?}, in a group {hit:?} for {ray:?}");
                assert_eq!(any, alone.is_some(), "{isa:?}: any hit in a group for {ray:?}");
            }
        }
    }

    /// What must be so whatever the oracle says. Returns the closest hit.
    fn hold(&self, ray: &Ray) -> Option<Hit> {
        let (scene, limits) = (&self.scene, self.scene.limits());
        let hit = scene.closest_hit(ray);
        let within = scene.closest_hit_within(ray, limits.steps);
        assert!(within.is_ok_and(|h| same(h, hit)), "within {limits:?}: {within:?}, not {hit:?}, for {ray:?}");
        let (counted, steps) = scene.closest_hit_counted(ray);
        assert!(same(counted, hit), "counted: {counted:?}, not {hit:?}, for {ray:?}");
        assert!(steps.nodes + steps.prims <= limits.steps, "{steps:?} is beyond {limits:?} for {ray:?}");
        assert_eq!(scene.any_hit(ray), hit.is_some(), "any and closest differ, {hit:?}, for {ray:?}");
        let found = hit?;
        assert!(sane(ray), "a ray that makes no sense met {found:?}: {ray:?}");
        assert!(found.t >= ray.t_min && found.t <= ray.t_max, "{found:?} is outside of {ray:?}");
        assert!(found.t.is_finite() && found.t.to_bits() != (-0.0f32).to_bits(), "{found:?} has no proper t, {ray:?}");
        let weight = |x: f32| (0.0..=1.0).contains(&x) && x.to_bits() != (-0.0f32).to_bits();
        assert!(weight(found.u) && weight(found.v), "{found:?} has no proper weights, {ray:?}");
        assert!(found.prim < scene.len(), "{found:?} is no primitive, {ray:?}");
        hit
    }

    /// The interval cut at the hit: both its ends are included, and nothing is nearer.
    fn trim(&self, ray: &Ray, hit: Hit) {
        for (t_min, t_max) in [(hit.t, hit.t), (ray.t_min, hit.t), (hit.t, ray.t_max)] {
            let cut = ray.within(t_min, t_max);
            let again = self.scene.closest_hit(&cut);
            assert!(self.equal(Some(hit), again, ray), "{hit:?} became {again:?} when cut to {cut:?}");
        }
        let nearer = ray.within(ray.t_min, hit.t.next_down());
        let none = self.scene.closest_hit(&nearer);
        assert!(none.is_none(), "{hit:?} was not the closest: {none:?} for {nearer:?}");
    }

    /// Bit for bit, but where several primitives have one number and are met at one `t`, either's weights will do:
    /// the check asks of numbers only that they are in range.
    fn equal(&self, a: Option<Hit>, b: Option<Hit>, ray: &Ray) -> bool {
        let (Some(x), Some(y)) = (a, b) else { return same(a, b) };
        if self.unique || same(a, b) {
            return same(a, b);
        }
        x.t.to_bits() == y.t.to_bits() && x.prim == y.prim && self.explained(x, ray) && self.explained(y, ray)
    }

    /// Whether some primitive with the hit's number alone gives this very hit.
    fn explained(&self, hit: Hit, ray: &Ray) -> bool {
        let slots = (0..self.prims.len).filter(|&slot| self.prims.id(slot) == hit.prim);
        slots.into_iter().any(|slot| {
            let Some(alone) = single(&self.scene, &self.prims, slot) else { return false };
            let scene = Scene::trust(&alone).expect("a list of one can be parsed");
            same(scene.closest_hit(&ray.within(hit.t, hit.t)), Some(hit))
        })
    }
}

/// The most steps are those of all nodes or cells, and of all that they list; leaves of a hierarchy cost no step.
fn steps_fit(scene: &Scene<'_>) {
    let (mut parts, mut listed, steps) = (0, 0, scene.limits().steps);
    scene.parts(|part| {
        parts += 1;
        listed += part.listed.unwrap_or(0);
    });
    assert!(listed >= scene.len(), "{} of {} primitives are listed", listed, scene.len());
    // Of a voxel's block the empty cells are steps, and no parts.
    let most = listed + if scene.kind() == Kind::Voxel { 64 * parts } else { parts };
    assert!((listed..=most).contains(&steps), "{steps} steps of {parts} parts that list {listed}");
    if let Some(view) = scene.bvh() {
        assert_eq!(steps, view.nodes.len() as u32 + scene.len(), "the most steps are all nodes and all primitives");
    }
}

fn start<'l, 'o>(layout: &'l Layout, out: &'o mut Buffer, scene: &Scene<'_>, prims: u32) -> Writer<'l, 'o> {
    let (bounds, local) = (scene.bounds(), scene.local_origin());
    let longest = scene.longest_side();
    let facts = Facts { kind: Kind::List, prims, stack: 0, steps: prims, bounds, local, longest };
    layout.start(out, &facts).expect("the buffer is as long as the layout")
}

/// The list over the primitives of a scene, in its slots, with its numbers, bounds, local origin and longest side.
fn list(scene: &Scene<'_>, p: &Prims<'_>) -> Buffer {
    let size = |n: usize| n as u32;
    // Blocks are taken apart.
    let blocked = |(id, p)| if let Primitive::Triangle(t) = p { Some((id, t)) } else { None };
    let apart: Vec<_> = if p.blocks.is_empty() { Vec::new() } else { scene.primitives().filter_map(blocked).collect() };
    let sections = [
        (Section::Triangles, size(p.triangles.len() + apart.len()), 36),
        (Section::Spheres, size(p.spheres.len()), 16),
        (Section::Boxes, size(p.boxes.len()), 24),
        (Section::Cylinders, size(p.cylinders.len()), 32),
        (Section::Cones, size(p.cones.len()), 36),
        (Section::Refs, size(p.refs.len()), 4),
        (Section::Ids, size(p.ids.len() + apart.len()), 4),
    ];
    let layout = Layout::new(&sections).expect("the list is no longer than the blob");
    let mut out = Buffer::zeroed(layout.len());
    let mut writer = start(&layout, &mut out, scene, p.len);
    writer.section(Section::Triangles, p.triangles.iter().copied().chain(apart.iter().map(|(_, t)| *t)));
    writer.section(Section::Spheres, p.spheres.iter().copied());
    writer.section(Section::Boxes, p.boxes.iter().copied());
    writer.section(Section::Cylinders, p.cylinders.iter().copied());
    writer.section(Section::Cones, p.cones.iter().copied());
    writer.section(Section::Refs, p.refs.iter().copied());
    writer.section(Section::Ids, p.ids.iter().copied().chain(apart.iter().map(|(id, _)| *id)));
    let _ = writer.finish();
    out
}

/// The list of one primitive under its own number, which is out of range there: to be trusted, not checked.
fn single(scene: &Scene<'_>, p: &Prims<'_>, slot: u32) -> Option<Buffer> {
    let primitive = p.get(slot)?;
    let (section, size, kind) = match primitive {
        Primitive::Triangle(_) => (Section::Triangles, 36, 0),
        Primitive::Sphere(_) => (Section::Spheres, 16, 1),
        Primitive::Box(_) => (Section::Boxes, 24, 2),
        Primitive::Cylinder(_) => (Section::Cylinders, 32, 3),
        Primitive::Cone(_) => (Section::Cones, 36, 4),
        _ => return None,
    };
    let refs = u32::from(kind > 0);
    let layout = Layout::new(&[(section, 1, size), (Section::Refs, refs, 4), (Section::Ids, 1, 4)])?;
    let mut out = Buffer::zeroed(layout.len());
    let mut writer = start(&layout, &mut out, scene, 1);
    match primitive {
        Primitive::Triangle(p) => writer.section(section, [p].into_iter()),
        Primitive::Sphere(p) => writer.section(section, [p].into_iter()),
        Primitive::Box(p) => writer.section(section, [p].into_iter()),
        Primitive::Cylinder(p) => writer.section(section, [p].into_iter()),
        Primitive::Cone(p) => writer.section(section, [p].into_iter()),
        _ => return None,
    }
    writer.section(Section::Refs, [kind << REF_BITS].into_iter());
    writer.section(Section::Ids, [p.id(slot)].into_iter());
    let _ = writer.finish();
    Some(out)
}

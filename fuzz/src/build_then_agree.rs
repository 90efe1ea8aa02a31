//! Arbitrary soup, every structure and rule against the list, bit for bit.
//!
//! Data: how to build, four rays, then the soup.
use crate::good::builds;
use crate::judge::{Judge, same};
use crate::rays::{Number, Spec, specs};
use arbitrary::{Arbitrary, Result, Unstructured};
use flashray::blob::Buffer;
use flashray::build::{Arena, BuildError, Config, Mesh, Needs, Ref, What, into, to_vec};
use flashray::bvh::Node;
use flashray::{Aabb, Cone, Cylinder, Hit, Ray, Scene, Sphere};
use std::cell::RefCell;
use std::sync::atomic::{AtomicU32, Ordering};

/// Rays of one run.
const RAYS: usize = 4;
/// Most primitives of a soup.
const PRIMS: usize = 64;
/// Room in the arenas for nodes, for words of cells and for words of what they list.
const NODES: usize = 2 * PRIMS;
/// Room for references: a structure that parts space may want several of a primitive.
const REFS: usize = 8 * PRIMS;
const WORDS: usize = 1 << 15;
/// Most cells along an axis that are asked for; 0 leaves it to the builder.
const CELLS: u8 = 12;

/// Builds in arenas, and how many more wanted larger ones than there are.
pub static ARENAS: [AtomicU32; 2] = [AtomicU32::new(0), AtomicU32::new(0)];

thread_local! {
    /// The same for all builds: what one has left behind must not show in the next.
    static MEMORY: RefCell<Memory<NODES, WORDS>> = const { RefCell::new(Memory::new()) };
}

/// What an arena borrows.
struct Memory<const NODES: usize, const WORDS: usize> {
    refs: heapless::Vec<Ref, REFS>,
    nodes: heapless::Vec<Node, NODES>,
    cells: heapless::Vec<u32, WORDS>,
    slots: heapless::Vec<u32, WORDS>,
}

impl<const NODES: usize, const WORDS: usize> Memory<NODES, WORDS> {
    const fn new() -> Self {
        Self {
            refs: heapless::Vec::new(),
            nodes: heapless::Vec::new(),
            cells: heapless::Vec::new(),
            slots: heapless::Vec::new(),
        }
    }

    fn arena(&mut self) -> Arena<'_> {
        Arena { refs: &mut self.refs, nodes: &mut self.nodes, cells: &mut self.cells, slots: &mut self.slots }
    }

    /// Whether a build surely has enough of it.
    fn holds(needs: &Needs) -> bool {
        needs.refs <= REFS && needs.nodes <= NODES && needs.cells <= WORDS && needs.slots <= WORDS
    }
}

/// Rays and what the list said to them.
type Answers = Vec<(Ray, Option<Hit>)>;

/// One run.
pub fn run(data: &[u8]) {
    let _ = attempt(&mut Unstructured::new(data));
}

/// How coordinates are made.
#[derive(Arbitrary, Clone, Copy, Debug)]
struct Style {
    /// Low 2 bits: integers of a small grid, shares of 256, or anything; bit 2 scales.
    how: u8,
    scale: i8,
    /// Side of the grid: the smaller, the more coincides.
    side: u8,
}

impl Style {
    fn number(self, u: &mut Unstructured<'_>) -> Result<f32> {
        let scale = if self.how & 4 == 0 { 1.0 } else { f32::from(self.scale).exp2() };
        let x = match self.how & 3 {
            0 | 1 => f32::from(u.arbitrary::<u8>()? % (self.side % 16 + 2)),
            2 => f32::from(u.arbitrary::<i16>()?) / 256.0,
            _ => return Ok(u.arbitrary::<Number>()?.finite()),
        };
        Ok(x * scale)
    }

    fn point(self, u: &mut Unstructured<'_>) -> Result<[f32; 3]> {
        Ok([self.number(u)?, self.number(u)?, self.number(u)?])
    }

    fn radius(self, u: &mut Unstructured<'_>) -> Result<f32> {
        Ok(self.number(u)?.abs())
    }
}

/// What a mesh borrows.
#[derive(Debug, Default)]
struct Soup {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    spheres: Vec<Sphere>,
    boxes: Vec<Aabb>,
    cylinders: Vec<Cylinder>,
    cones: Vec<Cone>,
}

impl Soup {
    fn new(u: &mut Unstructured<'_>, style: Style) -> Result<Self> {
        let mut soup = Self::default();
        let vertices = usize::from(u.arbitrary::<u8>()? % 32);
        for _ in 0..vertices {
            soup.positions.push(style.point(u)?);
        }
        for _ in 0..PRIMS {
            if u.is_empty() {
                break;
            }
            soup.primitive(u, style)?;
        }
        Ok(soup)
    }

    fn primitive(&mut self, u: &mut Unstructured<'_>, style: Style) -> Result<()> {
        let tag = u.arbitrary::<u8>()?;
        let caps = u32::from(tag >> 4 & 1);
        match tag % 16 {
            0 => self.spheres.push(Sphere { center: style.point(u)?, radius: style.radius(u)? }),
            1 => self.boxes.push(Aabb::EMPTY.with(style.point(u)?).with(style.point(u)?)),
            2 => {
                let (base, top) = (style.point(u)?, style.point(u)?);
                self.cylinders.push(Cylinder { base, top, radius: style.radius(u)?, caps });
            }
            3 => {
                let (base, top) = (style.point(u)?, style.point(u)?);
                let (base_radius, top_radius) = (style.radius(u)?, style.radius(u)?);
                self.cones.push(Cone { base, top, base_radius, top_radius, caps });
            }
            // A triangle of its own, so that long thin data still make big soups of shared vertices below.
            4 => {
                let first = self.positions.len() as u32;
                self.positions.extend([style.point(u)?, style.point(u)?, style.point(u)?]);
                self.triangles.push([first, first + 1, first + 2]);
            }
            _ => {
                let n = self.positions.len().max(1) as u32;
                self.triangles.push(u.arbitrary::<[u8; 3]>()?.map(|i| u32::from(i) % n));
            }
        }
        Ok(())
    }

    fn mesh(&self) -> Mesh<'_> {
        let mesh = Mesh::new(&self.positions, &self.triangles).spheres(&self.spheres);
        mesh.boxes(&self.boxes).cylinders(&self.cylinders).cones(&self.cones)
    }
}

fn attempt(u: &mut Unstructured<'_>) -> Result<()> {
    let leaf = u32::from(u.arbitrary::<u8>()? % 18);
    let flags = u.arbitrary::<u8>()?;
    let cells = if flags & 96 == 0 { u32::from(u.arbitrary::<u8>()? % (CELLS + 1)) } else { 0 };
    let local = if flags & 3 == 1 { u.arbitrary::<[Number; 3]>()?.map(|n| n.0) } else { [0.0; 3] };
    let style: Style = u.arbitrary()?;
    let rays = specs(u, RAYS)?;
    let soup = Soup::new(u, style)?;
    let mesh = soup.mesh();
    let config = |build: Config| build.leaf(leaf).cells(cells).local(local);
    let blobs: Vec<_> = builds().map(|build| to_vec(&mesh, &config(build))).collect();
    let mut first: Option<Answers> = None;
    for (build, blob) in builds().zip(&blobs) {
        // Two more builds each, for a share of the runs: they cost as much as all the rest.
        arenas(&mesh, &config(build), blob, flags & 12 == 0);
        match blob {
            Ok(blob) => agree(&Buffer::from(&blob[..]), &rays, &mut first, build),
            Err(error) => {
                let same = blobs.iter().all(|b| b.as_ref().err() == Some(error));
                assert!(same, "{error:?} should not depend on the structure");
            }
        }
    }
    Ok(())
}

/// A built blob is accepted, keeps its promises, and answers as the first structure, the list, did.
fn agree(blob: &[u8], specs: &[Spec], first: &mut Option<Answers>, build: Config) {
    let scene = Scene::from_bytes(blob).unwrap_or_else(|e| panic!("{build:?} was built and then refused: {e}"));
    let judge = Judge::new(scene, blob);
    let asked = first.get_or_insert_with(|| {
        let rays = specs.iter().map(|spec| spec.ray(&scene));
        rays.map(|ray| (ray, scene.closest_hit(&ray))).collect()
    });
    let (rays, truth): (Vec<_>, Vec<_>) = asked.iter().copied().unzip();
    let (mut hits, mut any) = (vec![None; rays.len()], vec![false; rays.len()]);
    scene.closest_hits(&rays, &mut hits);
    scene.any_hits(&rays, &mut any);
    for (i, ray) in rays.iter().enumerate() {
        judge.judge(ray);
        judge.judge_group(ray);
        let (truth, hit) = (truth[i], scene.closest_hit(ray));
        assert!(same(truth, hit), "the list answers {truth:?}, {build:?} {hit:?} for {ray:?}");
        assert!(same(hits[i], hit), "many rays: {:?}, one ray: {hit:?}, {build:?}, for {ray:?}", hits[i]);
        assert_eq!(any[i], hit.is_some(), "many rays, any hit, {build:?}, for {ray:?}");
    }
}

/// The builder without a heap: the same bytes or the same error, and too little memory is said and harms nothing.
fn arenas(mesh: &Mesh<'_>, config: &Config, expected: &std::result::Result<Vec<u8>, BuildError>, narrow: bool) {
    let needs = match Needs::new(mesh, config) {
        Ok(needs) => needs,
        Err(error) => return assert_eq!(expected.as_ref().err(), Some(&error), "needs and build, {config:?}"),
    };
    let enough = Memory::<NODES, WORDS>::holds(&needs);
    ARENAS[usize::from(!enough)].fetch_add(1, Ordering::Relaxed);
    if !enough {
        return;
    }
    MEMORY.with_borrow_mut(|memory| {
        let arena = &mut memory.arena();
        let mut out = Buffer::zeroed(needs.bytes + 64);
        let built = into(mesh, config, arena, &mut out);
        assert_eq!(built, expected.as_deref().map_err(|e| *e), "the arena's bytes are not those of to_vec, {config:?}");
        let Ok(blob) = expected else { return };
        assert!(blob.len() <= needs.bytes, "the needs were {needs:?}, the blob took {}", blob.len());
        if narrow {
            short(mesh, config, arena, blob);
            small(mesh, config, blob, needs);
        }
    });
}

/// An output buffer that is one byte too short is left alone.
fn short(mesh: &Mesh<'_>, config: &Config, arena: &mut Arena<'_>, blob: &[u8]) {
    let mut short = vec![0xa5; blob.len() - 1];
    let full = into(mesh, config, arena, &mut short);
    let needed = matches!(full, Err(BuildError::Full { needed, .. }) if needed == blob.len());
    assert!(needed, "a buffer that is 1 byte short: {full:?}");
    assert!(short == vec![0xa5; short.len()], "a refused buffer was written to");
}

/// An arena that may be too small for nodes, cells or lists: the same bytes, or what would be enough.
fn small(mesh: &Mesh<'_>, config: &Config, blob: &[u8], needs: Needs) {
    const ROOM: usize = 4;
    let mut memory = Memory::<ROOM, ROOM>::new();
    let mut out = vec![0; blob.len()];
    match into(mesh, config, &mut memory.arena(), &mut out) {
        Ok(built) => assert_eq!(built, blob, "a small arena changed the bytes, {config:?}"),
        Err(BuildError::Full { what, needed, had }) => {
            let most = match what {
                What::Nodes => needs.nodes,
                What::Cells => needs.cells,
                What::Slots => needs.slots,
                _ => panic!("{what:?} were not too small, {config:?}"),
            };
            assert!(had == ROOM && needed > ROOM && needed <= most, "{what:?}: {needed} of {had}, {needs:?}");
            assert!(out == vec![0; out.len()], "a failed build wrote");
        }
        Err(error) => panic!("a small arena turned success into {error:?}"),
    }
}

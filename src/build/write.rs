//! From a finished structure to bytes.
use super::{BuildError, Built, Mesh, Plan, Ref};
use crate::blob::block::Block;
use crate::blob::prims::{Primitive, reference};
use crate::blob::write::Layout;
use crate::blob::{Entry, Kind, Section};
use crate::bvh::Node;
use crate::bvh::build::Tree;
use crate::geom::{Aabb, Cone, Cylinder, Sphere, Triangle};
use crate::num::{count, index};
use crate::{sphere, wide};
use heapless::Vec;

/// Section, entries, bytes of an entry.
type Sections = Vec<(Section, u32, usize), 16>;

/// The sections of a mesh, whose slots have numbers of their own if `ids`.
fn primitive_sections(mesh: &Mesh<'_>, ids: bool) -> Sections {
    let [triangles, spheres, boxes, cylinders, cones] = mesh.counts().map(count);
    let prims = mesh.len().unwrap_or(0);
    let refs = if triangles == prims { 0 } else { prims };
    Sections::from_iter([
        (Section::Triangles, triangles, size_of::<Triangle>()),
        (Section::Spheres, spheres, size_of::<Sphere>()),
        (Section::Boxes, boxes, size_of::<Aabb>()),
        (Section::Cylinders, cylinders, size_of::<Cylinder>()),
        (Section::Cones, cones, size_of::<Cone>()),
        (Section::Refs, refs, size_of::<u32>()),
        (Section::Ids, if ids { prims } else { 0 }, size_of::<u32>()),
    ])
}

/// Whether a mesh has triangles and nothing else, so that they may stand in blocks.
pub(super) fn all_triangles(mesh: &Mesh<'_>) -> bool {
    mesh.counts()[1..] == [0; 4]
}

/// The sections of a mesh under a structure.
pub(super) fn layout(mesh: &Mesh<'_>, built: &Built<'_>) -> Result<Layout, BuildError> {
    // A list keeps the caller's order: its slots are the caller's numbers.
    let mut sections = match built {
        Built::Wide(tree) if all_triangles(mesh) => {
            Sections::from_iter([(Section::Blocks, tree.blocks, size_of::<Block>())])
        }
        _ => primitive_sections(mesh, !matches!(built, Built::List)),
    };
    let mut push = |section, entries, size| sections.push((section, entries, size)).map_err(|_| BuildError::TooLarge);
    match built {
        Built::List => {}
        Built::Bvh(tree) => push(Section::BvhNodes, tree.len, size_of::<Node>())?,
        Built::Wide(tree) => {
            let (section, bytes) = tree.section();
            push(section, tree.len, bytes)?;
        }
        Built::Sphere(tree) => push(Section::SphereNodes, tree.len, size_of::<sphere::Node>())?,
        Built::Parts(parts) => {
            for &(section, words, entry) in &parts.sections {
                push(section, count(words.len() / entry.max(1)), entry * size_of::<u32>())?;
            }
        }
    }
    Layout::new(&sections).ok_or(BuildError::TooLarge)
}

/// The most bytes that a blob with so many nodes or words can take; `usize::MAX` if that is 4 GiB or more.
pub(super) fn most_bytes(mesh: &Mesh<'_>, kind: Kind, nodes: usize, words: usize) -> usize {
    let mut sections = primitive_sections(mesh, kind != Kind::List);
    // One section of all nodes; of the words each section may have a gap before it and an entry in the table.
    let node = if kind == Kind::Sphere { size_of::<sphere::Node>() } else { size_of::<Node>() };
    let _ = sections.push((Section::BvhNodes, count(nodes), node));
    let own = kind.sections().len() * (index(crate::blob::SECTION_ALIGN) + size_of::<Entry>());
    let words = if words > 0 { words.saturating_mul(4).saturating_add(own) } else { 0 };
    Layout::new(&sections).map_or(usize::MAX, |layout| layout.len().saturating_add(words))
}

/// The same for a wide hierarchy over so many binary nodes; each of its own takes `node` bytes.
pub(super) fn most_wide_bytes(mesh: &Mesh<'_>, nodes: usize, node: usize) -> usize {
    let mut sections = primitive_sections(mesh, true);
    if all_triangles(mesh) {
        // At worst each triangle has a block of its own.
        sections = Sections::from_iter([(Section::Blocks, mesh.len().unwrap_or(0), size_of::<Block>())]);
    }
    let _ = sections.push((Section::WideNodes, count(nodes), node));
    Layout::new(&sections).map_or(usize::MAX, |layout| layout.len())
}

impl Plan<'_> {
    /// Writes the blob into the first bytes of `out`; `None`, and nothing written, if `out` is too short.
    pub(super) fn write<'o>(&self, out: &'o mut [u8]) -> Option<&'o [u8]> {
        let mut writer = self.layout.start(out, &self.facts)?;
        macro_rules! only {
            ($kind:ident) => {
                self.primitives().filter_map(|(_, p)| if let Primitive::$kind(p) = p { Some(p) } else { None })
            };
        }
        writer.section(Section::Triangles, only!(Triangle));
        writer.section(Section::Spheres, only!(Sphere));
        writer.section(Section::Boxes, only!(Box));
        writer.section(Section::Cylinders, only!(Cylinder));
        writer.section(Section::Cones, only!(Cone));
        let mut next = [0u32; 8];
        writer.section(
            Section::Refs,
            self.primitives().map(|(kind, _)| {
                let at = &mut next[index(kind & 7)];
                *at += 1;
                reference(kind, *at - 1)
            }),
        );
        writer.section(Section::Ids, self.order());
        match &self.built {
            Built::List => {}
            Built::Bvh(tree) => writer.section(Section::BvhNodes, tree.nodes()),
            Built::Wide(tree) => {
                let [blocks, nodes] = writer.places(Section::Blocks, tree.section().0);
                tree.write(nodes, blocks, |prim| self.input.triangle(prim).unwrap_or(Triangle { v: [[0.0; 3]; 3] }));
            }
            Built::Sphere(tree) => writer.section(Section::SphereNodes, sphere::build::nodes(*tree)),
            Built::Parts(parts) => {
                for &(section, words, _) in &parts.sections {
                    writer.section(section, words.iter().copied());
                }
            }
        }
        Some(writer.finish())
    }

    /// The caller's numbers in slot order.
    fn order(&self) -> impl Iterator<Item = u32> {
        let (list, tree, wide, parts): (_, _, _, &[u32]) = match &self.built {
            Built::List => (0..self.facts.prims, None, None, &[]),
            Built::Bvh(tree) | Built::Sphere(tree) => (0..0, Some(*tree), None, &[]),
            Built::Wide(tree) => (0..0, None, Some(*tree), &[]),
            Built::Parts(parts) => (0..0, None, None, parts.order),
        };
        let number = |r: &Ref| r.prim;
        let trees = tree.into_iter().flat_map(Tree::refs).chain(wide.into_iter().flat_map(wide::build::Tree::refs));
        list.chain(trees.map(number)).chain(parts.iter().copied())
    }

    /// The primitives in slot order with the numbers of their kinds.
    fn primitives(&self) -> impl Iterator<Item = (u32, Primitive)> {
        self.order().map(|prim| self.input.get(prim))
    }
}

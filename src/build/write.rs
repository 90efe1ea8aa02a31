//! From a finished structure to bytes.
use super::{BuildError, Built, Mesh, Plan, Ref};
use crate::blob::prims::{Primitive, reference};
use crate::blob::write::Layout;
use crate::blob::{Kind, Section};
use crate::bvh::Node;
use crate::bvh::build::Tree;
use crate::geom::{Aabb, Cone, Cylinder, Sphere, Triangle};
use crate::num::{count, index};

/// The sections of a mesh under a structure with so many nodes.
pub(super) fn layout(mesh: &Mesh<'_>, nodes: u32, kind: Kind) -> Result<Layout, BuildError> {
    let prims = mesh.len()?;
    let [triangles, spheres, boxes, cylinders, cones] = mesh.counts().map(count);
    let refs = if triangles == prims { 0 } else { prims };
    // A list keeps the caller's order: its slots are the caller's numbers.
    let ids = if kind == Kind::List { 0 } else { prims };
    let sections = [
        (Section::Triangles, triangles, size_of::<Triangle>()),
        (Section::Spheres, spheres, size_of::<Sphere>()),
        (Section::Boxes, boxes, size_of::<Aabb>()),
        (Section::Cylinders, cylinders, size_of::<Cylinder>()),
        (Section::Cones, cones, size_of::<Cone>()),
        (Section::Refs, refs, size_of::<u32>()),
        (Section::Ids, ids, size_of::<u32>()),
        (Section::BvhNodes, nodes, size_of::<Node>()),
    ];
    Layout::new(&sections).ok_or(BuildError::TooLarge)
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
        writer.section(Section::Ids, self.refs().map(|r| r.prim));
        if let Built::Bvh(tree) = self.built {
            writer.section(Section::BvhNodes, tree.nodes());
        }
        Some(writer.finish())
    }

    /// The references in slot order.
    fn refs(&self) -> impl Iterator<Item = &Ref> {
        let (list, tree) = match self.built {
            Built::List(refs) => (Some(refs), None),
            Built::Bvh(tree) => (None, Some(tree)),
        };
        list.into_iter().flatten().chain(tree.into_iter().flat_map(Tree::refs))
    }

    /// The primitives in slot order with the numbers of their kinds; the mesh was checked when the references were made.
    fn primitives(&self) -> impl Iterator<Item = (u32, Primitive)> {
        self.refs().filter_map(|r| self.mesh.get(r.prim, self.facts.local).ok())
    }
}

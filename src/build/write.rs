//! From a finished structure to bytes.
use super::{BuildError, Config, Mesh, Plan, Ref};
use crate::blob::prims::{Primitive, reference};
use crate::blob::write::{Facts, Layout};
use crate::blob::{Kind, Section};
use crate::bvh::Node;
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

pub(super) fn facts(config: &Config, prims: usize, bounds: Aabb, (stack, steps): (u32, u32)) -> Facts {
    Facts { kind: config.kind, prims: count(prims), stack, steps, bounds, local: config.local }
}

impl Plan<'_> {
    /// Writes the blob into the first bytes of `out`; `None`, and nothing written, if `out` is too short.
    pub(super) fn write<'o>(&self, out: &'o mut [u8]) -> Option<&'o [u8]> {
        let mut writer = self.layout.start(out, &self.facts)?;
        writer.section(
            Section::Triangles,
            self.primitives().filter_map(|p| match p {
                Primitive::Triangle(p) => Some(p),
                _ => None,
            }),
        );
        writer.section(
            Section::Spheres,
            self.primitives().filter_map(|p| match p {
                Primitive::Sphere(p) => Some(p),
                _ => None,
            }),
        );
        writer.section(
            Section::Boxes,
            self.primitives().filter_map(|p| match p {
                Primitive::Box(p) => Some(p),
                _ => None,
            }),
        );
        writer.section(
            Section::Cylinders,
            self.primitives().filter_map(|p| match p {
                Primitive::Cylinder(p) => Some(p),
                _ => None,
            }),
        );
        writer.section(
            Section::Cones,
            self.primitives().filter_map(|p| match p {
                Primitive::Cone(p) => Some(p),
                _ => None,
            }),
        );
        let mut next = [0u32; 8];
        writer.section(
            Section::Refs,
            self.kinds().map(|kind| {
                let at = &mut next[index(kind & 7)];
                *at += 1;
                reference(kind, *at - 1)
            }),
        );
        writer.section(Section::Ids, self.refs.iter().map(|r| r.prim));
        writer.section(Section::BvhNodes, self.nodes.iter().copied());
        Some(writer.finish())
    }

    /// The primitives in slot order; the mesh was checked when the references were filled.
    fn primitives(&self) -> impl Iterator<Item = Primitive> {
        self.refs.iter().filter_map(|r: &Ref| Some(self.mesh.get(r.prim, self.facts.local).ok()?.1))
    }

    /// The numbers of their kinds.
    fn kinds(&self) -> impl Iterator<Item = u32> {
        self.refs.iter().filter_map(|r: &Ref| Some(self.mesh.get(r.prim, self.facts.local).ok()?.0))
    }
}

//! What a structure consists of, told from bytes that nobody checked: there is an end to it.
use crate::blobs::{Break, edit, entries};
use crate::common::meshes::mixed;
use crate::common::rays::Random;
use crate::common::{build, configs};
use crate::wide;
use flashray::blob::{Buffer, Section};
use flashray::build::Config;
use flashray::bvh::Child;
use flashray::{Kind, Scene, bsp, bvh, nested, octree, sphere};

/// Counts the parts of a trusted blob; `None` if not even that much of it is good.
fn told(bytes: &[u8], what: &str) -> Option<u64> {
    let bytes = Buffer::from(bytes);
    let scene = Scene::trust(&bytes).ok()?;
    // A block of voxels is one step until a walk sees that it has any: then it is 64 parts more.
    let (mut parts, most) = (0, 65 * u64::from(scene.limits().steps) + 1);
    scene.parts(|_| {
        parts += 1;
        assert!(parts <= most, "{what}: more than {most} parts");
    });
    Some(parts)
}

#[test]
fn parts_end_where_nodes_go_round_in_circles() {
    let circles: [(Kind, Break); 6] = [
        (Kind::Bvh, |b| edit::<bvh::Node>(b, Section::BvhNodes, 0, |n| n.child = [Child::node(0); 2])),
        (Kind::Sphere, |b| edit::<sphere::Node>(b, Section::SphereNodes, 0, |n| n.child = [Child::node(0); 2])),
        (Kind::Octree, |b| edit::<octree::Node>(b, Section::OctreeNodes, 0, |n| (n.first, n.inner) = (0, 0xff))),
        (Kind::Bsp, |b| edit::<bsp::Node>(b, Section::BspNodes, 0, |n| n.word &= 3)),
        (Kind::Nested, |b| edit::<nested::Grid>(b, Section::NestedGrids, 1, |n| n.first = 0)),
        (Kind::Wide, |b| wide::eight(b, 1, |n| n.child[..2].fill(Child::node(1)))),
    ];
    for (kind, circle) in circles {
        let mut bytes = build(&mixed(200, 1), &Config::new(kind).leaf(2)).to_vec();
        circle(&mut bytes);
        assert!(told(&bytes, kind.name()).is_some_and(|parts| parts > 0), "{}", kind.name());
    }
}

#[test]
fn parts_end_whatever_the_words() {
    let mut random = Random::new(5);
    for config in configs() {
        let good = build(&mixed(60, 1), &config).to_vec();
        let own = |section: u32| config.kind.sections().iter().any(|s| s.number() == section);
        for entry in entries(&good).iter().filter(|e| own(e.section)) {
            for _ in 0..60 {
                let mut bytes = good.clone();
                let at = entry.offset as usize + 4 * random.below(entry.length as usize / 4);
                let old = u32::from_le_bytes([0, 1, 2, 3].map(|i| good[at + i]));
                let (less, more, any) = (old.wrapping_sub(1), old.wrapping_add(1), random.next());
                let new = [0, 1, less, more, old << 1, !0, any][random.below(7)];
                bytes[at..at + 4].copy_from_slice(&new.to_le_bytes());
                told(&bytes, &format!("{config:?}, {new:#x} for {old:#x} at {at}"));
            }
        }
    }
}

//! Eight-wide hierarchies: what is particular to them.
use crate::blobs::{Break, break_one_by_one, edit, header};
use crate::common::meshes::{icosphere, mixed};
use crate::common::{bits, build};
use flashray::blob::block::Block;
use flashray::blob::{Buffer, Rule, Section};
use flashray::build::Config;
use flashray::bvh::Child;
use flashray::walk::Isa;
use flashray::wide::Node;
use flashray::{Kind, Ray, Scene};

/// A blob of 320 triangles.
fn good() -> Vec<u8> {
    build(&icosphere(2), &Config::new(Kind::Wide)).to_vec()
}

/// A blob of 60 primitives of all kinds, so without blocks.
fn good_mixed() -> Vec<u8> {
    build(&mixed(60, 1), &Config::new(Kind::Wide).leaf(3)).to_vec()
}

/// For each rule about wide nodes and blocks an edit that breaks it and no rule before it.
pub const BREAKS: &[(Rule, Break)] = &[
    (Rule::WideLanes, |b| edit::<Node>(b, Section::WideNodes, 0, |n| n.child[1] = Child::node(0))),
    (Rule::WideLanes, |b| edit::<Node>(b, Section::WideNodes, 0, |n| n.child[2] = Child::node(0))),
    (Rule::NodeBounds, |b| edit::<Node>(b, Section::WideNodes, 0, |n| n.planes[1][1] = n.planes[0][1])),
    (Rule::NodeBounds, |b| edit::<Node>(b, Section::WideNodes, 1, |n| n.planes[2][0] = f32::NAN)),
    (Rule::NodeBounds, |b| edit::<Node>(b, Section::WideNodes, 0, |n| n.planes[5][0] = f32::INFINITY)),
    (Rule::Reserved, |b| edit::<Node>(b, Section::WideNodes, 1, |n| n.reserved[7] = 1)),
    (Rule::NodeOrder, |b| edit::<Node>(b, Section::WideNodes, 0, |n| n.child[0] = Child::node(2))),
    (Rule::NodeOrder, |b| edit::<Node>(b, Section::WideNodes, 0, |n| n.child[0] = Child::node(1 << 27))),
    (Rule::LeafOrder, |b| edit::<Node>(b, Section::WideNodes, 0, |n| n.child[0] = Child::leaf(1, 3))),
    (Rule::BlockLanes, |b| edit::<Block>(b, Section::Blocks, 1, |n| n.ids = [u32::MAX; 4])),
    (Rule::BlockLanes, |b| edit::<Block>(b, Section::Blocks, 1, |n| n.ids[0] = u32::MAX)),
    // The first block has three triangles.
    (Rule::BlockLanes, |b| edit::<Block>(b, Section::Blocks, 0, |n| n.corners[0][0][3] = 1.0)),
    (Rule::IdRange, |b| edit::<Block>(b, Section::Blocks, 2, |n| n.ids[0] = 320)),
    (Rule::PrimShape, |b| edit::<Block>(b, Section::Blocks, 2, |n| n.corners[1][2][0] = f32::NAN)),
    (Rule::PrimBounds, |b| edit::<Block>(b, Section::Blocks, 2, |n| n.corners[0][0][0] = 7.0)),
    (Rule::StackTrue, |b| header(b, |h| h.stack += 1)),
    (Rule::Stack, |b| header(b, |h| h.stack = 193)),
    (Rule::StepsTrue, |b| header(b, |h| h.steps -= 1)),
];

const MIXED_BREAKS: &[(Rule, Break)] = &[
    (Rule::WideLanes, |b| edit::<Node>(b, Section::WideNodes, 0, |n| n.child[1] = Child::node(0))),
    (Rule::LeafOrder, |b| edit::<Node>(b, Section::WideNodes, 0, |n| n.child[0] = Child::leaf(1, 3))),
    (Rule::LeafOrder, |b| edit::<Node>(b, Section::WideNodes, 0, |n| n.child[0] = Child::leaf((1 << 28) - 1, 15))),
    (Rule::StackTrue, |b| header(b, |h| h.stack += 1)),
];

#[test]
fn rules_about_wide_hierarchies_are_broken_one_by_one() {
    break_one_by_one(&good(), BREAKS);
    break_one_by_one(&good_mixed(), MIXED_BREAKS);
}

#[test]
fn every_triangle_is_in_a_block_once() {
    let blob = Buffer::from(&good()[..]);
    let scene = Scene::from_bytes(&blob).expect("a good blob");
    let mut ids: Vec<_> = scene.primitives().map(|(id, _)| id).collect();
    ids.sort_unstable();
    assert_eq!(ids, (0..320).collect::<Vec<_>>());
}

/// A distance of 0 is one whatever its sign, and an origin within the slab test's pad of a plane is in its slab.
#[test]
fn rays_that_start_about_a_plane_hit_what_the_list_hits() {
    let mesh = icosphere(1);
    let [list, wide] = [Kind::List, Kind::Wide].map(|kind| build(&mesh, &Config::new(kind)));
    let [list, wide] = [&list, &wide].map(|blob| Scene::from_bytes(blob).expect("a good blob"));
    let bounds = list.bounds();
    let mut hits = 0;
    for (k, plane) in (0..3).flat_map(|k| [(k, bounds.min[k]), (k, bounds.max[k])]) {
        for step in -300..300i32 {
            let origin: [f32; 3] =
                [0, 1, 2].map(|i| if i == k { f32::from_bits(plane.to_bits().wrapping_add_signed(step)) } else { 0.0 });
            for sign in [-1.0, 1.0] {
                let dir = [0, 1, 2].map(|i| if i == k { sign } else { 1e-3 });
                for ray in [
                    Ray::new(origin, dir),
                    Ray::new(origin, dir).within(-0.0, 0.0),
                    Ray::new(origin, dir).within(0.0, -0.0),
                ] {
                    let truth = list.closest_hit(&ray);
                    hits += u32::from(truth.is_some());
                    for isa in Isa::all() {
                        let scene = wide.with_isa(isa);
                        assert_eq!(bits(scene.closest_hit(&ray)), bits(truth), "{isa:?}, {ray:?}");
                        assert_eq!(scene.any_hit(&ray), truth.is_some(), "{isa:?}, {ray:?}");
                    }
                }
            }
        }
    }
    assert!(hits > 500, "{hits} hits only");
}

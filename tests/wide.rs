//! Eight-wide and four-wide hierarchies: what is particular to them.
use crate::blobs::{Break, break_one_by_one, edit, entries, header};
use crate::common::meshes::{icosphere, mixed};
use crate::common::rays::Random;
use crate::common::{bits, build};
use crate::soup::Soup;
use flashray::blob::block::Block;
use flashray::blob::{Blob, Buffer, Entry, Header, Rule, Section};
use flashray::build::Config;
use flashray::bvh::Child;
use flashray::walk::Isa;
use flashray::wide::{Node, View};
use flashray::{Kind, Ray, Scene};

/// A blob of 320 triangles.
fn good() -> Vec<u8> {
    build(&icosphere(2), &Config::new(Kind::Wide)).to_vec()
}

/// A blob of 60 primitives of all kinds, so without blocks.
fn good_mixed() -> Vec<u8> {
    build(&mixed(60, 1), &Config::new(Kind::Wide).leaf(3)).to_vec()
}

/// The same with nodes of four.
fn good_four() -> Vec<u8> {
    build(&icosphere(2), &Config::new(Kind::Wide).width(4)).to_vec()
}

fn good_mixed_four() -> Vec<u8> {
    build(&mixed(60, 1), &Config::new(Kind::Wide).leaf(3).width(4)).to_vec()
}

/// Blobs of a mesh: the list, nodes of eight and nodes of four.
fn three(mesh: &Soup, local: [f32; 3]) -> [Buffer; 3] {
    let wide = Config::new(Kind::Wide).local(local);
    [Config::new(Kind::List).local(local), wide, wide.width(4)].map(|config| build(mesh, &config))
}

fn scene(blob: &Buffer) -> Scene<'_> {
    Scene::from_bytes(blob).expect("a good blob")
}

/// Asks both widths in every instruction set, ray by ray and all at once, for what the list says. Returns how many hit.
fn agree(blobs: &[Buffer; 3], rays: &[Ray]) -> usize {
    let [list, wide, wide4] = blobs.each_ref().map(scene);
    let truth: Vec<_> = rays.iter().map(|ray| list.closest_hit(ray)).collect();
    for (scene, isa) in Isa::all().flat_map(|isa| [(wide, isa), (wide4, isa)]) {
        let scene = scene.with_isa(isa);
        let (mut together, mut any) = (vec![None; rays.len()], vec![false; rays.len()]);
        scene.closest_hits(rays, &mut together);
        scene.any_hits(rays, &mut any);
        for (((ray, truth), together), any) in rays.iter().zip(&truth).zip(together).zip(any) {
            let within = scene.closest_hit_within(ray, scene.limits().steps);
            assert_eq!(within.map(bits), Ok(bits(*truth)), "{isa:?}, {ray:?}");
            assert_eq!(bits(scene.closest_hit(ray)), bits(*truth), "{isa:?}, {ray:?}");
            assert_eq!(bits(together), bits(*truth), "{isa:?}, many, {ray:?}");
            assert_eq!((scene.any_hit(ray), any), (truth.is_some(), truth.is_some()), "{isa:?}, {ray:?}");
        }
    }
    truth.iter().flatten().count()
}

/// Edits a node of eight.
pub fn eight(bytes: &mut [u8], at: usize, change: impl FnOnce(&mut Node)) {
    edit_node(bytes, Section::WideNodes, at, change);
}

/// Edits a node of four.
fn four(bytes: &mut [u8], at: usize, change: impl FnOnce(&mut Node<4>)) {
    edit_node(bytes, Section::Wide4Nodes, at, change);
}

fn edit_node<const W: usize>(bytes: &mut [u8], section: Section, at: usize, change: impl FnOnce(&mut Node<W>)) {
    edit::<[[u32; W]; 8]>(bytes, section, at, |words| {
        let mut node: Node<W> = bytemuck::pod_read_unaligned(bytemuck::bytes_of(words));
        change(&mut node);
        *words = node.words();
    });
}

/// Puts a section at the end of a blob whose table has room for it before the first section.
fn append(bytes: &mut Vec<u8>, section: Section, contents: &[u8]) {
    let count = entries(bytes).len();
    let entry = Entry { section: section.number(), offset: bytes.len() as u32, length: contents.len() as u32 };
    assert_eq!(bytes.len() % 64, 0, "the blob ends where a section may begin");
    bytes.extend_from_slice(contents);
    let at = size_of::<Header>() + count * size_of::<Entry>();
    bytes[at..at + size_of::<Entry>()].copy_from_slice(bytemuck::bytes_of(&entry));
    let length = bytes.len() as u32;
    header(bytes, |h| (h.sections, h.length) = (h.sections + 1, length));
}

/// For each rule about wide nodes and blocks an edit that breaks it and no rule before it.
pub const BREAKS: &[(Rule, Break)] = &[
    (Rule::WideLanes, |b| eight(b, 0, |n| n.child[1] = Child::node(0))),
    (Rule::WideLanes, |b| eight(b, 0, |n| n.child[2] = Child::node(0))),
    (Rule::NodeBounds, |b| eight(b, 0, |n| n.planes[1][1] = n.planes[0][1])),
    (Rule::NodeBounds, |b| eight(b, 1, |n| n.planes[2][0] = f32::NAN)),
    (Rule::NodeBounds, |b| eight(b, 0, |n| n.planes[5][0] = f32::INFINITY)),
    (Rule::Reserved, |b| eight(b, 1, |n| n.reserved[7] = 1)),
    (Rule::NodeOrder, |b| eight(b, 0, |n| n.child[0] = Child::node(2))),
    (Rule::NodeOrder, |b| eight(b, 0, |n| n.child[0] = Child::node(1 << 27))),
    (Rule::LeafOrder, |b| eight(b, 0, |n| n.child[0] = Child::leaf(1, 3))),
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
    (Rule::WideWidth, |b| append(b, Section::Wide4Nodes, &[0; 128])),
];

const FOUR_BREAKS: &[(Rule, Break)] = &[
    (Rule::WideLanes, |b| four(b, 0, |n| n.child[1] = Child::node(0))),
    (Rule::WideLanes, |b| four(b, 0, |n| n.child[2] = Child::node(0))),
    (Rule::WideLanes, |b| four(b, 0, |n| n.child = [Child::node(0); 4])),
    (Rule::NodeBounds, |b| four(b, 0, |n| n.planes[1][1] = n.planes[0][1])),
    (Rule::NodeBounds, |b| four(b, 1, |n| n.planes[2][0] = f32::NAN)),
    (Rule::NodeBounds, |b| four(b, 0, |n| n.planes[5][3] = f32::INFINITY)),
    (Rule::Reserved, |b| four(b, 1, |n| n.reserved[3] = 1)),
    (Rule::NodeOrder, |b| four(b, 0, |n| n.child[0] = Child::node(2))),
    (Rule::NodeOrder, |b| four(b, 0, |n| n.child[0] = Child::node(1 << 27))),
    (Rule::LeafOrder, |b| four(b, 0, |n| n.child[0] = Child::leaf(1, 3))),
    (Rule::BlockLanes, |b| edit::<Block>(b, Section::Blocks, 1, |n| n.ids = [u32::MAX; 4])),
    (Rule::StackTrue, |b| header(b, |h| h.stack += 1)),
    (Rule::Stack, |b| header(b, |h| h.stack = 193)),
    (Rule::StepsTrue, |b| header(b, |h| h.steps -= 1)),
];

const MIXED_FOUR_BREAKS: &[(Rule, Break)] = &[
    (Rule::WideLanes, |b| four(b, 0, |n| n.child[1] = Child::node(0))),
    (Rule::LeafOrder, |b| four(b, 0, |n| n.child[0] = Child::leaf(1, 3))),
    (Rule::StackTrue, |b| header(b, |h| h.stack += 1)),
];

const MIXED_BREAKS: &[(Rule, Break)] = &[
    (Rule::WideLanes, |b| eight(b, 0, |n| n.child[1] = Child::node(0))),
    (Rule::LeafOrder, |b| eight(b, 0, |n| n.child[0] = Child::leaf(1, 3))),
    (Rule::LeafOrder, |b| eight(b, 0, |n| n.child[0] = Child::leaf((1 << 28) - 1, 15))),
    (Rule::StackTrue, |b| header(b, |h| h.stack += 1)),
];

#[test]
fn rules_about_wide_hierarchies_are_broken_one_by_one() {
    break_one_by_one(&good(), BREAKS);
    break_one_by_one(&good_mixed(), MIXED_BREAKS);
    break_one_by_one(&good_four(), FOUR_BREAKS);
    break_one_by_one(&good_mixed_four(), MIXED_FOUR_BREAKS);
}

#[test]
fn every_triangle_is_in_a_block_once() {
    for (blob, width) in [(good(), 8), (good_four(), 4)] {
        let blob = Buffer::from(&blob[..]);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        assert_eq!(scene.width(), Some(width));
        let mut ids: Vec<_> = scene.primitives().map(|(id, _)| id).collect();
        ids.sort_unstable();
        assert_eq!(ids, (0..320).collect::<Vec<_>>());
    }
}

/// Nodes of a width are read as nodes of that width alone.
#[test]
fn a_view_of_one_width_refuses_the_other() {
    let (eight, four) = (Buffer::from(&good()[..]), Buffer::from(&good_four()[..]));
    let (eight, four) = (Blob::parse(&eight).expect("a good blob"), Blob::parse(&four).expect("a good blob"));
    assert!(View::<8>::parse(&eight).is_ok() && View::<4>::parse(&four).is_ok());
    assert_eq!(View::<4>::parse(&eight).map(|_| ()).map_err(|e| e.rule), Err(Rule::WideWidth));
    assert_eq!(View::<8>::parse(&four).map(|_| ()).map_err(|e| e.rule), Err(Rule::WideWidth));
}

/// A distance of 0 is one whatever its sign, and an origin within the slab test's pad of a plane is in its slab.
#[test]
fn rays_that_start_about_a_plane_hit_what_the_list_hits() {
    let blobs = three(&icosphere(1), [0.0; 3]);
    let bounds = scene(&blobs[0]).bounds();
    let mut rays = vec![];
    for (k, plane) in (0..3).flat_map(|k| [(k, bounds.min[k]), (k, bounds.max[k])]) {
        for step in -300..300i32 {
            let origin: [f32; 3] =
                [0, 1, 2].map(|i| if i == k { f32::from_bits(plane.to_bits().wrapping_add_signed(step)) } else { 0.0 });
            for sign in [-1.0, 1.0] {
                let dir = [0, 1, 2].map(|i| if i == k { sign } else { 1e-3 });
                rays.push(Ray::new(origin, dir));
                rays.push(Ray::new(origin, dir).within(-0.0, 0.0));
                rays.push(Ray::new(origin, dir).within(0.0, -0.0));
            }
        }
    }
    let hits = agree(&blobs, &rays);
    assert!(hits > 500, "{hits} hits only");
}

/// Distances that underflow are 0, or `-0.0` behind the origin, and count.
#[test]
fn distances_that_underflow_are_those_of_the_list() {
    let mut mesh = icosphere(2);
    mesh.positions.iter_mut().flatten().for_each(|x| *x *= 1e-30);
    let blobs = three(&mesh, [0.0; 3]);
    let mut random = Random::new(7);
    let mut number = |size: f32| (random.below(2001) as f32 / 1000.0 - 1.0) * size;
    let mut hits = 0;
    for size in [1.0, 1e5, 1e7, 1e15, 1e30, f32::MAX] {
        // From outside too: what lies behind is at -0.0 then.
        let rays: Vec<_> =
            (0..256).map(|_| Ray::new([(); 3].map(|()| number(1.5e-30)), [(); 3].map(|()| number(size)))).collect();
        hits += agree(&blobs, &rays);
    }
    assert!(hits > 500, "{hits} hits only");
}

/// From an origin so far that the pad of the slab test is infinite, all boxes are met, but no child that is not there.
#[test]
fn rays_from_afar_hit_what_the_list_hits() {
    const SIZE: f32 = 1e36;
    let mut hits = 0;
    for local in [[0.0; 3], [0.9 * f32::MAX, 0.0, 0.0]] {
        let mut mesh = icosphere(1);
        for position in &mut mesh.positions {
            *position = [0, 1, 2].map(|k| position[k] * SIZE + local[k]);
        }
        let blobs = three(&mesh, local);
        let mut random = Random::new(11);
        let mut number = |size: f32| (random.below(2001) as f32 / 1000.0 - 1.0) * size;
        let mut rays = vec![];
        for (far, k) in
            [f32::MAX, 0.6 * f32::MAX, 1e38, 8e37].into_iter().flat_map(|far| [(far, 0), (far, 1), (far, 2)])
        {
            for from in [far, -far] {
                for slope in [0.0, 1e-6, 1e-3] {
                    let origin = [0, 1, 2].map(|i| if i == k { from } else { local[i] + number(SIZE) });
                    let dir = [0, 1, 2].map(|i| if i == k { -from.signum() } else { number(slope) });
                    rays.push(Ray::new(origin, dir));
                    rays.push(Ray::new(origin, dir).within(0.0, 1e12));
                    rays.push(Ray::new(origin, dir.map(|x| x * 4.0)).within(-1.0, f32::MAX));
                }
            }
        }
        hits += agree(&blobs, &rays);
    }
    assert!(hits > 30, "{hits} hits only");
}

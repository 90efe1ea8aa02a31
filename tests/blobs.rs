//! The format: every rule broken by a test of its own, every damaged byte noticed, golden blobs, limits.
use crate::common::meshes::{icosphere, mixed};
use crate::common::{bits, build, configs, mesh};
use crate::soup::Soup;
use crate::{bsp, nested, octree, sphere, voxel};
use flashray::blob::{Buffer, Entry, Header, Rule, Section, crc32};
use flashray::build::{Arena, BuildError, Config, Mesh, Needs, What, into, to_vec};
use flashray::bvh::{Child, Node};
use flashray::grid::Shape;
use flashray::{BlobError, Kind, Ray, Scene, Sphere, Stop};
use std::fs;
use std::path::PathBuf;

pub const HEADER: usize = size_of::<Header>();

/// A blob of 60 primitives of all kinds in a hierarchy.
fn good() -> Vec<u8> {
    build(&mixed(60, 1), &Config::new(Kind::Bvh).leaf(3)).to_vec()
}

pub fn load(bytes: &[u8]) -> Result<(), BlobError> {
    Scene::from_bytes(&Buffer::from(bytes)).map(|_| ())
}

pub fn header(bytes: &mut [u8], edit: impl FnOnce(&mut Header)) {
    let mut header: Header = bytemuck::pod_read_unaligned(&bytes[..HEADER]);
    edit(&mut header);
    bytes[..HEADER].copy_from_slice(bytemuck::bytes_of(&header));
}

pub fn entries(bytes: &[u8]) -> Vec<Entry> {
    let header: Header = bytemuck::pod_read_unaligned(&bytes[..HEADER]);
    bytes[HEADER..HEADER + header.sections as usize * size_of::<Entry>()]
        .chunks_exact(size_of::<Entry>())
        .map(bytemuck::pod_read_unaligned)
        .collect()
}

pub fn set_entry(bytes: &mut [u8], at: usize, edit: impl FnOnce(&mut Entry)) {
    let mut entry = entries(bytes)[at];
    edit(&mut entry);
    let start = HEADER + at * size_of::<Entry>();
    bytes[start..start + size_of::<Entry>()].copy_from_slice(bytemuck::bytes_of(&entry));
}

/// Edits entry `at` of a section.
pub fn edit<T: bytemuck::Pod>(bytes: &mut [u8], section: Section, at: usize, edit: impl FnOnce(&mut T)) {
    let entry = entries(bytes).into_iter().find(|e| e.section == section.number()).expect("the section is there");
    let start = entry.offset as usize + at * size_of::<T>();
    let mut value: T = bytemuck::pod_read_unaligned(&bytes[start..start + size_of::<T>()]);
    edit(&mut value);
    bytes[start..start + size_of::<T>()].copy_from_slice(bytemuck::bytes_of(&value));
}

/// Puts the right length and checksum on edited bytes.
pub fn seal(bytes: &mut [u8]) {
    let sum = crc32(&bytes[16..]);
    header(bytes, |h| h.checksum = sum);
}

pub type Break = fn(&mut Vec<u8>);

/// A blob of 60 primitives of all kinds in a grid of cells for each.
fn good_grid() -> Vec<u8> {
    build(&mixed(60, 1), &Config::new(Kind::Grid).cells(5)).to_vec()
}

/// A section as words.
pub fn words(bytes: &[u8], section: Section) -> Vec<u32> {
    let entry = entries(bytes).into_iter().find(|e| e.section == section.number()).expect("the section is there");
    let words = bytes[entry.offset as usize..][..entry.length as usize].chunks_exact(4);
    words.map(|w| u32::from_le_bytes(w.try_into().expect("4 bytes"))).collect()
}

/// The cell with the longest list, and where that starts and ends.
fn longest_list(bytes: &[u8]) -> (usize, usize, usize) {
    let starts: Vec<usize> = words(bytes, Section::CellStarts).iter().map(|&w| w as usize).collect();
    let cell = (0..starts.len() - 1).max_by_key(|&c| starts[c + 1] - starts[c]).expect("a cell");
    (cell, starts[cell], starts[cell + 1])
}

/// The same for rules about structures that part space.
const GRID_BREAKS: &[(Rule, Break)] = &[
    (Rule::Reserved, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.reserved = 1)),
    (Rule::Lattice, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.cells[0] += 1)),
    (Rule::Lattice, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.cells = [0, s.cells[1], s.cells[2]])),
    (Rule::Lattice, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.lattice.cell[1] = 0.0)),
    (Rule::Lattice, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.lattice.cell[2] = f32::NAN)),
    (Rule::Lattice, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.lattice.min[0] = f32::NEG_INFINITY)),
    (Rule::Lattice, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.lattice.cell[2] *= 0.99)),
    (Rule::Lattice, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.lattice.min[0] += 0.01)),
    (Rule::ListPlace, |b| edit::<u32>(b, Section::CellStarts, 0, |s| *s = 1)),
    (Rule::ListPlace, |b| {
        let (cell, first, last) = longest_list(b);
        edit::<u32>(b, Section::CellStarts, cell, |s| *s = last as u32 + 1);
        assert!(first < last);
    }),
    (Rule::ListPlace, |b| {
        let last = entries(b).iter().find(|e| e.section == Section::CellStarts.number()).expect("starts").length / 4;
        edit::<u32>(b, Section::CellStarts, last as usize - 1, |s| *s += 1);
    }),
    (Rule::ListOrder, |b| {
        let (_, first, _) = longest_list(b);
        edit::<u32>(b, Section::CellLists, first, |s| *s = 60);
    }),
    (Rule::ListOrder, |b| {
        let (_, first, _) = longest_list(b);
        edit::<u32>(b, Section::CellLists, first + 1, |s| *s = 0);
    }),
    // The last of a list goes to the next cell, which lists nothing: what its own cell needed is not there.
    (Rule::ListComplete, |b| {
        let starts = words(b, Section::CellStarts);
        let lonely = |c: &usize| starts[*c] < starts[c + 1] && starts[c + 1] == starts[c + 2];
        let cell = (0..starts.len() - 2).find(lonely).expect("an empty cell after another");
        edit::<u32>(b, Section::CellStarts, cell + 1, |s| *s -= 1);
    }),
    (Rule::StackTrue, |b| header(b, |h| h.stack += 1)),
    (Rule::StepsTrue, |b| header(b, |h| h.steps -= 1)),
];

#[test]
fn rules_about_grids_are_broken_one_by_one() {
    break_one_by_one(&good_grid(), GRID_BREAKS);
}

/// Makes each edit of a good blob, which must break its rule and leave queries safe.
pub fn break_one_by_one(good: &[u8], breaks: &[(Rule, Break)]) {
    assert_eq!(load(good), Ok(()));
    for (i, (rule, edit)) in breaks.iter().enumerate() {
        let mut bytes = good.to_vec();
        edit(&mut bytes);
        seal(&mut bytes);
        let error = load(&bytes).expect_err(rule.text());
        assert_eq!(error.rule, *rule, "edit {i}: {error}");
        // Not checked, it answers all the same, within its steps.
        let buffer = Buffer::from(&bytes[..]);
        let Ok(scene) = Scene::trust(&buffer) else { continue };
        for k in 0..3 {
            let mut dir = [0.1, 0.2, 0.3];
            dir[k] = 1.0;
            let ray = Ray::new([-3.0, -2.5, -2.0], dir).within(-100.0, 100.0);
            let _ = (scene.closest_hit(&ray), scene.any_hit(&ray));
            assert_ne!(scene.closest_hit_within(&ray, u32::MAX), Err(Stop::Fuel));
        }
    }
}

/// For each rule an edit that breaks it and no rule before it.
const BREAKS: &[(Rule, Break)] = &[
    (Rule::Size, |b| b.truncate(79)),
    (Rule::Magic, |b| b[0] ^= 1),
    (Rule::Version, |b| header(b, |h| h.version = 2)),
    (Rule::Length, |b| b.push(0)),
    (Rule::KindKnown, |b| header(b, |h| h.kind = 99)),
    (Rule::Reserved, |b| header(b, |h| h.reserved[1] = 7)),
    (Rule::SectionOrder, |b| set_entry(b, 1, |e| e.section = 1)),
    (Rule::SectionPlace, |b| set_entry(b, 1, |e| e.offset += 64)),
    (Rule::SectionLength, |b| {
        // The last section is the nodes': half a node less.
        let last = entries(b).len() - 1;
        set_entry(b, last, |e| e.length -= 32);
        let n = b.len() - 32;
        b.truncate(n);
        header(b, |h| h.length -= 32);
    }),
    (Rule::Bounds, |b| header(b, |h| h.bounds.min[0] = f32::NAN)),
    (Rule::Stack, |b| header(b, |h| h.stack = 65)),
    (Rule::PrimCount, |b| header(b, |h| h.prims += 1)),
    (Rule::Checksum, |b| header(b, |h| h.checksum ^= 1)),
    (Rule::Padding, |b| {
        let end = HEADER + size_of_val(&entries(b)[..]);
        b[end] = 1;
        seal(b);
    }),
    (Rule::PrimShape, |b| {
        edit::<Sphere>(b, Section::Spheres, 2, |s| s.radius = -1.0);
        seal(b);
    }),
    (Rule::PrimBounds, |b| {
        edit::<Sphere>(b, Section::Spheres, 2, |s| s.radius = 1e3);
        seal(b);
    }),
    (Rule::RefOrder, |b| {
        edit::<u32>(b, Section::Refs, 0, |r| *r += 1);
        seal(b);
    }),
    (Rule::IdRange, |b| {
        edit::<u32>(b, Section::Ids, 5, |id| *id = 60);
        seal(b);
    }),
    (Rule::NodeOrder, |b| {
        edit::<Node>(b, Section::BvhNodes, 0, |n| n.child[1] = n.child[0]);
        seal(b);
    }),
    (Rule::LeafOrder, |b| {
        let nodes = (entries(b).last().expect("nodes").length / 64) as usize;
        edit::<Node>(b, Section::BvhNodes, nodes - 1, |n| n.child[1] = Child::leaf(0, 1));
        seal(b);
    }),
    (Rule::NodeBounds, |b| {
        edit::<Node>(b, Section::BvhNodes, 3, |n| n.planes[1][0] = n.planes[0][0]);
        seal(b);
    }),
    (Rule::StackTrue, |b| {
        header(b, |h| h.stack += 1);
        seal(b);
    }),
    (Rule::StepsTrue, |b| {
        header(b, |h| h.steps -= 1);
        seal(b);
    }),
];

#[test]
fn every_rule_has_an_edit_that_breaks_exactly_it() {
    assert_eq!(load(&good()), Ok(()));
    for (rule, edit) in BREAKS {
        let mut bytes = good();
        edit(&mut bytes);
        let error = load(&bytes).expect_err(rule.text());
        assert_eq!(error.rule, *rule, "{error}");
        assert!(error.to_string().starts_with(&format!("rule {}, ", rule.number())), "{error}");
    }
    // The one rule that is not about the bytes but about where they lie.
    let others =
        [voxel::FLAT_BREAKS, voxel::BLOCKS_BREAKS, nested::BREAKS, octree::BREAKS, bsp::BREAKS, sphere::BREAKS];
    let all = BREAKS.iter().chain(GRID_BREAKS).chain(others.into_iter().flatten());
    let tested: Vec<_> = all.map(|(rule, _)| *rule).chain([Rule::Alignment]).collect();
    for rule in Rule::ALL {
        assert!(tested.contains(rule), "rule {} has no test", rule.number());
    }
}

#[test]
fn a_blob_must_start_at_a_multiple_of_four() {
    let bytes = good();
    let mut buffer = Buffer::zeroed(bytes.len() + 64);
    for shift in 0..64 {
        buffer[shift..shift + bytes.len()].copy_from_slice(&bytes);
        let result = Scene::from_bytes(&buffer[shift..shift + bytes.len()]).map(|s| s.len());
        if shift % 4 == 0 {
            assert_eq!(result, Ok(60));
        } else {
            let error = result.expect_err("crooked");
            assert_eq!((error.rule, error.found, error.needed), (Rule::Alignment, shift as u32 % 4, 4));
        }
    }
}

#[test]
fn more_ways_to_break_the_nodes() {
    let breaks: &[(Rule, Break)] = &[
        // A node that is its own child, one that is shared, one that does not exist, one that is left out.
        (Rule::NodeOrder, |b| edit::<Node>(b, Section::BvhNodes, 0, |n| n.child[0] = Child::node(0))),
        (Rule::NodeOrder, |b| edit::<Node>(b, Section::BvhNodes, 2, |n| n.child[0] = Child::node(1))),
        (Rule::NodeOrder, |b| edit::<Node>(b, Section::BvhNodes, 0, |n| n.child[0] = Child::node(1 << 27))),
        (Rule::LeafOrder, |b| edit::<Node>(b, Section::BvhNodes, 0, |n| n.child[0] = Child::leaf(1, 3))),
        (Rule::LeafOrder, |b| edit::<Node>(b, Section::BvhNodes, 0, |n| n.child[0] = Child::leaf((1 << 28) - 1, 15))),
        (Rule::Reserved, |b| edit::<Node>(b, Section::BvhNodes, 4, |n| n.reserved[0] = 1)),
        (Rule::NodeBounds, |b| edit::<Node>(b, Section::BvhNodes, 4, |n| n.planes[2][1] = f32::NAN)),
        (Rule::NodeBounds, |b| edit::<Node>(b, Section::BvhNodes, 0, |n| n.planes[1][1] = f32::INFINITY)),
        (Rule::PrimShape, |b| edit::<flashray::Cone>(b, Section::Cones, 0, |c| c.caps = 2)),
        (Rule::PrimShape, |b| edit::<flashray::Aabb>(b, Section::Boxes, 0, |c| c.min[1] = c.max[1] + 1.0)),
        (Rule::PrimShape, |b| edit::<f32>(b, Section::Triangles, 4, |x| *x = f32::INFINITY)),
        (Rule::RefOrder, |b| edit::<u32>(b, Section::Refs, 3, |r| *r = u32::MAX)),
    ];
    for (i, (rule, edit)) in breaks.iter().enumerate() {
        let mut bytes = good();
        edit(&mut bytes);
        seal(&mut bytes);
        assert_eq!(load(&bytes).expect_err("broken").rule, *rule, "edit {i}");
        // Not checked, it is as safe: whatever the answers, there are answers.
        let buffer = Buffer::from(&bytes[..]);
        let scene = Scene::trust(&buffer).expect("only the inside is broken");
        for k in 0..3 {
            let mut dir = [0.1, 0.2, 0.3];
            dir[k] = 1.0;
            let ray = Ray::new([-3.0, -2.5, -2.0], dir).within(-100.0, 100.0);
            let _ = (scene.closest_hit(&ray), scene.any_hit(&ray));
            // However much a caller gives: what costs more than all there is has gone in a circle.
            assert_ne!(scene.closest_hit_within(&ray, u32::MAX), Err(Stop::Fuel));
            let (_, steps) = scene.closest_hit_counted(&ray);
            assert!(steps.nodes + steps.prims <= scene.limits().steps + 15, "{steps:?}");
        }
    }
}

#[test]
fn sections_that_the_structure_does_not_have_are_refused() {
    // A hierarchy that calls itself a list: its nodes would be bytes that nobody looks at.
    let mut bytes = good();
    header(&mut bytes, |h| (h.kind, h.stack, h.steps) = (Kind::List.number(), 0, 60));
    seal(&mut bytes);
    assert_eq!(load(&bytes).expect_err("nodes in a list").rule, Rule::SectionOrder);
    // An entry of no length.
    let mut bytes = good();
    set_entry(&mut bytes, 2, |e| e.length = 0);
    seal(&mut bytes);
    assert_eq!(load(&bytes).expect_err("an empty section").rule, Rule::SectionLength);
}

#[test]
fn every_damaged_byte_is_noticed() {
    let bytes = build(&mixed(20, 2), &Config::new(Kind::Bvh)).to_vec();
    for at in 0..bytes.len() {
        for flip in [1, 0x80, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] ^= flip;
            assert!(load(&damaged).is_err(), "byte {at} ^ {flip:#x} went unnoticed");
        }
    }
    for len in 0..bytes.len() {
        assert!(load(&bytes[..len]).is_err(), "cut to {len} bytes");
    }
}

#[test]
fn the_smallest_blobs() {
    for config in configs() {
        for n in 0..20 {
            let soup =
                Soup { spheres: vec![Sphere { center: [n as f32, 0.0, 0.0], radius: 0.5 }; n], ..Soup::default() };
            let blob = build(&soup, &config);
            let scene = Scene::from_bytes(&blob).expect("a good blob");
            let ray = Ray::new([n as f32, 0.0, 5.0], [0.0, 0.0, -1.0]);
            assert_eq!(scene.closest_hit(&ray).map(|h| (h.t, h.prim)), (n > 0).then_some((4.5, 0)));
            assert_eq!(scene.closest_hit_within(&ray, scene.limits().steps).map(|h| h.is_some()), Ok(n > 0));
            assert_eq!((scene.len() as usize, scene.is_empty()), (n, n == 0));
        }
    }
}

#[test]
fn building_in_lent_memory_gives_the_same_bytes_and_says_what_is_full() {
    let soup = mixed(100, 3);
    let mesh = mesh(&soup);
    for config in configs() {
        let expected = to_vec(&mesh, &config).expect("a good mesh");
        let needs = Needs::new(&mesh, &config).expect("small enough");
        assert!(needs.refs >= 100 && needs.bytes >= expected.len());
        let (mut refs, mut nodes) = (heapless::Vec::<_, 4096>::new(), heapless::Vec::<_, 99>::new());
        let (mut cells, mut slots) = (heapless::Vec::<_, 131_072>::new(), heapless::Vec::<_, 65536>::new());
        let mut arena = Arena { refs: &mut refs, nodes: &mut nodes, cells: &mut cells, slots: &mut slots };
        let mut out = vec![0xa5; needs.bytes];
        assert_eq!(into(&mesh, &config, &mut arena, &mut out), Ok(&expected[..]));
        // One byte short: the error says how many are enough, and nothing is written.
        let mut short = vec![0xa5; expected.len() - 1];
        let full = BuildError::Full { what: What::Out, needed: expected.len(), had: expected.len() - 1 };
        assert_eq!(into(&mesh, &config, &mut arena, &mut short), Err(full));
        assert!(short.iter().all(|&b| b == 0xa5));
        // One reference short, and nothing of the other parts: the error says which is full.
        let mut few = heapless::Vec::<_, 99>::new();
        let arena = &mut Arena { refs: &mut few, nodes: &mut nodes, cells: &mut cells, slots: &mut slots };
        let full = BuildError::Full { what: What::Refs, needed: needs.refs, had: 99 };
        assert_eq!(into(&mesh, &config, arena, &mut out), Err(full));
        let (mut none, mut no_words, mut empty) =
            (heapless::Vec::<_, 0>::new(), heapless::Vec::<_, 0>::new(), out.clone());
        let parts = [(What::Nodes, needs.nodes), (What::Cells, needs.cells), (What::Slots, needs.slots)];
        for (what, needed) in parts {
            let mut arena = Arena { refs: &mut refs, nodes: &mut nodes, cells: &mut cells, slots: &mut slots };
            match what {
                What::Nodes => arena.nodes = &mut none,
                What::Cells => arena.cells = &mut no_words,
                _ => arena.slots = &mut no_words,
            }
            let result = into(&mesh, &config, &mut arena, &mut empty).map(<[u8]>::len);
            let full = Err(BuildError::Full { what, needed, had: 0 });
            assert_eq!(result, if needed == 0 { Ok(expected.len()) } else { full }, "{config:?}");
        }
    }
}

#[test]
fn bad_meshes_are_refused_by_name() {
    let corner = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, f32::NAN, 0.0]];
    let config = Config::new(Kind::Bvh);
    let error = |mesh: &Mesh<'_>, config: &Config| to_vec(mesh, config).expect_err("a bad mesh");
    assert_eq!(error(&Mesh::new(&corner, &[[0, 1, 2]]), &config), BuildError::Primitive { prim: 0 });
    let index = BuildError::Index { triangle: 1, vertex: 3, vertices: 3 };
    assert_eq!(error(&Mesh::new(&corner, &[[0, 1, 0], [0, 1, 3]]), &config), index);
    let balls = [Sphere { center: [0.0; 3], radius: 1.0 }, Sphere { center: [0.0; 3], radius: -1.0 }];
    assert_eq!(error(&Mesh::new(&corner, &[[0, 1, 1]]).spheres(&balls), &config), BuildError::Primitive { prim: 2 });
    assert_eq!(error(&Mesh::default(), &config.leaf(16)), BuildError::Leaf { found: 16 });
    assert_eq!(error(&Mesh::default(), &config.local([f32::NAN, 0.0, 0.0])), BuildError::Local);
    let huge = [Sphere { center: [3e38, 0.0, 0.0], radius: 3e38 }];
    assert_eq!(error(&Mesh::default().spheres(&huge), &config), BuildError::Primitive { prim: 0 });
    // A scene from end to end of what is allowed has planes that are numbers; one step beyond is refused.
    let end = 126f32.exp2();
    let ends = [[-end; 3], [end; 3], [end, -end, 0.0]];
    for config in configs() {
        let blob = to_vec(&Mesh::new(&ends, &[[0, 1, 2]]), &config).expect("a scene of the greatest size");
        assert!(Scene::from_bytes(&Buffer::from(&blob[..])).is_ok(), "{config:?}");
        let beyond = [[-end; 3], [end; 3], [end.next_up(), -end, 0.0]];
        assert_eq!(error(&Mesh::new(&beyond, &[[0, 1, 2]]), &config), BuildError::Primitive { prim: 0 });
    }
}

#[test]
fn a_million_identical_triangles_and_coincident_centres_end() {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let triangles = vec![[0, 1, 2]; 1_000_000];
    // Boxes of all sizes around one centre separate by nothing but size.
    let shells: Vec<_> = (1..5000).map(|i| Sphere { center: [0.0; 3], radius: i as f32 }).collect();
    let mesh = Mesh::new(&positions, &triangles);
    // A resolution that the caller insists on would list each of them in every cell.
    assert_eq!(to_vec(&mesh, &Config::new(Kind::Grid).cells(37)), Err(BuildError::TooLarge));
    for config in configs().into_iter().filter(|c| c.cells == 0) {
        let blob = Buffer::from(&to_vec(&mesh, &config).expect("builds")[..]);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        assert!(scene.limits().stack <= 20, "{} levels", scene.limits().stack);
        if config.kind != Kind::List {
            let hit = scene.closest_hit(&Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0])).expect("a hit");
            assert_eq!((hit.t, hit.prim), (1.0, 0));
        }
        let blob = Buffer::from(&to_vec(&Mesh::default().spheres(&shells), &config).expect("builds")[..]);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        assert_eq!(scene.closest_hit(&Ray::new([0.0; 3], [0.0, 1.0, 0.0])).map(|h| (h.t, h.prim)), Some((1.0, 0)));
    }
}

#[test]
fn a_staircase_that_halving_boxes_can_not_part_stays_within_the_stack() {
    // Each object half as far as the last: the middle of the box parts off one at a time, as far as f32 goes.
    let balls: Vec<_> = (0..3000)
        .map(|i| Sphere { center: [2.0f32.powi(-(i % 120)), 0.0, 0.0], radius: 1e-38 * (i + 1) as f32 })
        .collect();
    for config in configs() {
        let blob = Buffer::from(&to_vec(&Mesh::default().spheres(&balls), &config.leaf(1)).expect("builds")[..]);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        assert!(scene.limits().stack <= 60, "{} levels", scene.limits().stack);
        if config.kind == Kind::Bvh && config.rule == flashray::build::Rule::Seed {
            assert!(scene.limits().stack >= 32, "{} levels: halving by count never set in", scene.limits().stack);
        }
    }
}

/// The golden blobs, and the mesh and configuration that made each: see tests/golden/README.md.
fn golden() -> Vec<(&'static str, Soup, Config)> {
    vec![
        ("v1-list-empty", Soup::default(), Config::new(Kind::List)),
        ("v1-bvh-empty", Soup::default(), Config::new(Kind::Bvh)),
        ("v1-list-mixed-15", mixed(15, 4), Config::new(Kind::List)),
        ("v1-bvh-mixed-100", mixed(100, 5), Config::new(Kind::Bvh)),
        ("v1-bvh-seed-sphere-80", icosphere(1), Config::new(Kind::Bvh).rule(flashray::build::Rule::Seed)),
        ("v1-grid-empty", Soup::default(), Config::new(Kind::Grid)),
        ("v1-grid-mixed-100", mixed(100, 5), Config::new(Kind::Grid)),
        ("v1-voxel-empty", Soup::default(), Config::new(Kind::Voxel)),
        ("v1-voxel-mixed-100", mixed(100, 5), Config::new(Kind::Voxel).cells(12)),
        ("v1-voxel-seed-mixed-100", mixed(100, 5), Config::new(Kind::Voxel).rule(flashray::build::Rule::Seed)),
        ("v1-nested-empty", Soup::default(), Config::new(Kind::Nested)),
        ("v1-nested-mixed-100", mixed(100, 5), Config::new(Kind::Nested)),
        ("v1-octree-empty", Soup::default(), Config::new(Kind::Octree)),
        ("v1-octree-mixed-100", mixed(100, 5), Config::new(Kind::Octree)),
        ("v1-bsp-empty", Soup::default(), Config::new(Kind::Bsp)),
        ("v1-bsp-mixed-100", mixed(100, 5), Config::new(Kind::Bsp)),
        ("v1-sphere-empty", Soup::default(), Config::new(Kind::Sphere)),
        ("v1-sphere-mixed-100", mixed(100, 5), Config::new(Kind::Sphere)),
        ("v1-bvh-local-sphere-80", icosphere(1), Config::new(Kind::Bvh).local([0.25, -0.5, 8.0])),
    ]
}

#[test]
fn golden_blobs_load_and_are_built_alike() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    for (name, soup, config) in golden() {
        let path = folder.join(format!("{name}.fray"));
        let built = build(&soup, &config);
        if !path.exists() && std::env::var_os("FLASHRAY_GOLDEN").is_some_and(|v| v == "write") {
            fs::write(&path, &*built).expect("tests/golden can be written");
        }
        let kept = Buffer::from(&fs::read(&path).expect("the golden blob is there")[..]);
        assert!(*kept == *built, "{name}: the builder's bytes have changed");
        let (a, b) = (Scene::from_bytes(&kept).expect(name), Scene::from_bytes(&built).expect(name));
        let ray = Ray::new([3.0, 2.0, 9.0], [-0.3, -0.2, -1.0]);
        assert_eq!(bits(a.closest_hit(&ray)), bits(b.closest_hit(&ray)));
    }
}

//! The format: every rule broken by a test of its own, every damaged byte noticed, golden blobs, limits.
use crate::common::meshes::mixed;
use crate::common::{build, configs};
use crate::soup::Soup;
use crate::{bsp, nested, octree, sphere, voxel, wide};
use flashray::blob::{Buffer, Entry, Header, Rule, Section, crc32};
use flashray::build::Config;
use flashray::bvh::{Child, Node};
use flashray::grid::Shape;
use flashray::{BlobError, Kind, Ray, Scene, Sphere, Stop};

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
    (Rule::Version, |b| header(b, |h| h.version = 3)),
    (Rule::Version, |b| header(b, |h| h.version = 0)),
    (Rule::Length, |b| b.push(0)),
    (Rule::KindKnown, |b| header(b, |h| h.kind = 99)),
    (Rule::Reserved, |b| header(b, |h| h.reserved = 7)),
    (Rule::Reserved, |b| header(b, |h| h.version = 1)),
    (Rule::Longest, |b| {
        header(b, |h| h.longest *= 0.999);
        seal(b);
    }),
    (Rule::Longest, |b| header(b, |h| h.longest = f32::INFINITY)),
    (Rule::Longest, |b| header(b, |h| h.longest = f32::NAN)),
    (Rule::Longest, |b| header(b, |h| h.longest = -0.0)),
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
    let others = [
        voxel::FLAT_BREAKS,
        voxel::BLOCKS_BREAKS,
        nested::BREAKS,
        octree::BREAKS,
        bsp::BREAKS,
        sphere::BREAKS,
        wide::BREAKS,
    ];
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

/// Around what is a huge page where there are such: the bytes behave as those of a vector.
#[test]
fn buffers_of_any_length_begin_at_a_line_and_keep_their_bytes() {
    const HUGE: usize = 2 << 20;
    for len in [0, 1, 63, 64, 65, HUGE - 1, HUGE, HUGE + 1, 3 * HUGE - 1] {
        let mut buffer = Buffer::zeroed(len);
        assert_eq!((buffer.len(), buffer.as_ptr() as usize % 64), (len, 0));
        assert!(buffer.iter().all(|&byte| byte == 0), "{len}");
        let expected: Vec<u8> = (0..len).map(|i| (i % 251) as u8).collect();
        buffer.copy_from_slice(&expected);
        let copies = [buffer.clone(), Buffer::from(&expected[..])];
        buffer.fill(255);
        for copy in copies {
            assert!(*copy == *expected, "{len}");
            assert_eq!(copy.as_ptr() as usize % 64, 0);
        }
    }
    assert!(Buffer::default().is_empty());
}

/// What the system was asked for stands in its own list of this process's mappings.
#[cfg(target_os = "linux")]
#[test]
fn long_buffers_ask_for_huge_pages() {
    let buffer = Buffer::zeroed(5 << 20);
    let start = buffer.as_ptr() as usize;
    assert_eq!(start % (2 << 20), 0);
    let maps = std::fs::read_to_string("/proc/self/smaps").expect("Linux has it");
    let of = |line: &str| {
        let (from, to) = line.split_once(' ')?.0.split_once('-')?;
        Some(usize::from_str_radix(from, 16).ok()?..usize::from_str_radix(to, 16).ok()?)
    };
    let mut lines = maps.lines().skip_while(|line| !of(line).is_some_and(|range| range.contains(&start)));
    let range = lines.next().and_then(of).expect("the buffer is somewhere");
    assert!(range.contains(&(start + buffer.len() - 1)), "{range:?}");
    let flags = lines.find_map(|line| line.strip_prefix("VmFlags:")).expect("a mapping has flags");
    // `hg`: advised to be huge. A kernel without huge pages does not know the advice.
    let known = std::path::Path::new("/sys/kernel/mm/transparent_hugepage").exists();
    assert_eq!(flags.split_whitespace().any(|flag| flag == "hg"), known, "{flags}");
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

//! Octrees: every rule of theirs broken.
use crate::blobs::{Break, HEADER, break_one_by_one, edit, entries, header, set_entry, words};
use crate::common::build;
use crate::common::meshes::mixed;
use flashray::Kind;
use flashray::blob::{Header, Rule, Section};
use flashray::build::{Config, Rule as Split};
use flashray::grid::Shape;
use flashray::octree::Node as Octant;

/// A blob of 60 primitives of all kinds in an octree.
fn good_octree() -> Vec<u8> {
    build(&mixed(60, 1), &Config::new(Kind::Octree).leaf(2)).to_vec()
}

/// The first node with a child of that sort: its number and the child's bit.
fn octree_child(bytes: &[u8], inner: bool) -> (usize, u8) {
    let nodes = words(bytes, Section::OctreeNodes);
    let mask = |w: &[u32]| if inner { w[2] as u8 } else { (w[2] >> 8) as u8 };
    let node = nodes.chunks_exact(3).position(|w| mask(w) != 0).expect("such a child");
    (node, mask(&nodes[node * 3..]) & mask(&nodes[node * 3..]).wrapping_neg())
}

/// For each rule about octrees an edit that breaks it and no rule before it.
pub const BREAKS: &[(Rule, Break)] = &[
    (Rule::Reserved, |b| edit::<Octant>(b, Section::OctreeNodes, 1, |n| n.pad = 1)),
    (Rule::OctreeShape, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.cells[1] *= 2)),
    (Rule::OctreeShape, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.cells = [65537; 3])),
    (Rule::OctreeShape, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.cells = [1 << 17; 3])),
    (Rule::OctreeShape, |b| {
        edit::<Shape>(b, Section::GridShape, 0, |s| {
            s.lattice.cell = s.lattice.cell.map(|c| c * 65536.0);
            s.cells = [1; 3];
        });
    }),
    // A node that is its own child, one that is shared, one that is left out, one that does not exist.
    (Rule::OctreeOrder, |b| edit::<Octant>(b, Section::OctreeNodes, 0, |n| n.first = 0)),
    (Rule::OctreeOrder, |b| edit::<Octant>(b, Section::OctreeNodes, 1, |n| n.first -= 1)),
    (Rule::OctreeOrder, |b| edit::<Octant>(b, Section::OctreeNodes, 1, |n| n.first += 1)),
    (Rule::OctreeOrder, |b| edit::<Octant>(b, Section::OctreeNodes, 0, |n| n.list = 1)),
    (Rule::OctreeOrder, |b| {
        let (node, bit) = octree_child(b, true);
        edit::<Octant>(b, Section::OctreeNodes, node, |n| n.leaves |= bit);
    }),
    (Rule::OctreeOrder, |b| {
        let (node, bit) = octree_child(b, true);
        edit::<Octant>(b, Section::OctreeNodes, node, |n| n.inner &= !bit);
    }),
    (Rule::OctreeOrder, |b| {
        let last = words(b, Section::OctreeNodes).len() / 3 - 1;
        edit::<Octant>(b, Section::OctreeNodes, last, |n| (n.inner, n.leaves) = (n.leaves, n.inner));
    }),
    // Half as many cells, twice as large, and so on: the deepest node has one.
    (Rule::OctreeDepth, |b| {
        let depth = {
            let header: Header = bytemuck::pod_read_unaligned(&b[..HEADER]);
            header.stack
        };
        edit::<Shape>(b, Section::GridShape, 0, |s| {
            s.cells = [1 << (depth - 1); 3];
            s.lattice.cell = s.lattice.cell.map(|c| c * 2.0f32.powi(17 - depth as i32));
        });
    }),
    // A leaf's list trades places with the empty child beside it.
    (Rule::ListComplete, |b| {
        let nodes = words(b, Section::OctreeNodes);
        let lonely = |c: u32, w: &[u32]| w[2] >> 8 & 1 << c != 0 && (w[2] | w[2] >> 8) & 2 << c == 0 && c < 7;
        let found = nodes.chunks_exact(3).enumerate().flat_map(|(i, w)| (0..8).map(move |c| (i, c, w)));
        let (node, c, _) = found.into_iter().find(|&(_, c, w)| lonely(c, w)).expect("an empty child after a leaf");
        edit::<Octant>(b, Section::OctreeNodes, node, |n| n.leaves ^= 3 << c);
    }),
    (Rule::ListComplete, |b| {
        let starts = words(b, Section::CellStarts);
        let several = |c: &usize| starts[c + 1] - starts[*c] >= 2;
        let lists = words(b, Section::CellLists);
        // Its last goes to the next list, if that still ascends.
        let fits = |c: &usize| several(c) && lists[starts[c + 1] as usize - 1] < lists[starts[c + 1] as usize];
        let cell = (0..starts.len() - 2).find(fits).expect("two lists in order");
        edit::<u32>(b, Section::CellStarts, cell + 1, |s| *s -= 1);
    }),
    (Rule::StackTrue, |b| header(b, |h| h.stack += 1)),
    (Rule::StepsTrue, |b| header(b, |h| h.steps -= 1)),
];

#[test]
fn rules_about_octrees_are_broken_one_by_one() {
    break_one_by_one(&good_octree(), BREAKS);
    // An octree without nodes has one list.
    let few = build(&mixed(3, 1), &Config::new(Kind::Octree).rule(Split::Seed)).to_vec();
    assert_eq!(words(&few, Section::CellStarts), [0, 3]);
    let breaks: &[(Rule, Break)] = &[
        (Rule::OctreeShape, |b| {
            let starts = entries(b).iter().position(|e| e.section == Section::CellStarts.number()).expect("starts");
            set_entry(b, starts, |e| e.length += 4);
        }),
        (Rule::ListPlace, |b| edit::<u32>(b, Section::CellStarts, 1, |s| *s = 2)),
    ];
    break_one_by_one(&few, breaks);
}

//! Binary space partitions: every rule of theirs broken.
use crate::blobs::{Break, HEADER, break_one_by_one, edit, header, words};
use crate::common::build;
use crate::common::meshes::mixed;
use flashray::blob::{Header, Rule, Section};
use flashray::build::{Config, Rule as Split};
use flashray::{Kind, bsp};

/// A blob of 60 primitives of all kinds in a binary space partition.
fn good_bsp() -> Vec<u8> {
    build(&mixed(60, 1), &Config::new(Kind::Bsp).rule(Split::Seed).leaf(3)).to_vec()
}

/// Edits the first node from `from` on that fits.
fn edit_bsp(bytes: &mut [u8], from: usize, fits: impl Fn(bsp::Node) -> bool, change: impl FnOnce(&mut bsp::Node)) {
    let words = words(bytes, Section::BspNodes);
    let node = |at: usize| bsp::Node { place: words[2 * at], word: words[2 * at + 1] };
    let at = (from..words.len() / 2).find(|&at| fits(node(at))).expect("such a node");
    edit::<bsp::Node>(bytes, Section::BspNodes, at, change);
}

/// Moves a node's plane.
fn move_plane(bytes: &mut [u8], at: usize, to: impl Fn(f32) -> f32) {
    edit::<bsp::Node>(bytes, Section::BspNodes, at, |n| n.place = to(f32::from_bits(n.place)).to_bits());
}

const INNER: fn(bsp::Node) -> bool = |n| n.cut().is_some();
const LISTS: fn(bsp::Node) -> bool = |n| n.cut().is_none() && n.number() > 1;

/// For each rule about binary space partitions an edit that breaks it and no rule before it.
pub const BREAKS: &[(Rule, Break)] = &[
    // A node that is its own child, one that is shared, one that does not exist, one that is left out.
    (Rule::NodeOrder, |b| edit_bsp(b, 0, INNER, |n| n.word &= 3)),
    (Rule::NodeOrder, |b| edit_bsp(b, 1, INNER, |n| n.word = 1 << 2 | n.word & 3)),
    (Rule::NodeOrder, |b| edit_bsp(b, 2, INNER, |n| n.word |= !3)),
    (Rule::NodeOrder, |b| edit_bsp(b, 0, INNER, |n| n.word += 1 << 2)),
    (Rule::NodeOrder, |b| edit_bsp(b, 0, INNER, |n| *n = bsp::Node::leaf(0, 0))),
    (Rule::Plane, |b| move_plane(b, 0, |_| f32::NAN)),
    (Rule::Plane, |b| move_plane(b, 0, |_| 1e30)),
    (Rule::Plane, |b| {
        let bounds = bytemuck::pod_read_unaligned::<Header>(&b[..HEADER]).bounds;
        edit_bsp(b, 0, INNER, |n| n.place = bounds.min[n.cut().expect("inner").axis.at()].to_bits());
    }),
    (Rule::ListComplete, |b| move_plane(b, 0, |x| x + 0.5)),
    (Rule::ListPlace, |b| edit_bsp(b, 0, LISTS, |n| n.place += 1)),
    (Rule::ListPlace, |b| edit_bsp(b, 0, LISTS, |n| n.word += 1 << 28)),
    (Rule::ListPlace, |b| edit_bsp(b, 0, LISTS, |n| n.word -= 1 << 2)),
    (Rule::ListPlace, |b| {
        let last = words(b, Section::BspNodes).len() / 2 - 1;
        edit_bsp(b, last, LISTS, |n| n.word -= 1 << 2);
    }),
    (Rule::ListOrder, |b| edit::<u32>(b, Section::CellLists, 0, |s| *s = 60)),
    (Rule::ListOrder, |b| edit::<u32>(b, Section::CellLists, 1, |s| *s = 0)),
    // A leaf's last reference becomes one that it does not need: what it needed is not there.
    (Rule::ListComplete, |b| {
        let lists = words(b, Section::CellLists);
        let nodes = words(b, Section::BspNodes);
        let leaves: Vec<_> =
            nodes.chunks(2).map(|w| bsp::Node { place: w[0], word: w[1] }).filter(|&n| LISTS(n)).collect();
        // Two neighbours that stay in order, and whose slots were all listed before.
        let fits = |n: &&bsp::Node| {
            let (first, last) = (n.place as usize, (n.place + n.number()) as usize - 1);
            let known = lists[..first].iter().max().copied().unwrap_or(0);
            lists[last] < known && lists[last - 1] + 1 < lists[last]
        };
        let leaf = leaves.iter().find(fits).expect("such a leaf");
        edit::<u32>(b, Section::CellLists, (leaf.place + leaf.number()) as usize - 1, |s| *s -= 1);
    }),
    (Rule::StackTrue, |b| header(b, |h| h.stack += 1)),
    (Rule::StepsTrue, |b| header(b, |h| h.steps -= 1)),
];

#[test]
fn rules_about_binary_space_partitions_are_broken_one_by_one() {
    break_one_by_one(&good_bsp(), BREAKS);
}

//! Sparse voxels: packed numbers, slots kept by addition, planes of blocks, and every rule of theirs broken.
use crate::blobs::{Break, break_one_by_one, edit, entries, header, load, seal, words};
use crate::common::build;
use crate::common::meshes::mixed;
use crate::common::rays::Random;
use crate::common::shared_mesh;
use crate::mesh;
use flashray::blob::packed::{Packed, pack, width, words as packed_words};
use flashray::blob::{Rule, Section};
use flashray::build::{Config, Rule as Split};
use flashray::geom::lattice::Lattice;
use flashray::geom::ray::Axis;
use flashray::grid::Shape;
use flashray::voxel::{BLOCKS, FLAT, Form, Hashed, Table};
use flashray::walk::dda::Cursor;
use flashray::{Kind, Scene};

#[test]
fn packed_numbers_come_back() {
    let mut random = Random::new(3);
    for bits in 1..=31 {
        for len in [0usize, 1, 2, 31, 32, 33, 100] {
            let most = u32::MAX >> (32 - bits);
            assert_eq!(width(most), bits);
            let numbers: Vec<u32> = (0..len).map(|_| random.next() & most).collect();
            let mut packed = numbers.clone();
            packed.push(7);
            let used = pack(&mut packed, len as u32, most);
            assert_eq!(used, packed_words(len as u32, bits) as usize);
            let read = Packed::whole(&packed[..used], len as u32, most).expect("as many words");
            assert_eq!(read.range(0, u32::MAX).collect::<Vec<_>>(), numbers, "{bits} bits");
            assert_eq!(read.check_end(Section::VoxelLists), Ok(()));
            assert!(Packed::whole(&packed[..used - 1], len as u32, most).is_none());
        }
    }
}

#[test]
fn a_slot_kept_by_addition_is_the_remainder() {
    let mut random = Random::new(5);
    for round in 0..300 {
        let mut n = || 1 + random.below([8, 90, 1024][round % 3]) as u32;
        let cells = [n(), n(), n()];
        let shape = Shape { lattice: Lattice { min: [0.0; 3], cell: [1.0; 3] }, cells, reserved: 0 };
        let all = shape.len().expect("less than 2^30");
        // Tables of 1 slot, of as many as voxels, and where a plane of voxels is a multiple of the table.
        let modulus = [1, all, cells[2], cells[1] * cells[2], 1 + random.below(all as usize) as u32][round % 5];
        let mut at = cells.map(|n| random.below(n as usize) as u32);
        let mut hashed = Hashed::new(&shape, modulus);
        hashed.put(at);
        for _ in 0..300 {
            let (axis, down) = (Axis::ALL[random.below(3)], random.below(2) == 0);
            let i = &mut at[axis.at()];
            if (down && *i == 0) || (!down && *i + 1 == cells[axis.at()]) {
                continue;
            }
            *i = if down { *i - 1 } else { *i + 1 };
            hashed.step(axis, down);
            let p = (at[0] * cells[1] + at[1]) * cells[2] + at[2];
            assert_eq!((hashed.voxel, hashed.slot, hashed.tag), (p, p % modulus, p / modulus), "{cells:?} {modulus}");
        }
    }
}

#[test]
fn the_planes_of_blocks_are_planes_of_voxels_bit_by_bit() {
    let mut random = Random::new(9);
    for round in 0..2000 {
        let scale = 2.0f32.powi([0, -149, 100, -40, 20][round % 5]);
        let min = random.point([0.0; 3], [scale * 3.0; 3]);
        let lattice =
            Lattice { min, cell: [0, 1, 2].map(|_| f32::from_bits((random.unit() * scale).to_bits().max(1))) };
        let blocks = lattice.blocks();
        for axis in Axis::ALL {
            for i in [0, 1, 2, 3, 77, 255, 256, 1000, (1 << 18) - 1, 1 << 18] {
                let (a, b) = (blocks.plane(axis, i), lattice.plane(axis, i * 4));
                assert_eq!(a.to_bits(), b.to_bits(), "plane {i} of {lattice:?}");
            }
        }
    }
}

fn good_flat() -> Vec<u8> {
    build(&mixed(60, 1), &Config::new(Kind::Voxel).rule(Split::Seed).cells(8)).to_vec()
}

fn good_blocks() -> Vec<u8> {
    build(&mixed(60, 1), &Config::new(Kind::Voxel).cells(21)).to_vec()
}

fn table(bytes: &mut [u8], change: impl FnOnce(&mut Table)) {
    edit::<Table>(bytes, Section::VoxelTable, 0, change);
}

/// Inverts bits of a word.
fn flip(bytes: &mut [u8], section: Section, word: usize, bits: u32) {
    edit::<u32>(bytes, section, word, |w| *w ^= bits);
}

/// The same, counted from a section's last word: that of 0 after packed numbers.
fn flip_last(bytes: &mut [u8], section: Section, before: usize, bits: u32) {
    let last = words(bytes, section).len() - 1;
    flip(bytes, section, last - before, bits);
}

fn index_of(words: &[u32], i: usize) -> usize {
    words[i] as usize
}

/// The word of `voxel index` at which the groups of blocks begin.
fn groups(bytes: &[u8]) -> usize {
    let blocks = index_of(&words(bytes, Section::VoxelTable), 4);
    words(bytes, Section::VoxelIndex).len() - blocks.div_ceil(8) * 4
}

/// Inverts bits of a group's word.
fn flip_group(bytes: &mut [u8], group: usize, word: usize, bits: u32) {
    let first = groups(bytes);
    flip(bytes, Section::VoxelIndex, first + 4 * group + word, bits);
}

/// Changes which octants the first block has that has neither all nor one only.
fn edit_octants(bytes: &mut [u8], change: impl FnOnce(u32) -> u32) {
    let (first, index) = (groups(bytes), words(bytes, Section::VoxelIndex));
    let place = (0..32).map(|i| (first + 4 * (i / 8) + 2 + i % 8 / 4, i % 4 * 8));
    let octants = |&(word, shift): &(usize, usize)| index[word] >> shift & 255;
    let (word, shift) = place.into_iter().find(|p| (2..8).contains(&octants(p).count_ones())).expect("such a block");
    let new = change(octants(&(word, shift))) & 255;
    edit::<u32>(bytes, Section::VoxelIndex, word, |w| *w = *w & !(255 << shift) | new << shift);
}

/// For each rule about the flat form an edit that breaks it.
pub const FLAT_BREAKS: &[(Rule, Break)] = &[
    (Rule::Lattice, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.lattice.cell[2] *= 0.99)),
    (Rule::VoxelTable, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.cells[0] += 40)),
    (Rule::VoxelTable, |b| table(b, |t| t.form = 3)),
    (Rule::VoxelTable, |b| table(b, |t| t.form = BLOCKS)),
    (Rule::VoxelTable, |b| table(b, |t| t.blocks = 1)),
    (Rule::VoxelTable, |b| table(b, |t| t.octants = 1)),
    (Rule::VoxelTable, |b| table(b, |t| t.modulus = 0)),
    (Rule::VoxelTable, |b| table(b, |t| t.modulus = u32::MAX)),
    (Rule::VoxelTable, |b| table(b, |t| t.occupied = u32::MAX)),
    (Rule::VoxelTable, |b| table(b, |t| t.listed *= 2)),
    (Rule::VoxelBits, |b| flip(b, Section::VoxelBits, 3, 1 << 7)),
    // One on and one off instead: as many as before.
    (Rule::VoxelBuckets, |b| {
        let word = words(b, Section::VoxelBits).iter().position(|w| *w != 0 && *w != u32::MAX).expect("both");
        edit::<u32>(b, Section::VoxelBits, word, |w| *w ^= 1 << w.trailing_zeros() | 1 << w.trailing_ones());
    }),
    (Rule::VoxelBuckets, |b| flip(b, Section::VoxelIndex, 0, 1)),
    (Rule::VoxelBuckets, |b| flip(b, Section::VoxelIndex, 9, 1 << 9)),
    (Rule::ListPlace, |b| flip(b, Section::VoxelStarts, 0, 1)),
    (Rule::ListPlace, |b| flip(b, Section::VoxelStarts, 3, 1 << 20)),
    (Rule::ListOrder, |b| flip(b, Section::VoxelLists, 0, 1)),
    (Rule::ListOrder, |b| flip(b, Section::VoxelLists, 5, 1 << 11)),
    (Rule::PackedEnd, |b| flip_last(b, Section::VoxelIndex, 0, 1)),
    (Rule::PackedEnd, |b| flip_last(b, Section::VoxelStarts, 0, 1 << 31)),
    (Rule::PackedEnd, |b| flip_last(b, Section::VoxelLists, 0, 1 << 16)),
    (Rule::StackTrue, |b| header(b, |h| h.stack += 1)),
    (Rule::StepsTrue, |b| header(b, |h| h.steps -= 1)),
];

/// The same for blocks.
pub const BLOCKS_BREAKS: &[(Rule, Break)] = &[
    (Rule::VoxelTable, |b| table(b, |t| t.modulus = 1)),
    (Rule::VoxelTable, |b| table(b, |t| t.blocks += 8)),
    (Rule::VoxelTable, |b| edit::<Shape>(b, Section::GridShape, 0, |s| s.cells[0] += 40)),
    (Rule::VoxelBits, |b| flip(b, Section::VoxelBits, 0, 1)),
    (Rule::VoxelBits, |b| flip(b, Section::VoxelBits, 5, 1)),
    // Bits of blocks beyond the last.
    (Rule::VoxelBits, |b| flip_last(b, Section::VoxelBits, 1, 1 << 31)),
    (Rule::VoxelTable, |b| table(b, |t| t.octants += 4)),
    (Rule::VoxelTable, |b| table(b, |t| t.octants = u32::MAX)),
    // Counts before the first group and a later one, and all octants: of voxels, of octants.
    (Rule::VoxelMasks, |b| flip_group(b, 0, 0, 1)),
    (Rule::VoxelMasks, |b| flip_group(b, 0, 1, 1)),
    (Rule::VoxelMasks, |b| flip_group(b, 2, 0, 1 << 31)),
    (Rule::VoxelMasks, |b| flip_group(b, 2, 1, 1 << 31)),
    (Rule::VoxelMasks, |b| table(b, |t| t.octants += 1)),
    (Rule::VoxelMasks, |b| table(b, |t| t.occupied -= 1)),
    // An octant that is not there, one that is there and not counted, and a block without any.
    (Rule::VoxelMasks, |b| edit_octants(b, |octants| octants | octants.wrapping_add(1))),
    (Rule::VoxelMasks, |b| edit_octants(b, |octants| octants & octants.wrapping_sub(1))),
    (Rule::VoxelMasks, |b| edit_octants(b, |_| 0)),
    // The bits of a block after the last.
    (Rule::VoxelMasks, |b| flip_last(b, Section::VoxelIndex, 0, 1 << 31)),
    // An octant without a voxel, and with one more.
    (Rule::VoxelMasks, |b| edit::<u32>(b, Section::VoxelIndex, 0, |w| *w &= !0xff00)),
    (Rule::VoxelMasks, |b| edit::<u32>(b, Section::VoxelIndex, 0, |w| *w |= 1 << (*w).trailing_ones())),
    // Of 21 cells one is in the last block along an axis: a voxel beside it instead.
    (Rule::VoxelMasks, |b| {
        let last = index_of(&words(b, Section::VoxelTable), 5) - 1;
        edit::<u32>(b, Section::VoxelIndex, last / 4, |w| *w = *w & !(255 << (last % 4 * 8)) | 2 << (last % 4 * 8));
    }),
    // The word of 0 before the groups.
    (Rule::PackedEnd, |b| {
        let last = groups(b) - 1;
        flip(b, Section::VoxelIndex, last, 1);
    }),
    // An octant after the last.
    (Rule::PackedEnd, |b| {
        let octants = index_of(&words(b, Section::VoxelTable), 5);
        flip(b, Section::VoxelIndex, octants / 4, 1 << (octants % 4 * 8));
    }),
    (Rule::ListPlace, |b| flip(b, Section::VoxelStarts, 3, 1 << 20)),
    (Rule::ListOrder, |b| flip(b, Section::VoxelLists, 5, 1 << 11)),
    (Rule::PackedEnd, |b| flip_last(b, Section::VoxelStarts, 0, 1 << 31)),
    (Rule::StepsTrue, |b| header(b, |h| h.steps -= 1)),
];

#[test]
fn rules_about_sparse_voxels_are_broken_one_by_one() {
    let form = |bytes: &[u8]| words(bytes, Section::VoxelTable)[0];
    assert_eq!((form(&good_flat()), form(&good_blocks())), (FLAT, BLOCKS));
    break_one_by_one(&good_flat(), FLAT_BREAKS);
    break_one_by_one(&good_blocks(), BLOCKS_BREAKS);
}

/// The voxels that list something, in the order of their lists, read from a blob as `docs/format.md` says.
fn voxels_of_blocks(bytes: &[u8], cells: [u32; 3]) -> Vec<[u32; 3]> {
    let (bits, index) = (words(bytes, Section::VoxelBits), words(bytes, Section::VoxelIndex));
    let (masks, first) = (index.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<_>>(), groups(bytes));
    let [_, y, z] = cells.map(|n| n.div_ceil(4));
    let (mut found, mut rank, mut octants) = (Vec::new(), 0, 0);
    for block in 0..bits.len() / 3 * 64 {
        if bits[block / 64 * 3 + block % 64 / 32] >> (block % 32) & 1 == 0 {
            continue;
        }
        let group = &index[first + rank / 8 * 4..][..4];
        if rank % 8 == 0 {
            assert_eq!(group[..2], [found.len() as u32, octants as u32]);
        }
        let present = group[2..].iter().flat_map(|w| w.to_le_bytes()).nth(rank % 8).expect("8 bytes");
        let mut own = [0; 8];
        for octant in (0..8).filter(|o| present >> o & 1 == 1) {
            own[octant] = masks[octants];
            octants += 1;
        }
        let block = block as u32;
        let corner = [block / (y * z) * 4, block / z % y * 4, block % z * 4];
        for (i, j, k) in (0..64).map(|bit| (bit / 16, bit / 4 % 4, bit % 4)) {
            let (octant, bit) = (4 * (i / 2) + 2 * (k / 2) + j / 2, 4 * (j % 2) + 2 * (i % 2) + k % 2);
            if own[octant as usize] >> bit & 1 == 1 {
                found.push([corner[0] + i, corner[1] + j, corner[2] + k]);
            }
        }
        rank += 1;
    }
    found
}

#[test]
fn masks_of_octants_are_as_the_format_says() {
    for (soup, cells) in [(mixed(60, 1), 21), (mixed(100, 5), 12), (mixed(300, 2), 33), (mixed(1, 1), 4)] {
        let bytes = build(&soup, &Config::new(Kind::Voxel).cells(cells));
        let voxels = Scene::from_bytes(&bytes).expect("a good blob").voxel().expect("voxels").voxels.expect("some");
        let Form::Blocks(blocks) = voxels.form else { continue };
        let cells = voxels.shape.cells;
        let found = voxels_of_blocks(&bytes, cells);
        assert_eq!(found.len() as u32, voxels.table.occupied);
        let mut listed = 0;
        for cell in (0..voxels.shape.len().expect("few")).map(|number| voxels.shape.place(number)) {
            let place = found.iter().position(|&voxel| voxel == cell);
            assert_eq!(blocks.entry_at(cell), place.map(|n| n as u32), "{cell:?} of {cells:?}");
            listed += u32::from(place.is_some());
        }
        assert_eq!(listed, voxels.table.occupied);
    }
}

#[test]
fn a_list_that_lacks_what_its_voxel_needs_is_noticed() {
    for good in [good_flat(), good_blocks()] {
        // Each list gives its last slot away to the next, one after the other: most do not get through rule 27, and
        // those that do lack something. Starts are packed: each is changed through all its bits.
        let (mut incomplete, n) = (0, words(&good, Section::VoxelStarts).len() - 1);
        for word in 0..n {
            for bit in 0..32 {
                let mut bytes = good.clone();
                flip(&mut bytes, Section::VoxelStarts, word, 1 << bit);
                seal(&mut bytes);
                let rule = load(&bytes).expect_err("a start is wrong").rule;
                incomplete += usize::from(rule == Rule::ListComplete);
            }
        }
        assert!(incomplete > 0, "no edit came as far as rule 28");
    }
}

/// Bytes a triangle of a section.
fn share(bytes: &[u8], section: Section, prims: u32) -> f64 {
    let found = entries(bytes).iter().find(|e| e.section == section.number()).map_or(0, |e| e.length);
    f64::from(found) / f64::from(prims)
}

#[test]
fn bunny_in_128_cells_takes_few_bytes() {
    let Some(path) = shared_mesh("bunny.obj") else { return };
    let soup = mesh::read(&path).expect("bunny");
    let blob = build(&soup, &Config::new(Kind::Voxel).cells(128));
    let scene = Scene::from_bytes(&blob).expect("a good blob");
    let share = |section| share(&blob, section, scene.len());
    let occupancy = share(Section::VoxelTable) + share(Section::VoxelBits) + share(Section::VoxelIndex);
    let (starts, lists) = (share(Section::VoxelStarts), share(Section::VoxelLists));
    println!("bytes a triangle: occupancy {occupancy:.3}, starts {starts:.3}, references {lists:.3}");
    assert!(occupancy <= 0.37 && occupancy + starts + lists <= 11.6);
}

//! The primitives of a blob, in *slots*: the order in which the structure wants them.
//!
//! Each kind has a section of its own. Where all are triangles, slot `i` is triangle `i`. Otherwise `refs[i]` says
//! which primitive stands there: the kind in the upper 3 bits (0 triangle, 1 sphere, 2 box, 3 cylinder, 4 cone), its
//! place in its section in the lower 29. For example `0x4000_0002` is box 2. References run through each section in
//! order, so one pass with five counters proves that each primitive is referred to once.
//!
//! In a structure that tests four triangles at a time, where all are triangles, they stand in `blocks`, four slots each, and
//! not every slot has one.
//!
//! `ids[i]` is the caller's number of the primitive in slot `i`; without that section it is `i`.
use super::block::{self, Block, LANES};
use super::{Blob, BlobError, Rule, Section};
use crate::geom::overlap;
use crate::geom::place::longest_side;
use crate::geom::vec::finite;
use crate::geom::{Aabb, Cone, Cylinder, Sphere, Triangle};
use crate::num::{count, index};

/// Bits of a reference that hold the place in the section.
pub const REF_BITS: u32 = 29;

/// One primitive, whatever its kind.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Primitive {
    /// A triangle.
    Triangle(Triangle),
    /// A sphere.
    Sphere(Sphere),
    /// An axis-aligned box.
    Box(Aabb),
    /// A cylinder.
    Cylinder(Cylinder),
    /// A truncated cone.
    Cone(Cone),
}

impl Primitive {
    /// Whether this is a triangle whose box has a longer side than is said of all; 0 says nothing.
    fn is_longer(&self, longest: f32) -> bool {
        matches!(self, Self::Triangle(p) if longest != 0.0 && longest_side(&p.bounds()) > longest)
    }

    /// The primitive's bounding box.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Triangle(p) => p.bounds(),
            Self::Sphere(p) => p.bounds(),
            Self::Box(p) => *p,
            Self::Cylinder(p) => p.as_cone().bounds(),
            Self::Cone(p) => p.bounds(),
        }
    }

    /// Whether it has a part in a cell: for a triangle as [`crate::geom::overlap`] says, for the others where their
    /// boxes have a point in common.
    #[must_use]
    pub fn overlaps(&self, cell: &Aabb) -> bool {
        match self {
            Self::Triangle(p) => overlap::triangle(p, cell),
            other => overlap::boxes(&other.bounds(), cell),
        }
    }

    /// Whether it may have a part in a cell of those in a box: where this says no, [`Primitive::overlaps`] says no for
    /// each cell. For a box of many cells, to leave them all out at once.
    #[must_use]
    pub fn may_overlap(&self, around: &Aabb) -> bool {
        match self {
            Self::Triangle(p) => overlap::triangle_nearly(p, around),
            other => overlap::boxes(&other.bounds(), around),
        }
    }

    /// Whether its numbers are finite, its radii not negative, its corners ordered and its flags known.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        match self {
            Self::Triangle(p) => finite(p.v[0]) && finite(p.v[1]) && finite(p.v[2]),
            Self::Sphere(p) => finite(p.center) && radius(p.radius),
            Self::Box(p) => p.is_valid(),
            Self::Cylinder(p) => finite(p.base) && finite(p.top) && radius(p.radius) && p.caps <= 1,
            Self::Cone(p) => {
                finite(p.base) && finite(p.top) && radius(p.base_radius) && radius(p.top_radius) && p.caps <= 1
            }
        }
    }
}

fn radius(r: f32) -> bool {
    r >= 0.0 && r.is_finite()
}

/// The primitive sections of a blob.
#[derive(Clone, Copy, Debug)]
pub struct Prims<'a> {
    /// All triangles.
    pub triangles: &'a [Triangle],
    /// All spheres.
    pub spheres: &'a [Sphere],
    /// All boxes.
    pub boxes: &'a [Aabb],
    /// All cylinders.
    pub cylinders: &'a [Cylinder],
    /// All cones.
    pub cones: &'a [Cone],
    /// References per slot; empty if slots are triangles.
    pub refs: &'a [u32],
    /// Caller's numbers per slot; empty if they are the slots.
    pub ids: &'a [u32],
    /// Triangles in blocks; empty if they are in `triangles`.
    pub blocks: &'a [Block],
    /// Number of primitives.
    pub len: u32,
}

impl<'a> Prims<'a> {
    /// The sections, their lengths compared: rules 10 and 13.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    pub fn parse(blob: &Blob<'a>) -> Result<Self, BlobError> {
        let prims = Self {
            triangles: blob.section(Section::Triangles)?,
            spheres: blob.section(Section::Spheres)?,
            boxes: blob.section(Section::Boxes)?,
            cylinders: blob.section(Section::Cylinders)?,
            cones: blob.section(Section::Cones)?,
            refs: blob.section(Section::Refs)?,
            ids: blob.section(Section::Ids)?,
            blocks: blob.section(Section::Blocks)?,
            len: blob.header().prims,
        };
        let slots = index(prims.len);
        if !prims.blocks.is_empty() {
            return prims.parse_blocks();
        }
        let lengths = [prims.spheres.len(), prims.boxes.len(), prims.cylinders.len(), prims.cones.len()];
        let others = lengths.iter().fold(0usize, |sum, &n| sum.saturating_add(n));
        let agree = |section, found: usize, wanted: bool| {
            let wanted_len = if wanted { slots } else { 0 };
            let error = BlobError::new(Rule::PrimCount, section).found(count(found)).needed(count(wanted_len));
            if found == wanted_len { Ok(()) } else { Err(error) }
        };
        agree(Section::Header, prims.triangles.len().saturating_add(others), true)?;
        agree(Section::Refs, prims.refs.len(), others > 0)?;
        agree(Section::Ids, prims.ids.len(), !prims.ids.is_empty())?;
        Ok(prims)
    }

    /// Blocks stand alone, and have room for all.
    fn parse_blocks(self) -> Result<Self, BlobError> {
        let others =
            [self.triangles.len(), self.spheres.len(), self.boxes.len(), self.cylinders.len(), self.cones.len()];
        let alone = others == [0; 5] && self.refs.is_empty() && self.ids.is_empty();
        if alone && index(self.len).div_ceil(index(LANES)) <= self.blocks.len() && self.blocks.len() <= index(self.len)
        {
            return Ok(self);
        }
        Err(BlobError::new(Rule::PrimCount, Section::Blocks)
            .found(count(self.blocks.len()))
            .needed(self.len.div_ceil(LANES)))
    }

    /// The full check, O(n): rules 16 to 19, 55 and 62.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    pub fn check(&self, bounds: &Aabb, longest: f32) -> Result<(), BlobError> {
        if !self.blocks.is_empty() {
            return self.check_blocks(bounds, longest);
        }
        self.check_refs()?;
        for (slot, &id) in self.ids.iter().enumerate() {
            if id >= self.len {
                let error = BlobError::new(Rule::IdRange, Section::Ids).at(count(slot));
                return Err(error.found(id).needed(self.len));
            }
        }
        for slot in 0..self.len {
            let (section, at) = self.place(slot);
            let primitive = self.get(slot).filter(Primitive::is_valid);
            let Some(primitive) = primitive else {
                return Err(BlobError::new(Rule::PrimShape, section).at(at));
            };
            if !bounds.contains(&primitive.bounds()) {
                return Err(BlobError::new(Rule::PrimBounds, section).at(at));
            }
            if primitive.is_longer(longest) {
                return Err(BlobError::new(Rule::Longest, section).at(at));
            }
        }
        Ok(())
    }

    /// Rule 55, and 13, 16, 17, 19 and 62 for blocks.
    fn check_blocks(&self, bounds: &Aabb, longest: f32) -> Result<(), BlobError> {
        let mut found = 0u32;
        for (number, block) in self.blocks.iter().enumerate() {
            let broken = |rule| BlobError::new(rule, Section::Blocks).at(count(number));
            let len = block.filled().ok_or(broken(Rule::BlockLanes))?;
            for (&id, lane) in block.ids.iter().zip(0..index(len)) {
                let primitive = Primitive::Triangle(block.triangle(lane));
                if id >= self.len {
                    return Err(broken(Rule::IdRange).found(id).needed(self.len));
                }
                if !primitive.is_valid() {
                    return Err(broken(Rule::PrimShape));
                }
                if !bounds.contains(&primitive.bounds()) {
                    return Err(broken(Rule::PrimBounds));
                }
                if primitive.is_longer(longest) {
                    return Err(broken(Rule::Longest));
                }
            }
            found = found.saturating_add(len);
        }
        let error = BlobError::new(Rule::PrimCount, Section::Blocks).found(found).needed(self.len);
        if found == self.len { Ok(()) } else { Err(error) }
    }

    /// Rule 18.
    fn check_refs(&self) -> Result<(), BlobError> {
        let mut next = [0u32; 8];
        for (slot, &word) in self.refs.iter().enumerate() {
            let (kind, at) = split(word);
            let expected = &mut next[index(kind & 7)];
            if kind > 4 || at != *expected {
                let error = BlobError::new(Rule::RefOrder, Section::Refs).at(count(slot));
                return Err(error.found(word).needed(reference(kind, *expected)));
            }
            *expected = expected.saturating_add(1);
        }
        // As many references as primitives, each kind counted up from 0: only the shares can still be wrong.
        let counted =
            [self.triangles.len(), self.spheres.len(), self.boxes.len(), self.cylinders.len(), self.cones.len()];
        for (&n, &found) in counted.iter().zip(&next) {
            if !self.refs.is_empty() && count(n) != found {
                let error = BlobError::new(Rule::RefOrder, Section::Refs).at(self.len);
                return Err(error.found(found).needed(count(n)));
            }
        }
        Ok(())
    }

    /// The section and place of a slot's primitive.
    fn place(&self, slot: u32) -> (Section, u32) {
        let (kind, at) = self.refs.get(index(slot)).map_or((0, slot), |&word| split(word));
        let sections = [Section::Triangles, Section::Spheres, Section::Boxes, Section::Cylinders, Section::Cones];
        (*sections.get(index(kind)).unwrap_or(&Section::Refs), at)
    }

    /// The primitive in a slot; `None` if the slot, or what it refers to, does not exist.
    #[inline]
    #[must_use]
    pub fn get(&self, slot: u32) -> Option<Primitive> {
        if !self.blocks.is_empty() {
            let (block, lane) = block::at(self, slot)?;
            let there = block.ids.get(lane).is_some_and(|&id| id != block::NO_ID);
            return there.then(|| Primitive::Triangle(block.triangle(lane)));
        }
        if self.refs.is_empty() {
            return self.triangles.get(index(slot)).copied().map(Primitive::Triangle);
        }
        let (kind, at) = self.referred(slot)?;
        match kind {
            0 => self.triangles.get(at).copied().map(Primitive::Triangle),
            1 => self.spheres.get(at).copied().map(Primitive::Sphere),
            2 => self.boxes.get(at).copied().map(Primitive::Box),
            3 => self.cylinders.get(at).copied().map(Primitive::Cylinder),
            4 => self.cones.get(at).copied().map(Primitive::Cone),
            _ => None,
        }
    }

    /// Where the primitive in a slot is, if other kinds stand among the triangles: the number of its kind, and its
    /// place among those.
    #[inline(always)]
    pub(crate) fn referred(&self, slot: u32) -> Option<(u32, usize)> {
        let (kind, at) = split(*self.refs.get(index(slot))?);
        Some((kind, index(at)))
    }

    /// Number of slots.
    #[must_use]
    pub const fn slots(&self) -> u32 {
        if self.blocks.is_empty() { self.len } else { count(self.blocks.len()).saturating_mul(LANES) }
    }

    /// The caller's number of the primitive in a slot.
    #[inline]
    #[must_use]
    pub fn id(&self, slot: u32) -> u32 {
        if let Some((block, lane)) = block::at(self, slot) {
            return block.ids.get(lane).copied().unwrap_or(slot);
        }
        self.id_outside_blocks(slot)
    }

    /// The same where there are no blocks: walks that know none ask for none.
    #[inline(always)]
    pub(crate) fn id_outside_blocks(&self, slot: u32) -> u32 {
        self.ids.get(index(slot)).copied().unwrap_or(slot)
    }

    /// The box around a run of slots; empty where they do not exist.
    #[must_use]
    pub fn bounds(&self, first: u32, len: u32) -> Aabb {
        let slots = first..first.saturating_add(len);
        slots.filter_map(|s| self.get(s)).fold(Aabb::EMPTY, |all, p| all.join(&p.bounds()))
    }
}

/// A reference's kind and place.
#[inline(always)]
const fn split(word: u32) -> (u32, u32) {
    (word >> REF_BITS, word & ((1 << REF_BITS) - 1))
}

/// The reference to place `at` of `kind`.
#[inline]
#[must_use]
pub(crate) const fn reference(kind: u32, at: u32) -> u32 {
    kind << REF_BITS | at
}

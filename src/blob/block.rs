//! Triangles four at a time.
use super::prims::Prims;
use crate::geom::Triangle;
use crate::geom::vec::Vec3;
use crate::num::index;
use bytemuck::{Pod, Zeroable};

/// Triangles of a block.
pub const LANES: u32 = 4;

/// The number in a lane that holds no triangle.
pub const NO_ID: u32 = u32::MAX;

/// Up to four triangles, lane by lane, so that one load takes the same coordinate of all: 160 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Block {
    /// For each corner and each axis the coordinates of the four triangles.
    pub corners: [[[f32; 4]; 3]; 3],
    /// The caller's numbers; [`NO_ID`] in a lane without a triangle.
    pub ids: [u32; 4],
}

const _: () = assert!(size_of::<Block>() == 160);

impl Block {
    /// No triangle.
    pub const EMPTY: Self = Self { corners: [[[0.0; 4]; 3]; 3], ids: [NO_ID; 4] };

    /// The triangle in a lane, whether there is one or not.
    #[must_use]
    pub fn triangle(&self, lane: usize) -> Triangle {
        let lane = lane % index(LANES);
        let corner = |[x, y, z]: &[[f32; 4]; 3]| -> Vec3 { [x[lane], y[lane], z[lane]] };
        let [a, b, c] = &self.corners;
        Triangle { v: [corner(a), corner(b), corner(c)] }
    }

    /// Puts a triangle into a lane.
    #[cfg(feature = "build")]
    pub(crate) fn set(&mut self, lane: usize, triangle: &Triangle, id: u32) {
        let lane = lane % index(LANES);
        for (rows, v) in self.corners.iter_mut().zip(triangle.v) {
            for (row, x) in rows.iter_mut().zip(v) {
                row[lane] = x;
            }
        }
        self.ids[lane] = id;
    }

    /// Lanes that hold triangles, if those are the first ones and the others are empty.
    #[must_use]
    pub fn filled(&self) -> Option<u32> {
        let len = self.ids.iter().take_while(|&&id| id != NO_ID).count();
        let empty = |lane: usize| {
            self.ids[lane % 4] == NO_ID && self.triangle(lane).v.as_flattened().iter().all(|x| x.to_bits() == 0)
        };
        (len > 0 && (len..index(LANES)).all(empty)).then_some(crate::num::count(len))
    }
}

/// Blocks and the lane of a slot.
#[inline]
#[must_use]
pub(crate) fn at<'a>(prims: &Prims<'a>, slot: u32) -> Option<(&'a Block, usize)> {
    Some((prims.blocks.get(index(slot / LANES))?, index(slot % LANES)))
}

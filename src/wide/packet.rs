//! Packets: four, eight or sixteen rays against one box or one triangle at a time.
//!
//! The form of Wald, Slusallek, Benthin and Wagner, "Interactive Rendering with Coherent Ray Tracing", Computer Graphics
//! Forum 20(3), 2001: a child is entered by those rays that meet it, and a mask says which. What the interval test of all
//! rays of the packet leaves out (see [`super::group`]) is not tested against each.
use super::many::{Answer, Many};
use super::{In, Node, STACK, Wide};
use crate::blob::block::LANES;
use crate::bvh::tree::root;
use crate::bvh::walk::Rows;
use crate::bvh::{Child, Face};
use crate::geom::Ray;
use crate::num::index;
use crate::walk::Stop;
use crate::walk::heading::{Heading, PacketSize};
use crate::walk::lanes::{Lanes, Two, Work};
use crate::walk::packet::{Boxes, Packet};

/// A packet, to be compiled for each instruction set.
pub(super) struct Packets<'q, 'a, 'r, A, const ANY: bool, const W: usize> {
    pub many: Many<'q, 'a, W>,
    pub of: PacketSize,
    pub rays: &'r [Ray],
    pub answers: &'r mut [A],
}

impl<A: Answer, const ANY: bool, const W: usize> Work for Packets<'_, '_, '_, A, ANY, W>
where
    Node<W>: Wide<W>,
{
    /// The rays that are not answered.
    type Output = u64;

    #[inline(always)]
    fn run<L8: Lanes<8>, L4: Lanes<4>>(self) -> u64 {
        match self.of {
            PacketSize::Four => self.answer::<4, L4, L4, In<W, L8, L4>>(),
            PacketSize::Eight => self.answer::<8, L8, L4, In<W, L8, L4>>(),
            PacketSize::Sixteen => self.answer::<16, Two<L8>, L4, In<W, L8, L4>>(),
        }
    }
}

impl<A: Answer, const ANY: bool, const W: usize> Packets<'_, '_, '_, A, ANY, W> {
    /// Rays of one heading together, those of the next after them. Returns the rays that are not answered.
    #[inline(always)]
    fn answer<const N: usize, L: Lanes<N>, L4: Lanes<4>, LW: Lanes<W>>(self) -> u64 {
        let Self { many, rays, answers, .. } = self;
        let (mut left, mut alone) = (u32::MAX >> (32 - rays.len().clamp(1, N)), 0);
        while let Some(first) = rays.get(index(left.trailing_zeros())) {
            let heading = Heading::new(first);
            let same = |all: u32, ray: &Ray| all << 1 | u32::from(Heading::new(ray) == heading);
            let mine = rays.iter().take(N).rev().fold(0, same) & left;
            left &= !mine;
            let Some(heading) = heading.filter(|_| mine.count_ones() > 1) else {
                alone |= mine;
                continue;
            };
            // The lanes of others repeat the first ray: the interval is then no wider for them.
            let mut packed = [*first; N];
            for (i, (place, ray)) in packed.iter_mut().zip(rays).enumerate() {
                if mine >> i & 1 == 1 {
                    *place = *ray;
                }
            }
            let mut packet = Packet::<N>::EMPTY;
            if packet.set::<L>(&packed, mine, heading, many.place) & mine != mine {
                alone |= mine;
                continue;
            }
            let ok = walk::<ANY, N, W, L, L4, LW>(&mut packet, many, heading, mine).is_ok();
            for (i, answer) in answers.iter_mut().enumerate() {
                if mine >> i & 1 == 1 {
                    // As for one ray: what contradicts itself is a miss.
                    *answer = A::new(packet.hit(i).filter(|_| ok));
                }
            }
        }
        u64::from(alone)
    }
}

/// A child that waits: where its box begins at the earliest, and the rays that meet it.
type Waiting = (Child, f32, u32);

/// Finds the closest hits of the rays, or with `ANY` whether there are any.
#[inline(always)]
fn walk<const ANY: bool, const N: usize, const W: usize, L: Lanes<N>, L4: Lanes<4>, LW: Lanes<W>>(
    packet: &mut Packet<N>,
    Many { view, prims, mut fuel, .. }: Many<'_, '_, W>,
    heading: Heading,
    mine: u32,
) -> Result<(), Stop> {
    let rows = Rows::of(heading.negative);
    let range = packet.range::<L>(heading);
    let mut stack = heapless::Vec::<Waiting, { index(STACK) }>::new();
    let (mut at, mut rays, mut farthest) = (root(view.nodes, prims.len), mine, packet.farthest::<L>());
    loop {
        if at.is_node() {
            fuel = fuel.checked_sub(1).ok_or(Stop::Fuel)?;
            let node = view.nodes.get(index(at.number())).ok_or(Stop::Corrupt)?;
            let row = |face: Face| &node.planes[face.at()];
            let (mut maybe, near) = range.meet::<W, LW>(rows.near.map(row), rows.far.map(row), farthest);
            let near = near.store();
            let mut sorted = 0usize;
            while maybe != 0 {
                let lane = index(maybe.trailing_zeros()) % W;
                maybe &= maybe - 1;
                let met = rays & meets::<N, W, L>(packet, rows, node, lane);
                if met == 0 {
                    continue;
                }
                stack.push((node.child[lane], near[lane], met)).map_err(|_| Stop::Corrupt)?;
                let mut place = stack.len().saturating_sub(1);
                for _ in 0..sorted {
                    match stack.get_mut(place.wrapping_sub(1)..=place) {
                        Some([below, above]) if below.1 < above.1 => core::mem::swap(below, above),
                        _ => break,
                    }
                    place = place.wrapping_sub(1);
                }
                sorted = sorted.saturating_add(1);
            }
        } else {
            fuel = fuel.checked_sub(at.len()).ok_or(Stop::Fuel)?;
            let blocks = prims.blocks.get(index(at.number())..);
            let blocks = blocks.and_then(|b| b.get(..index(at.len().div_ceil(LANES)))).ok_or(Stop::Corrupt)?;
            let (mut hits, mut left) = (0, at.len());
            for block in blocks {
                let boxes = Boxes::new::<L4>(heading, block);
                for lane in 0..index(left.min(LANES)) {
                    hits |= packet.test::<ANY, L>(heading, block, lane, &boxes);
                }
                left = left.saturating_sub(LANES);
            }
            if hits != 0 {
                farthest = packet.farthest::<L>();
            }
        }
        (at, rays) = loop {
            let Some((child, near, met)) = stack.pop() else { return Ok(()) };
            let met = met & packet.reach::<L>(near);
            if met != 0 {
                break (child, met);
            }
        };
    }
}

/// Which rays meet a child's box.
#[inline(always)]
fn meets<const N: usize, const W: usize, L: Lanes<N>>(
    packet: &Packet<N>,
    rows: Rows,
    node: &Node<W>,
    lane: usize,
) -> u32 {
    let plane = |face: Face| node.planes[face.at()][lane % W];
    let ([nx, ny, nz], [fx, fy, fz]) = (rows.near, rows.far);
    packet.meets::<L>([plane(nx), plane(ny), plane(nz)], [plane(fx), plane(fy), plane(fz)])
}

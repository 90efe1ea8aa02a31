//! What a walk may spend, and what it has spent.

use crate::geom::Aabb;

/// A node or cell of a structure, for those who look at structures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Its box.
    pub bounds: Aabb,
    /// How deep it lies; the root's level is 0, and a grid's cells are on level 1.
    pub level: u32,
    /// How many primitives it holds or lists; none for an inner node.
    pub listed: Option<u32>,
}

/// A budget that every step of a walk is paid from. Returns `false` when it can not pay.
pub trait Meter {
    /// A node is visited.
    fn node(&mut self) -> bool;
    /// `n` primitives are about to be tested.
    fn prims(&mut self, n: u32) -> bool;
    /// The node or cell just visited has this box. For pictures: counting needs no box, and then none is made.
    #[inline(always)]
    fn at(&mut self, _bounds: impl FnOnce() -> Aabb) {}
    /// `n` of those were not tested, because a mailbox remembered them.
    #[inline(always)]
    fn spared(&mut self, _n: u32) {}
    /// `n` of those were not tested, because one before them was enough. They stay paid.
    #[inline(always)]
    fn untested(&mut self, _n: u32) {}
}

/// Steps that are left.
#[derive(Clone, Copy, Debug)]
pub struct Fuel(pub u32);

impl Fuel {
    #[inline(always)]
    fn pay(&mut self, n: u32) -> bool {
        let enough = n <= self.0;
        self.0 = self.0.wrapping_sub(n);
        enough
    }
}

impl Meter for Fuel {
    #[inline(always)]
    fn node(&mut self) -> bool {
        self.pay(1)
    }

    #[inline(always)]
    fn prims(&mut self, n: u32) -> bool {
        self.pay(n)
    }
}

impl<M: Meter> Meter for &mut M {
    #[inline(always)]
    fn node(&mut self) -> bool {
        (**self).node()
    }

    #[inline(always)]
    fn prims(&mut self, n: u32) -> bool {
        (**self).prims(n)
    }

    #[inline(always)]
    fn at(&mut self, bounds: impl FnOnce() -> Aabb) {
        (**self).at(bounds);
    }

    #[inline(always)]
    fn spared(&mut self, n: u32) {
        (**self).spared(n);
    }

    #[inline(always)]
    fn untested(&mut self, n: u32) {
        (**self).untested(n);
    }
}

/// What a query cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Steps {
    /// Nodes visited.
    pub nodes: u32,
    /// Primitives tested.
    pub prims: u32,
    /// Tests that a mailbox made needless; not among those in `prims`.
    pub spared: u32,
}

/// Fuel that also counts.
#[derive(Clone, Copy, Debug)]
pub struct Tally {
    /// What is left.
    pub fuel: Fuel,
    /// What is spent.
    pub steps: Steps,
}

impl Meter for Tally {
    #[inline(always)]
    fn node(&mut self) -> bool {
        self.steps.nodes = self.steps.nodes.saturating_add(1);
        self.fuel.node()
    }

    #[inline(always)]
    fn prims(&mut self, n: u32) -> bool {
        self.steps.prims = self.steps.prims.saturating_add(n);
        self.fuel.prims(n)
    }

    #[inline(always)]
    fn spared(&mut self, n: u32) {
        self.steps.prims = self.steps.prims.saturating_sub(n);
        self.steps.spared = self.steps.spared.saturating_add(n);
    }

    #[inline(always)]
    fn untested(&mut self, n: u32) {
        self.steps.prims = self.steps.prims.saturating_sub(n);
    }
}

//! The full check: the nodes are one tree in order, the lists fill their section in the same order, and each leaf lists
//! what it needs.
use super::{View, Visit};
use crate::blob::lists::Order;
use crate::blob::prims::Prims;
use crate::blob::{BlobError, MAX_STACK, Rule, Section};
use crate::num::count;

/// Returns the deepest stack of any walk: the number of inner nodes on the longest way down.
pub(super) fn run(view: &View<'_>, prims: &Prims<'_>) -> Result<u32, BlobError> {
    let nodes = count(view.nodes.len());
    let mut tree = Tree {
        view,
        next_node: u32::from(prims.len > 0),
        next_slot: 0,
        order: Order::new(Section::CellLists),
        deepest: 0,
    };
    if prims.len > 0 {
        view.pass(|visit| tree.node(visit).map(|()| true), deep)?;
    }
    if tree.next_node != nodes {
        return Err(broken(Rule::NodeOrder, tree.next_node).found(nodes).needed(tree.next_node));
    }
    let slots = count(view.slots.len());
    if tree.next_slot != slots {
        return Err(broken(Rule::ListPlace, nodes).found(tree.next_slot).needed(slots));
    }
    tree.order.end(prims.len)?;
    for slot in 0..prims.len {
        complete(view, prims, slot)?;
    }
    Ok(tree.deepest)
}

/// Rules 20, 26, 27 and 45, node by node in order.
///
/// A pair of children must have the numbers that follow all pairs met before, and a list must start where the one
/// before it ends. So no node has two parents, there is no cycle, and nothing is left out.
struct Tree<'c, 'a> {
    view: &'c View<'a>,
    next_node: u32,
    next_slot: u32,
    order: Order,
    deepest: u32,
}

impl Tree<'_, '_> {
    fn node(&mut self, visit: &Visit<'_>) -> Result<(), BlobError> {
        let (node, number) = (visit.node, visit.number);
        let Some(cut) = node.cut() else {
            self.deepest = self.deepest.max(visit.level);
            if node.place != self.next_slot {
                return Err(broken(Rule::ListPlace, number).found(node.place).needed(self.next_slot));
            }
            let error = broken(Rule::ListPlace, number).found(node.number());
            self.order.list(self.view.list(node).ok_or(error)?.iter().copied())?;
            self.next_slot = self.next_slot.saturating_add(node.number());
            return Ok(());
        };
        let last = node.number().saturating_add(1);
        if node.number() != self.next_node || last >= count(self.view.nodes.len()) {
            return Err(broken(Rule::NodeOrder, number).found(node.number()).needed(self.next_node));
        }
        self.next_node = last.saturating_add(1);
        let (bounds, k) = (&visit.cell.bounds, cut.axis.at());
        if bounds.min[k] < cut.plane && cut.plane < bounds.max[k] {
            return Ok(());
        }
        Err(broken(Rule::Plane, number))
    }
}

/// Rule 28 for one primitive: from the root down to every leaf that needs it. The tree is proved.
fn complete(view: &View<'_>, prims: &Prims<'_>, slot: u32) -> Result<(), BlobError> {
    let Some(prim) = prims.get(slot) else { return Ok(()) };
    let own = prim.bounds();
    view.pass(
        |visit| {
            if !visit.cell.needs(&prim, &own) {
                return Ok(false);
            }
            let listed = || view.list(visit.node).is_some_and(|list| list.binary_search(&slot).is_ok());
            if visit.node.cut().is_some() || listed() {
                return Ok(true);
            }
            Err(broken(Rule::ListComplete, visit.number).needed(slot))
        },
        deep,
    )
}

/// A node that is not there, or one that lies deeper than any walk's stack.
const fn deep(node: u32, level: u32) -> BlobError {
    if level == 0 {
        return broken(Rule::NodeOrder, node);
    }
    broken(Rule::StackTrue, node).found(level).needed(MAX_STACK)
}

const fn broken(rule: Rule, node: u32) -> BlobError {
    BlobError::new(rule, Section::BspNodes).at(node)
}

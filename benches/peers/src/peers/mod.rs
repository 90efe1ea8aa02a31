pub mod brute;
pub mod bvh_crate;
pub mod embree;
pub mod flashray;
pub mod obvhs;
pub mod parry;
pub mod rtbvh;
pub mod tiny;

use crate::peer::Peer;

/// Every peer that can be measured. The first one is the reference of all ratios; see README.md for adding one.
/// `e4`, `e3`: the Embree libraries that could be opened; `ours`: where flashray's library is.
pub fn all(e4: Option<embree::Lib>, e3: Option<embree::Lib>, ours: &str) -> Vec<Box<dyn Peer>> {
    let mut v: Vec<Box<dyn Peer>> = vec![];
    v.extend(embree::peers(e4, e3));
    v.extend(tiny::peers());
    v.extend(obvhs::peers());
    v.extend(bvh_crate::peers());
    v.extend(parry::peers());
    v.extend(rtbvh::peers());
    v.extend(flashray::peers(ours));
    v
}

//! Good blobs, to be damaged: every structure, rule and mix of primitives, from none to a hundred.
use flashray::blob::{Buffer, KINDS};
use flashray::build::{Config, Mesh, Rule, to_vec};
use flashray::{Aabb, Cone, Cylinder, Kind, Sphere};
use std::sync::OnceLock;

/// A blob and what it is.
pub struct Good {
    /// A file name for it.
    pub name: String,
    /// Its bytes.
    pub bytes: Buffer,
}

const COUNTS: [usize; 6] = [0, 1, 2, 15, 16, 100];

/// Every way to build, the list first: it has no rule.
pub fn builds() -> impl Iterator<Item = Config> {
    let rules = |kind| if kind == Kind::List { &[Rule::Sah][..] } else { &[Rule::Seed, Rule::Sah] };
    let four = Config::new(Kind::Wide).width(4);
    let all = KINDS.iter().map(|&(kind, _)| Config::new(kind)).chain([four]);
    all.flat_map(move |config| rules(config.kind).iter().map(move |&rule| config.rule(rule)))
}

/// All of them, built once.
pub fn all() -> &'static [Good] {
    static ALL: OnceLock<Vec<Good>> = OnceLock::new();
    ALL.get_or_init(|| {
        let mut all = Vec::new();
        for build in builds() {
            let width = if build.width == 4 { "4" } else { "" };
            let name = format!("{}{width}-{:?}", build.kind.name(), build.rule).to_lowercase();
            for (count, mixed) in COUNTS.into_iter().flat_map(|n| [(n, false), (n, true)]) {
                let config = build.leaf(if mixed { 3 } else { 8 });
                let name = format!("{name}-{}{count}", if mixed { "mixed" } else { "triangles" });
                let blob = blob(&config, count, mixed);
                all.push(Good { name, bytes: Buffer::from(&blob[..]) });
            }
        }
        assert!(all.len() <= 256, "a byte picks one");
        all
    })
}

/// The blob that a number stands for.
pub fn pick(which: u8) -> &'static Good {
    let all = all();
    &all[usize::from(which) % all.len()]
}

fn blob(config: &Config, count: usize, mixed: bool) -> Vec<u8> {
    let mut random = Random(count as u64);
    let mut point = || [0, 1, 2].map(|_| f32::from(random.below(64)) / 4.0);
    let share = if mixed { count.div_ceil(5) } else { count };
    let positions: Vec<_> = (0..share * 3).map(|_| point()).collect();
    let triangles: Vec<_> = (0..share as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mut left = count - share;
    let mut next = || {
        let n = share.min(left);
        left -= n;
        0..n
    };
    let spheres: Vec<_> = next().map(|_| Sphere { center: point(), radius: 1.5 }).collect();
    let boxes: Vec<_> = next().map(|_| Aabb::EMPTY.with(point()).with(point())).collect();
    let cylinders = next().map(|i| Cylinder { base: point(), top: point(), radius: 0.5, caps: i as u32 & 1 });
    let cylinders: Vec<_> = cylinders.collect();
    let cones: Vec<_> = next().map(|_| Cone::capped(point(), point(), 1.0, 0.25)).collect();
    let mesh = Mesh::new(&positions, &triangles).spheres(&spheres).boxes(&boxes).cylinders(&cylinders).cones(&cones);
    to_vec(&mesh, config).expect("a good mesh is built")
}

/// A small generator (Steele, Lea and Flood's SplitMix64), so that blobs and seeds are the same everywhere.
pub struct Random(pub u64);

impl Random {
    /// The next 64 bits.
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n`.
    pub fn below(&mut self, n: u16) -> u16 {
        (self.word() % u64::from(n.max(1))) as u16
    }
}

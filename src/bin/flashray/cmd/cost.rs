//! What rays cost, measured: the steps and tests of a fixed set of them.
use crate::kinds::{KINDS, Order, Rays, SHADOW, Stage};
use flashray::blob::block;
use flashray::blob::prims::Primitive;
use flashray::build::{NODE_COST, NODE_COST_TUBES};
use flashray::walk::Meter;
use flashray::walk::mailbox::NoMailbox;
use flashray::wide::build as wide;
use flashray::{Kind, Ray, Scene};
use rayon::prelude::*;
use serde_json::{Value, json};

/// Rays of each kind.
const RAYS: usize = 16_384;
/// Tests that the list may spend on them.
const LISTED: usize = 400_000_000;

/// Steps, tests, and runs of up to four tests.
#[derive(Default, Clone, Copy)]
struct Count {
    nodes: u64,
    tests: u64,
    blocks: u64,
}

impl Meter for Count {
    fn node(&mut self) -> bool {
        self.nodes += 1;
        true
    }

    fn prims(&mut self, n: u32) -> bool {
        self.tests += u64::from(n);
        self.blocks += u64::from(n.div_ceil(block::LANES));
        true
    }

    fn untested(&mut self, n: u32) {
        self.tests -= u64::from(n);
    }
}

/// What a step costs, and what a test does: of one primitive, or of a block.
struct Weights {
    step: f64,
    test: f64,
    blocks: bool,
}

impl Weights {
    /// As the builder weighs them; 1 and 1 where it has no such pair.
    fn of(scene: &Scene<'_>) -> Self {
        let tube = |p| matches!(p, Primitive::Cylinder(_) | Primitive::Cone(_));
        let (step, test) = match scene.kind() {
            Kind::Bvh | Kind::Sphere if scene.primitives().any(|(_, p)| tube(p)) => (NODE_COST_TUBES, 1.0),
            Kind::Bvh | Kind::Sphere => (NODE_COST, 1.0),
            Kind::Wide => (wide::NODE_COST, wide::BLOCK_COST),
            _ => (1.0, 1.0),
        };
        let all_triangles = scene.primitives().all(|(_, p)| matches!(p, Primitive::Triangle(_)));
        Self { step: step.into(), test: test.into(), blocks: scene.kind() == Kind::Wide && all_triangles }
    }
}

/// Means per ray of each kind, and what they add up to.
pub struct Cost {
    pub weights: (f64, f64),
    pub rays: [usize; 4],
    /// For each kind steps, tests (of blocks, where there are blocks) and the weighted sum.
    pub means: [[f64; 3]; 4],
}

impl Cost {
    /// Traces camera, diffuse, shadow and chord rays, the same for a scene whatever its structure.
    pub fn new(scene: &Scene<'_>) -> Self {
        let (weights, list) = (Weights::of(scene), LISTED / (scene.len().max(1) as usize * 4));
        let count = if scene.kind() == Kind::List { list.clamp(16, RAYS) } else { RAYS };
        let rays = Rays::new(&Stage::default(), scene, count, Order::Rows);
        let mean = |kind: usize| {
            let of = |ray: &Ray| {
                let mut count = Count::default();
                // The blob was checked, so each walk ends, and none stops at an error.
                let _ = match kind {
                    SHADOW => scene.any_hit_metered(ray, &mut count, &mut NoMailbox),
                    _ => scene.closest_hit_metered(ray, &mut count, &mut NoMailbox).map(|hit| hit.is_some()),
                };
                count
            };
            let add = |a: Count, b: Count| Count {
                nodes: a.nodes + b.nodes,
                tests: a.tests + b.tests,
                blocks: a.blocks + b.blocks,
            };
            let sum = rays.kinds[kind].par_iter().map(of).reduce(Count::default, add);
            let n = rays.kinds[kind].len().max(1) as f64;
            let (nodes, tests) = (sum.nodes as f64 / n, if weights.blocks { sum.blocks } else { sum.tests } as f64 / n);
            [nodes, tests, weights.step * nodes + weights.test * tests]
        };
        let counts = [0, 1, 2, 3].map(|kind: usize| rays.kinds[kind].len());
        Self { weights: (weights.step, weights.test), rays: counts, means: [0, 1, 2, 3].map(mean) }
    }

    /// The mean over all kinds that have rays.
    pub fn all(&self) -> f64 {
        let met = (0..4).filter(|&k| self.rays[k] > 0);
        met.clone().map(|k| self.means[k][2]).sum::<f64>() / met.count().max(1) as f64
    }

    pub fn json(&self) -> Value {
        let mut facts = json!({ "all": self.all(), "step": self.weights.0, "test": self.weights.1 });
        for (k, kind) in KINDS.iter().enumerate() {
            let [steps, tests, cost] = self.means[k];
            facts[kind] = json!({ "rays": self.rays[k], "steps": steps, "tests": tests, "cost": cost });
        }
        facts
    }

    pub fn lines(&self) -> Vec<String> {
        let (step, test) = self.weights;
        let first = format!("ray cost     {:.2}, a step counted as {step:.1} and a test as {test:.1}", self.all());
        let kinds = (0..4).map(|k| {
            let ([steps, tests, cost], rays) = (self.means[k], self.rays[k]);
            format!("  {:<11}{cost:.2}: {steps:.2} steps and {tests:.2} tests in the mean of {rays} rays", KINDS[k])
        });
        std::iter::once(first).chain(kinds).collect()
    }
}

//! Building, checking, counting and timing: what each structure costs.
use super::super::info::Shape;
use super::super::median;
use super::super::trace::encode_hit;
use super::{Args, Built};
use crate::Failure;
use crate::kinds::{KINDS, Rays, SHADOW};
use flashray::blob::{Blob, Buffer, Section};
use flashray::build::{Config, Mesh, Rule, to_buffer};
use flashray::walk::mailbox::Last8;
use flashray::{Kind, Ray, Scene, Steps};
use indicatif::ProgressBar;
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::hint::black_box;
use std::time::Instant;

/// Tests that the list may spend on finding the truth: some seconds. Beyond that it answers for a sample of the rays.
const TRUTH_TESTS: usize = 200_000_000;
/// Tests that the list may spend on a pass when it is timed.
const TIMED_TESTS: usize = 4_000_000;
/// Rays of a group.
pub const GROUP: usize = 64;

/// Every structure with both rules; the list, which has none, once.
pub fn build_all(args: &Args, mesh: &Mesh<'_>, bar: &ProgressBar) -> Result<Vec<Built>, Failure> {
    let mut all = Vec::new();
    for &(kind, name) in flashray::blob::KINDS {
        let rules: &[_] =
            if kind == Kind::List { &[(Rule::Sah, "")] } else { &[(Rule::Seed, "seed"), (Rule::Sah, "sah")] };
        for &(rule, rule_name) in rules {
            let config = Config::new(kind).rule(rule).leaf(args.leaf).quality(args.quality.quality());
            let (mut seconds, mut blob) = (Vec::new(), Buffer::default());
            // Small scenes build in less time than a clock is good for.
            while seconds.is_empty() || (seconds.len() < args.rounds as usize && seconds.iter().sum::<f64>() < 0.1) {
                let start = Instant::now();
                blob = to_buffer(mesh, &config).map_err(|e| format!("{}: {name} {rule_name}: {e}", args.input))?;
                seconds.push(start.elapsed().as_secs_f64());
            }
            all.push(Built { kind, rule: rule_name, blob, seconds: median(&mut seconds) });
            bar.inc(1);
        }
    }
    Ok(all)
}

/// What is known of a structure without a ray.
pub fn facts(built: &Built, scene: &Scene<'_>, check_seconds: f64) -> Result<Value, Failure> {
    let blob = Blob::parse(&built.blob).map_err(|e| format!("{}: {e}", built.name()))?;
    let name = |number: u32| Section::LISTED.iter().find(|s| s.number() == number).map_or("?", |s| s.name());
    let sections: Map<String, Value> =
        blob.entries().iter().map(|e| (name(e.section).to_owned(), json!(e.length))).collect();
    let sum = |which: &dyn Fn(u32) -> bool| -> u64 {
        blob.entries().iter().filter(|e| which(e.section)).map(|e| u64::from(e.length)).sum()
    };
    let lists = |s: u32| s == Section::CellLists.number() || s == Section::VoxelLists.number();
    let first = Section::BvhNodes.number();
    let (shape, limits, prims) = (Shape::new(scene), scene.limits(), f64::from(scene.len().max(1)));
    Ok(json!({
        "kind": built.kind.name(), "rule": (!built.rule.is_empty()).then_some(built.rule),
        "build_seconds": built.seconds, "check_seconds": check_seconds,
        "bytes": built.blob.len(), "bytes_per_primitive": built.blob.len() as f64 / prims,
        "primitive_bytes": sum(&|s| s < first),
        "node_bytes": sum(&|s| s >= first && !lists(s)),
        "reference_bytes": sum(&lists),
        "sections": sections,
        "nodes": shape.nodes, "leaves": shape.leaves, "depth": shape.depth,
        "references_per_primitive": shape.listed as f64 / prims, "sah_cost": shape.sah_cost,
        "limits": { "stack": limits.stack, "steps": limits.steps },
    }))
}

/// An answer as comparable bytes.
type Answer = [u8; 16];

fn answer(scene: &Scene<'_>, ray: &Ray, any: bool) -> Answer {
    if any { yes_or_no(scene.any_hit(ray)) } else { encode_hit(scene.closest_hit(ray)) }
}

/// The same with a mailbox.
fn mailed_answer(scene: &Scene<'_>, ray: &Ray, any: bool) -> Answer {
    let mailbox = &mut Last8::default();
    if any {
        yes_or_no(scene.any_hit_mailed(ray, mailbox).0)
    } else {
        encode_hit(scene.closest_hit_mailed(ray, mailbox).0)
    }
}

fn yes_or_no(found: bool) -> Answer {
    [u8::from(found); 16]
}

/// What every structure must answer.
pub struct Truth {
    answers: [Vec<Answer>; 4],
    /// How many of them are the list's; the others are the hierarchy's.
    pub listed: usize,
}

impl Truth {
    /// The list's answers, or where that takes too long those of `other` with the list's on a sample.
    pub fn new(list: &Scene<'_>, other: &Scene<'_>, rays: &Rays) -> Self {
        let all: usize = rays.kinds.iter().map(Vec::len).sum();
        let every = (all * list.len() as usize).div_ceil(TRUTH_TESTS).clamp(1, (all / 64).max(1));
        let find = |kind: usize| {
            let any = kind == SHADOW;
            let of = |(i, ray): (usize, &Ray)| answer(if i % every == 0 { list } else { other }, ray, any);
            rays.kinds[kind].par_iter().enumerate().map(of).collect::<Vec<_>>()
        };
        let answers = [0, 1, 2, 3].map(find);
        Self { answers, listed: rays.kinds.iter().map(|rays| rays.len().div_ceil(every)).sum() }
    }

    /// How many answers of a structure differ in any bit, with a mailbox or without.
    pub fn wrong(&self, scene: &Scene<'_>, rays: &Rays) -> usize {
        let wrong = |kind: usize| {
            let any = kind == SHADOW;
            let differs = |(ray, truth): &(&Ray, &Answer)| {
                answer(scene, ray, any) != **truth || mailed_answer(scene, ray, any) != **truth
            };
            rays.kinds[kind].par_iter().zip(&self.answers[kind]).filter(differs).count()
        };
        (0..KINDS.len()).map(wrong).sum()
    }
}

/// Adds steps and tests per ray of each kind, and tests that a mailbox spares. `all` is over the rays that ask for the
/// closest hit, since how early the others stop is a matter of the order of the primitives.
pub fn count(facts: &mut Value, scene: &Scene<'_>, rays: &Rays) {
    let add = |a: [u64; 3], b: [u64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    let any = |ray: &Ray| {
        let plain: Steps = scene.any_hit_counted(ray).1;
        let mailed = scene.any_hit_mailed(ray, &mut Last8::default()).1;
        [plain.nodes, plain.prims, mailed.spared].map(u64::from)
    };
    let closest = |ray: &Ray| {
        let plain: Steps = scene.closest_hit_counted(ray).1;
        let mailed = scene.closest_hit_mailed(ray, &mut Last8::default()).1;
        [plain.nodes, plain.prims, mailed.spared].map(u64::from)
    };
    let names = ["steps_per_ray", "tests_per_ray", "spared_per_ray"];
    let (mut sums, mut counted) = ([0; 3], 0);
    for (i, (kind, rays)) in KINDS.iter().zip(&rays.kinds).enumerate() {
        let of = |ray| if i == SHADOW { any(ray) } else { closest(ray) };
        let sum = rays.par_iter().map(of).reduce(|| [0; 3], add);
        if i != SHADOW {
            (sums, counted) = (add(sums, sum), counted + rays.len());
        }
        for (name, sum) in names.iter().zip(sum) {
            facts[name][kind] = json!((!rays.is_empty()).then(|| sum as f64 / rays.len() as f64));
        }
    }
    for (name, sum) in names.iter().zip(sums) {
        facts[name]["all"] = json!(sum as f64 / counted.max(1) as f64);
    }
}

/// Adds millions of rays a second for each kind, one by one and in groups, on one thread: medians of rounds, in each of
/// which all structures take their turn, so that whatever else the machine does meets all alike.
pub fn time(rows: &mut [Value], scenes: &[Scene<'_>], rays: &Rays, rounds: usize, bar: &ProgressBar) {
    let mut rates = vec![[const { [const { Vec::new() }; 4] }; 2]; scenes.len()];
    for _ in 0..rounds {
        for (scene, rates) in scenes.iter().zip(&mut rates) {
            for (kind, rays) in rays.kinds.iter().enumerate() {
                let rays = sample(scene, rays);
                // Once without looking at the clock: what others left in the caches is not this structure's fault.
                pass(scene, &rays, kind == SHADOW, 1);
                for (group, rates) in [1, GROUP].into_iter().zip(rates.iter_mut()) {
                    rates[kind].extend(pass(scene, &rays, kind == SHADOW, group));
                }
            }
            bar.inc(1);
        }
    }
    let speed = |mut rates: Vec<f64>| (!rates.is_empty()).then(|| median(&mut rates));
    let speeds: Vec<[[Option<f64>; 4]; 2]> = rates.into_iter().map(|ways| ways.map(|kinds| kinds.map(speed))).collect();
    let list = scenes.iter().position(|scene| scene.kind() == Kind::List).map_or([None; 4], |i| speeds[i][0]);
    for (row, [single, grouped]) in rows.iter_mut().zip(&speeds) {
        for (i, name) in KINDS.iter().enumerate() {
            row["mrays_per_second"][name] = json!(single[i]);
            row["mrays_per_second_in_groups"][name] = json!(grouped[i]);
            row["over_list"][name] = json!(single[i].zip(list[i]).map(|(fast, slow)| fast / slow));
        }
    }
}

/// The rays of a pass: all of them, or for the list a sample.
fn sample(scene: &Scene<'_>, rays: &[Ray]) -> Vec<Ray> {
    let all = rays.len().max(1);
    let fair = (TIMED_TESTS / (scene.len() as usize).max(1)).clamp(16, all.max(16));
    let every = if scene.kind() == Kind::List { all.div_ceil(fair) } else { 1 };
    rays.iter().step_by(every).copied().collect()
}

/// Millions of rays a second of one pass, with so many rays in a call.
fn pass(scene: &Scene<'_>, rays: &[Ray], any: bool, group: usize) -> Option<f64> {
    let (mut hits, mut shadows) = (vec![None; group], vec![false; group]);
    let start = Instant::now();
    match (group, any) {
        (1, true) => rays.iter().for_each(|ray| _ = black_box(scene.any_hit(black_box(ray)))),
        (1, false) => rays.iter().for_each(|ray| _ = black_box(scene.closest_hit(black_box(ray)))),
        (_, true) => rays.chunks(group).for_each(|rays| scene.any_hits(black_box(rays), black_box(&mut shadows))),
        (_, false) => rays.chunks(group).for_each(|rays| scene.closest_hits(black_box(rays), black_box(&mut hits))),
    }
    let seconds = start.elapsed().as_secs_f64();
    (!rays.is_empty()).then(|| super::super::millions_per_second(rays.len(), seconds))
}

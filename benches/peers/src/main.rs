//! Measures existing ray-tracing acceleration libraries side by side on one thread. See README.md.
mod clock;
mod exact;
mod page;
mod peer;
mod peers;
mod rays;
mod report;
mod rng;
mod scene;

use peer::*;
use rays::SETS;
use report::*;
use scene::Scene;
use std::collections::BTreeMap;

#[global_allocator]
static ALLOC: clock::Counting = clock::Counting;

struct Options {
    quick: bool,
    all: bool,
    res: usize,
    rounds: usize,
    slice: usize,
    validate_s: f64,
    scale: Option<f32>,
    only: Vec<String>,
    skip: Vec<String>,
    scenes: Vec<String>,
    json: Option<String>,
    embree4: Option<String>,
    ours: String,
    files: Vec<String>,
}

const USAGE: &str = "usage: host-anchors [options] [mesh.obj|mesh.ply[@ex,ey,ez,tx,ty,tz,fov]]...
  --quick           smaller images, scenes, peer list and fewer rounds (within a minute)
  --all             also the peers that are left out by default
  --peers A,B       only peers whose name contains A or B (the reference always runs)
  --skip A,B        without the peers whose name contains A or B
  --scenes A,B      procedural scenes: flake,soup,terrain or none (default: all three)
  --rounds N        timing rounds (default 5)
  --res N           image size, a multiple of 16 (default 1024)
  --slice N         rays per peer and round (default 32768)
  --validate-all    check every ray of slow peers too (default: stop a ray set after 0.6 CPU seconds)
  --scale N         rescale every scene to a bounding-box diagonal of N (default: as it is)
  --embree4 PATH    the Embree 4 shared library (default: $EMBREE4_LIB, embree4/, the system's)
  --ours PATH       flashray's library (default: $FLASHRAY_LIB, ours/target/release/libflashray_ours.so)
  --json FILE       write the results
  --page PAGE FILE..  write no results, but put the tables of those written before between the marks of a page";

fn options() -> Options {
    let mut o = Options {
        quick: false,
        all: false,
        res: 1024,
        rounds: 5,
        slice: 32768,
        validate_s: 0.6,
        scale: None,
        only: vec![],
        skip: vec![],
        scenes: ["flake", "soup", "terrain"].map(String::from).to_vec(),
        json: None,
        embree4: std::env::var("EMBREE4_LIB").ok(),
        ours: std::env::var("FLASHRAY_LIB").unwrap_or("ours/target/release/libflashray_ours.so".into()),
        files: vec![],
    };
    let mut a = std::env::args().skip(1).peekable();
    if a.next_if_eq("--page").is_some() {
        page::fill(&a.next().expect(USAGE), &a.collect::<Vec<_>>());
        std::process::exit(0);
    }
    let list = |s: Option<String>| -> Vec<String> { s.expect(USAGE).split(',').map(String::from).collect() };
    while let Some(x) = a.next() {
        match x.as_str() {
            "--quick" => (o.quick, o.res, o.rounds, o.slice, o.validate_s) = (true, 256, 5, 16384, 0.1),
            "--all" => o.all = true,
            "--peers" => o.only = list(a.next()),
            "--skip" => o.skip = list(a.next()),
            "--scenes" => o.scenes = list(a.next()),
            "--rounds" => o.rounds = a.next().expect(USAGE).parse().expect(USAGE),
            "--res" => o.res = a.next().expect(USAGE).parse().expect(USAGE),
            "--slice" => o.slice = a.next().expect(USAGE).parse().expect(USAGE),
            "--validate-all" => o.validate_s = f64::INFINITY,
            "--scale" => o.scale = Some(a.next().expect(USAGE).parse().expect(USAGE)),
            "--embree4" => o.embree4 = Some(a.next().expect(USAGE)),
            "--ours" => o.ours = a.next().expect(USAGE),
            "--json" => o.json = Some(a.next().expect(USAGE)),
            s if s.starts_with('-') => panic!("{s}?\n{USAGE}"),
            _ => o.files.push(x),
        }
    }
    assert!(o.res.is_multiple_of(16) && o.rounds > 0, "{USAGE}");
    o
}

/// Most rays of a set and a peer that the f64 reference is asked about.
const ASKED: usize = 256;

/// Rays are taken in chunks, so that neighbours stay neighbours (four 16x16 tiles of primary rays).
const CHUNK: usize = 1024;

/// The rays of one timing round: chunks spread evenly over the set, others in every round.
fn slice(rays: &[Ray], want: usize, round: usize) -> Vec<Ray> {
    let chunks = rays.len() / CHUNK;
    let n = (want / CHUNK).min(chunks);
    if n == 0 {
        return rays[..rays.len() / 256 * 256].to_vec();
    }
    let mut out = Vec::with_capacity(n * CHUNK);
    for k in 0..n {
        let c = (k * chunks / n + round * 7919) % chunks;
        out.extend_from_slice(&rays[c * CHUNK..(c + 1) * CHUNK]);
    }
    out
}

fn trace(p: &dyn Peer, set: usize, r: &[Ray], h: &mut [Hit], b: &mut [bool]) -> f64 {
    let t = clock::thread();
    if rays::is_any(set) {
        p.any(r, &mut b[..r.len()]);
    } else {
        p.closest(r, &mut h[..r.len()]);
    }
    clock::thread() - t
}

fn median(v: &mut [f64]) -> f64 {
    v.sort_by(f64::total_cmp);
    let n = v.len();
    if n == 0 {
        f64::NAN
    } else if n % 2 == 1 {
        v[n / 2]
    } else {
        0.5 * (v[n / 2 - 1] + v[n / 2])
    }
}

fn can(p: &dyn Peer, set: usize) -> bool {
    p.can() == Can::All || set == 0
}

fn run_scene(s: &Scene, peers: &mut [Box<dyn Peer>], judge: usize, o: &Options) -> SceneResult {
    eprintln!("== {} ({} triangles)", s.name, s.tris.len());
    let mut rows: Vec<Row> = vec![];
    let mut active: Vec<usize> = vec![];
    for (i, p) in peers.iter_mut().enumerate() {
        if s.tris.len() > p.max_tris() {
            continue;
        }
        let b = p.build(&s.tris);
        eprintln!("   {:24} built in {:8.1} ms CPU", p.name(), b.ms);
        active.push(i);
        rows.push(Row {
            peer: p.name(),
            build_ms: b.ms,
            bytes_per_tri: b.bytes.map(|x| x as f64 / s.tris.len() as f64),
            miss_ns: f64::NAN,
            cells: Default::default(),
        });
    }

    // rays, from the judge's hits
    let j = peers[judge].as_ref();
    let prim = rays::primary(s, o.res);
    let mut first = vec![Hit::MISS; prim.len()];
    j.closest(&prim, &mut first);
    let sets = [
        prim.clone(),
        rays::diffuse(s, &prim, &first),
        rays::shadow(s, &prim, &first),
        rays::random(s, o.res * o.res / 4),
    ];
    let mut result = SceneResult { scene: s.name.clone(), triangles: s.tris.len(), sets: vec![], rows: vec![] };
    let biggest = sets.iter().map(|s| s.len()).max().unwrap().max(16384);
    let (mut h, mut b) = (vec![Hit::MISS; biggest], vec![false; biggest]);

    // ---- rays that miss everything: the fixed cost of a call
    let away = rays::away(s, 16384);
    let mut ns: Vec<Vec<f64>> = vec![vec![]; active.len()];
    for _ in 0..o.rounds {
        for (row, &i) in active.iter().enumerate() {
            ns[row].push(trace(peers[i].as_ref(), 0, &away, &mut h, &mut b) * 1e9 / away.len() as f64);
        }
    }
    for (row, v) in rows.iter_mut().zip(&mut ns) {
        row.miss_ns = median(v);
    }

    for (set, rays) in sets.iter().enumerate() {
        let n = rays.len();
        // ---- every answer against the judge's
        let (mut want_h, mut want_b) = (vec![Hit::MISS; n], vec![false; n]);
        trace(j, set, rays, &mut want_h, &mut want_b);
        let any = rays::is_any(set);
        let hits = if any {
            want_b.iter().filter(|x| **x).count()
        } else {
            want_h.iter().filter(|x| x.t < f32::INFINITY).count()
        };
        result.sets.push(SetInfo { name: SETS[set].into(), rays: n, hits });
        if n < 256 {
            continue;
        }
        let tol = 1e-3 * s.diag();
        let mut speed = vec![f64::NAN; active.len()];
        for (row, &i) in active.iter().enumerate() {
            let p = peers[i].as_ref();
            if !can(p, set) {
                continue;
            }
            // pieces in a scattered order, so that a time limit still sees the whole set
            let piece = 16384;
            let pieces = n.div_ceil(piece);
            let (mut bad, mut checked, mut secs) = (Bad::default(), 0, 0.0);
            let stride =
                (1..pieces.max(2)).rev().find(|k| gcd(*k, pieces) == 1 && *k <= pieces * 5 / 8 + 1).unwrap_or(1);
            for k in 0..pieces {
                let at = (k * stride % pieces) * piece;
                let end = (at + piece).min(n);
                let end = if p.can() == Can::All { end } else { at + (end - at) / 256 * 256 };
                let r = &rays[at..end];
                secs += trace(p, set, r, &mut h, &mut b);
                checked += r.len();
                for q in 0..r.len() {
                    let (wrong_hit, wrong_t) = if any {
                        (b[q] != want_b[at + q], false)
                    } else {
                        let (a, w) = (h[q].t, want_h[at + q].t);
                        let other = (a < f32::INFINITY) != (w < f32::INFINITY);
                        (other, !other && a < f32::INFINITY && (a - w).abs() > tol)
                    };
                    bad.miss += wrong_hit as usize;
                    bad.t += wrong_t as usize;
                    if (wrong_hit || wrong_t) && p.name().starts_with("flashray") && bad.miss + bad.t <= ASKED {
                        let t = match (any, b[q], h[q].t < f32::INFINITY) {
                            (true, true, _) => 0.0,
                            (false, _, true) => f64::from(h[q].t),
                            _ => f64::INFINITY,
                        };
                        match exact::judge(&s.tris, &r[q], t, any, f64::from(tol)) {
                            exact::Verdict::Right => bad.upheld += 1,
                            exact::Verdict::Undecided => bad.undecided += 1,
                            exact::Verdict::Wrong => {}
                        }
                    }
                }
                if secs > o.validate_s {
                    break;
                }
            }
            speed[row] = checked as f64 / secs;
            rows[row].cells[set] =
                Some(Cell { mrays: f64::NAN, ratio: f64::NAN, ratio_lo: f64::NAN, ratio_hi: f64::NAN, bad, checked });
        }

        // ---- timing: all peers in turn, round after round, on the same rays
        let mut times: Vec<Vec<f64>> = vec![vec![]; active.len()];
        let mut ratios: Vec<Vec<f64>> = vec![vec![]; active.len()];
        for round in 0..o.rounds {
            let full = slice(rays, o.slice, round);
            let warm = slice(rays, o.slice / 4, round + 1000);
            // slow peers get a part of the rays; the reference is timed on that part, too
            let part: Vec<Ray> = if full.len() >= 8 * CHUNK {
                full.chunks(CHUNK).step_by(4).flatten().copied().collect()
            } else {
                full.clone()
            };
            let slow = |row: usize| speed[row] < 0.4e6;
            let any_slow = (0..active.len()).any(slow);
            let mut rate = vec![f64::NAN; active.len()];
            let mut ref_part = f64::NAN;
            for k in 0..active.len() {
                let row = (k + round) % active.len();
                let p = peers[active[row]].as_ref();
                if !can(p, set) {
                    continue;
                }
                let r: &[Ray] = if slow(row) { &part } else { &full };
                trace(p, set, &warm[..warm.len() / if slow(row) { 4 } else { 1 } / 256 * 256], &mut h, &mut b);
                rate[row] = r.len() as f64 / trace(p, set, r, &mut h, &mut b);
                if row == 0 && any_slow {
                    ref_part = part.len() as f64 / trace(p, set, &part, &mut h, &mut b);
                }
            }
            for row in 0..active.len() {
                if rate[row].is_finite() {
                    times[row].push(rate[row] * 1e-6);
                    ratios[row].push(rate[row] / if slow(row) { ref_part } else { rate[0] });
                }
            }
        }
        for row in 0..active.len() {
            if let Some(c) = &mut rows[row].cells[set] {
                c.mrays = median(&mut times[row]);
                c.ratio = median(&mut ratios[row]);
                let n = ratios[row].len();
                (c.ratio_lo, c.ratio_hi) = (ratios[row][n / 4], ratios[row][(3 * n / 4).min(n - 1)]);
            }
        }
    }
    for p in peers.iter_mut() {
        p.clear();
    }
    result.rows = rows;
    result
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

fn main() {
    // rtbvh builds with rayon
    unsafe { std::env::set_var("RAYON_NUM_THREADS", "1") };
    let o = options();
    let mut e4: Vec<String> = o.embree4.iter().cloned().collect();
    if let Ok(dir) = std::fs::read_dir("embree4") {
        e4.extend(dir.flatten().map(|f| f.path().to_string_lossy().to_string()).filter(|f| f.contains("libembree4")));
    }
    e4.extend(["libembree4.so.4", "libembree4.so"].map(String::from));
    let lib4 = peers::embree::Lib::open(&e4);
    let lib3 = peers::embree::Lib::open(&["libembree3.so.3", "libembree3.so"].map(String::from));
    for l in [&lib4, &lib3].into_iter().flatten() {
        eprintln!("Embree {}", l.version);
    }
    assert!(
        lib4.is_some() || lib3.is_some(),
        "no Embree library found: it is the reference and makes the rays (see README.md)"
    );
    let mut peers = peers::all(lib4, lib3, &o.ours);

    // the reference (first) and the judge of correctness (first robust one) always stay
    let reference = peers[0].name();
    let judge_name = peers.iter().map(|p| p.name()).find(|n| n.ends_with("-robust")).expect("a robust peer");
    let hit = |l: &[String], n: &str| l.iter().any(|x| n.contains(x.as_str()));
    const QUICK: [&str; 12] = [
        "embree4-i1",
        "embree3-i1",
        "embree4-i1-high",
        "embree4-i1-robust",
        "embree4-p16-coh",
        "tinybvh-BVH8",
        "tinybvh-BVH8-hq",
        "obvhs-bvh2-fast",
        "obvhs-cwbvh-fast",
        "obvhs-cwbvh-best",
        "bvh-nearest",
        "parry3d",
    ];
    peers.retain(|p| {
        let n = p.name();
        if n == reference || n == judge_name {
            return true;
        }
        let listed = if !o.only.is_empty() {
            hit(&o.only, &n)
        } else if o.quick {
            // peers that this list does not know (newly added ones) run, too
            QUICK.contains(&n.as_str())
                || !["embree", "tinybvh", "obvhs", "bvh-", "parry3d", "rtbvh"].iter().any(|k| n.starts_with(k))
        } else {
            o.all || !p.extra()
        };
        listed && !hit(&o.skip, &n)
    });
    let judge = peers.iter().position(|p| p.name() == judge_name).unwrap();

    let start = std::time::Instant::now();
    let mut results: Vec<SceneResult> = vec![];
    let mut naive: Option<serde_json::Value> = None;
    let mut jobs: Vec<Box<dyn Fn() -> Scene>> = vec![];
    for f in o.files.clone() {
        jobs.push(Box::new(move || scene::load(&f)));
    }
    for name in o.scenes.clone() {
        let q = o.quick;
        match name.as_str() {
            "flake" => jobs.push(Box::new(move || if q { scene::flake(2, 3) } else { scene::flake(3, 3) })),
            "soup" => jobs.push(Box::new(move || scene::soup(if q { 50_000 } else { 200_000 }))),
            "terrain" => jobs.push(Box::new(move || scene::terrain(if q { 200 } else { 500 }))),
            "none" => {}
            _ => panic!("scene {name}?\n{USAGE}"),
        }
    }
    for (k, job) in jobs.iter().enumerate() {
        let mut s = job();
        if let Some(k) = o.scale {
            let f = k / s.diag();
            let t = s.tris.iter().map(|t| t.map(|v| v.map(|x| x * f))).collect();
            let (name, camera) =
                (s.name.clone(), s.camera.map(|(e, t, fov)| (e.map(|x| x * f), t.map(|x| x * f), fov)));
            s = Scene { camera, ..Scene::new(&name, t) };
        }
        let r = run_scene(&s, &mut peers, judge, &o);
        print!("{}", table(&r));
        // the naive rate, on the bunny (or on the first scene if there is no bunny by the end)
        if naive.is_none() && (s.name.contains("bunny") || k + 1 == jobs.len()) {
            let n = if o.quick { 64 } else { 512 };
            let all = rays::primary(&s, 1024);
            let some: Vec<Ray> = (0..n).map(|i| all[(i * 104_729 + 524_800) % all.len()]).collect();
            let (a, b) = peers::brute::rates(&s.tris, &some);
            let best = |f: &dyn Fn(&Row) -> f64| r.rows.iter().map(f).fold(0.0, f64::max);
            let reference = r.rows[0].cells[0].map_or(f64::NAN, |c| c.mrays);
            let fastest = best(&|r: &Row| r.cells[0].map_or(0.0, |c| c.mrays));
            println!(
                "naive loop on {} ({} triangles, {n} primary rays): {:.1} rays/s scalar with early outs, {:.1} rays/s 16-wide branch-free;\n  \
                 hierarchy over naive scalar: {:.0}x (reference), {:.0}x (fastest peer); over the wide naive loop: {:.0}x, {:.0}x\n",
                s.name,
                s.tris.len(),
                a,
                b,
                reference * 1e6 / a,
                fastest * 1e6 / a,
                reference * 1e6 / b,
                fastest * 1e6 / b
            );
            naive = Some(serde_json::json!({
                "scene": s.name, "triangles": s.tris.len(), "rays": n, "scalar_rays_per_s": a, "wide_rays_per_s": b,
                "reference_mrays": reference, "fastest_mrays": fastest,
            }));
        }
        results.push(r);
    }
    print!("{}", summary(&results));
    let mut info = BTreeMap::new();
    println!("\nPeers:");
    for p in &peers {
        println!("  {:24} {}", p.name(), p.info());
        info.insert(p.name(), p.info());
    }
    println!(
        "\nrun took {:.0} s; reference {reference}, answers judged by {judge_name}",
        start.elapsed().as_secs_f64()
    );
    if let Some(f) = &o.json {
        let j = to_json(&results, &info, naive, &reference, &judge_name);
        std::fs::write(f, serde_json::to_string_pretty(&j).unwrap()).expect("write JSON");
    }
}

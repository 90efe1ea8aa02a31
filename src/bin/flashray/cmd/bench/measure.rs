//! Timing: all ways take turns, and every answer is held against the first way's.
use super::super::trace::encode_hit;
use super::Way;
use crate::kinds::{KINDS, Rays, SHADOW};
use flashray::walk::PacketSize;
use flashray::{Hit, Ray};
use indicatif::ProgressBar;
use std::hint::black_box;
use std::time::Instant;

/// Rays of a call, in all modes but the single one: so many that what a call costs by itself, such as to clear the scratch of a
/// stream, is little beside them.
const CALL: usize = 1024;

/// Nanoseconds per ray of one way in each round: for each kind of rays, and for rays that miss everything.
#[derive(Clone, Default)]
pub struct Rounds {
    pub kinds: [Vec<f64>; 4],
    pub away: Vec<f64>,
}

/// Those of all ways.
pub struct Times {
    pub all: Vec<Rounds>,
}

/// What rays ask for, and how it is said in messages.
struct Question<'a> {
    rays: &'a [Ray],
    any: bool,
    name: &'static str,
}

/// What is answered; of the two, the one that was asked for.
#[derive(Clone)]
struct Answers {
    hits: Vec<Option<Hit>>,
    found: Vec<bool>,
}

impl Times {
    /// Measures.
    ///
    /// # Errors
    /// The first answer of any way in any round that is not, bit for bit, that of the first way.
    pub fn new(ways: &[Way<'_>], rays: &Rays, away: &[Ray], rounds: usize, bar: &ProgressBar) -> Result<Self, String> {
        let kinds = KINDS.iter().zip(&rays.kinds).enumerate();
        let mut questions: Vec<_> = kinds.map(|(i, (&name, rays))| Question { rays, any: i == SHADOW, name }).collect();
        questions.push(Question { rays: away, any: false, name: "missing" });
        let mut all = vec![Rounds::default(); ways.len()];
        for (kind, question) in questions.iter().enumerate() {
            let mut answers = Answers::none(question.rays.len());
            let Some(first) = ways.first() else { break };
            first.ask(question, &mut answers);
            let truth = answers.clone();
            for round in 0..rounds {
                for turn in 0..ways.len() {
                    let at = (turn + round) % ways.len();
                    let ns = ways[at].timed(question, &mut answers);
                    truth.compare(&answers, question, &ways[at], first)?;
                    let rounds = &mut all[at];
                    rounds.kinds.get_mut(kind).unwrap_or(&mut rounds.away).extend(ns);
                    bar.inc(1);
                }
            }
        }
        Ok(Self { all })
    }
}

impl Way<'_> {
    fn ask(&self, question: &Question<'_>, answers: &mut Answers) {
        let rays = black_box(question.rays).chunks(CALL);
        if question.any {
            rays.zip(answers.found.chunks_mut(CALL))
                .for_each(|(rays, found)| self.mode.any(&self.scene, PacketSize::Eight, rays, found));
        } else {
            rays.zip(answers.hits.chunks_mut(CALL))
                .for_each(|(rays, hits)| self.mode.closest(&self.scene, PacketSize::Eight, rays, hits));
        }
        black_box(answers);
    }

    /// Nanoseconds per ray.
    fn timed(&self, question: &Question<'_>, answers: &mut Answers) -> Option<f64> {
        // Once without looking at the clock: what others left in the caches is not this way's fault.
        self.ask(question, answers);
        *answers = Answers::none(question.rays.len());
        let start = Instant::now();
        self.ask(question, answers);
        let seconds = start.elapsed().as_secs_f64();
        (!question.rays.is_empty()).then(|| seconds * 1e9 / question.rays.len() as f64)
    }
}

impl Answers {
    /// For so many rays, none yet.
    fn none(rays: usize) -> Self {
        Self { hits: vec![None; rays], found: vec![false; rays] }
    }

    /// In bits and words.
    fn of(&self, ray: usize) -> ([u8; 16], String) {
        let (hit, found) = (self.hits[ray], self.found[ray]);
        let words = match hit {
            Some(hit) => format!("t {} u {} v {} prim {}", hit.t, hit.u, hit.v, hit.prim),
            None => if found { "a hit" } else { "no hit" }.to_owned(),
        };
        (if hit.is_some() { encode_hit(hit) } else { [u8::from(found); 16] }, words)
    }

    fn compare(&self, other: &Self, question: &Question<'_>, way: &Way<'_>, first: &Way<'_>) -> Result<(), String> {
        let differs = |&ray: &usize| self.of(ray).0 != other.of(ray).0;
        let Some(ray) = (0..question.rays.len()).find(differs) else { return Ok(()) };
        let (wrong, right, kind) = (other.of(ray).1, self.of(ray).1, question.name);
        let (way, first) = (way.name(), first.name());
        Err(format!("answers differ: {kind} ray {ray} has {wrong} by {way}, {right} by {first}"))
    }
}

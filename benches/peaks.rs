//! What a core of this machine can do at best, for `benches/roofline.sh`, which compiles this: f32 operations a second with
//! AVX2, and for each level of memory bytes a second read in order, and the wait for an address that memory itself told.
//!
//! Prints lines `key value`: `operations` in 10^9 a second, `read SIZE` in 10^9 bytes a second, `chase SIZE` in
//! nanoseconds; SIZE is in bytes, and given as arguments.
use std::arch::x86_64::{__m256, _mm256_add_ps, _mm256_loadu_si256, _mm256_mul_ps, _mm256_set1_ps};
use std::arch::x86_64::{__m256i, _mm256_or_si256, _mm256_setzero_si256};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Each measurement goes on for so long, in pieces. Of ten the second best counts: what else runs takes from a piece, and
/// one that was by chance in a nearer cache gets more than its due.
const TIME: Duration = Duration::from_millis(400);
/// Bytes of a piece that is read in order.
const PIECE: usize = 1 << 20;

fn main() {
    assert!(is_x86_feature_detected!("avx2"), "this machine has no AVX2");
    // SAFETY: it was just asked for.
    println!("operations {:.1}", good(|_| unsafe { operations() }));
    for size in std::env::args().skip(1) {
        let bytes: usize = size.parse().expect("a size in bytes");
        let lines = cycle(bytes / LINE);
        // What is smaller than a piece is read several times over.
        let piece = PIECE.min(bytes) / LINE;
        let (pieces, times) = (lines.len() / piece, PIECE.div_ceil(bytes));
        let read = good(|i| rate(&lines[i % pieces * piece..][..piece], times));
        let mut at = 0;
        let chase = 1.0 / good(|_| steps(&lines, &mut at));
        println!("read {size} {read:.1}\nchase {size} {chase:.2}");
    }
}

/// A good piece of a measurement; each is told its number.
fn good(mut piece: impl FnMut(usize) -> f64) -> f64 {
    let start = Instant::now();
    let mut all: Vec<f64> = (0..).take_while(|_| start.elapsed() < TIME).map(&mut piece).collect();
    all.sort_by(f64::total_cmp);
    all[(all.len() - 1) * 9 / 10]
}

/// Billions of additions and multiplications a second, in equal parts and none fused, as no result of ours may be.
#[target_feature(enable = "avx2")]
fn operations() -> f64 {
    const CHAINS: usize = 12;
    const STEPS: u32 = 20_000;
    let (factor, term) = (black_box(_mm256_set1_ps(0.5)), black_box(_mm256_set1_ps(1.0)));
    let mut chains: [__m256; CHAINS] = [term; CHAINS];
    let start = Instant::now();
    for _ in 0..STEPS {
        for chain in &mut chains {
            *chain = _mm256_add_ps(_mm256_mul_ps(*chain, factor), term);
        }
    }
    let elapsed = start.elapsed();
    black_box(chains);
    f64::from(STEPS) * (CHAINS * 2 * 8) as f64 / elapsed.as_nanos() as f64
}

const LINE: usize = 64;

/// A line of memory: the number of another.
#[repr(align(64))]
#[derive(Clone, Copy)]
struct Line {
    next: u64,
    _rest: [u64; 7],
}

/// Lines of which each tells the next, all in one cycle without order (Sattolo's shuffle).
fn cycle(len: usize) -> Vec<Line> {
    let mut lines: Vec<Line> = (0..len as u64).map(|next| Line { next, _rest: [0; 7] }).collect();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    for i in (1..len).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let other = ((u128::from(state) * i as u128) >> 64) as usize;
        let (a, b) = (lines[i].next, lines[other].next);
        (lines[i].next, lines[other].next) = (b, a);
    }
    lines
}

/// Steps along the cycle a nanosecond.
fn steps(lines: &[Line], at: &mut u64) -> f64 {
    const STEPS: u32 = 2_000;
    let start = Instant::now();
    for _ in 0..STEPS {
        *at = lines[*at as usize].next;
    }
    let elapsed = start.elapsed();
    black_box(at);
    f64::from(STEPS) / elapsed.as_nanos() as f64
}

/// Billions of bytes a second, read from first to last so many times.
fn rate(lines: &[Line], times: usize) -> f64 {
    let start = Instant::now();
    for _ in 0..times {
        // SAFETY: the machine has AVX2, as `main` asked.
        unsafe { all(black_box(lines)) };
    }
    (size_of_val(lines) * times) as f64 / start.elapsed().as_nanos() as f64
}

#[target_feature(enable = "avx2")]
fn all(lines: &[Line]) {
    let mut sums: [__m256i; 8] = [_mm256_setzero_si256(); 8];
    for lines in lines.chunks_exact(4) {
        for (i, sum) in sums.iter_mut().enumerate() {
            let at = lines.as_ptr().cast::<__m256i>().wrapping_add(i);
            // SAFETY: four lines are eight of these.
            *sum = _mm256_or_si256(*sum, unsafe { _mm256_loadu_si256(at) });
        }
    }
    black_box(sums);
}

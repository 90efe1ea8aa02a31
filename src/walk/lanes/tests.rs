//! Each operation of each instruction set against one number at a time, on values that go wrong first.
use super::{Isa, Lanes, Two, Work};
use crate::geom::vec::{least, most};
use crate::num::count;
use proptest::prelude::any;
use std::vec::Vec;

/// What has special rules, on both sides of each rule.
const HOSTILE: [f32; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1.000_000_1,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    -f32::NAN,
    f32::MIN_POSITIVE,
    -1e-45,
    1e-40,
    f32::MAX,
    f32::MIN,
    3e-39,
    -7.5,
];

/// All results of a row of numbers and another, as bits.
#[derive(Debug, PartialEq)]
struct Results {
    /// Of these a NaN is a NaN: its bits are not stated by IEEE 754.
    sums: [Vec<u32>; 4],
    /// Of these every bit counts.
    chosen: [Vec<u32>; 9],
    masks: [u32; 2],
}

/// The operations on `N` lanes of type `L`.
fn lanes<const N: usize, L: Lanes<N>>(a: &[f32; N], b: &[f32; N]) -> Results {
    let bits = |all: L| all.store().map(f32::to_bits).to_vec();
    let number = |all: L| all.store().map(|x| if x.is_nan() { u32::MAX } else { x.to_bits() }).to_vec();
    let (x, y) = (L::load(a), L::load(b));
    L::prefetch(a);
    let exchanged = x.exchanged(y, x.negative());
    Results {
        sums: [number(x + y), number(x - y), number(x * y), number(x / y)],
        chosen: [
            bits(x),
            bits(L::splat(a[0])),
            bits(x.abs()),
            bits(x.abs().signed_as(y)),
            bits(x.least(y)),
            bits(x.most(y)),
            bits(x.negative()),
            bits(exchanged.0),
            bits(exchanged.1),
        ],
        masks: [x.lt(y), x.le(y)],
    }
}

/// The same, number by number.
fn numbers<const N: usize>(a: &[f32; N], b: &[f32; N]) -> Results {
    let each = |f: &dyn Fn(f32, f32) -> f32| a.iter().zip(b).map(|(&a, &b)| f(a, b).to_bits()).collect::<Vec<_>>();
    let number = |f: &dyn Fn(f32, f32) -> f32| {
        each(&|a, b| Some(f(a, b)).filter(|x| !x.is_nan()).unwrap_or(f32::from_bits(u32::MAX)))
    };
    let mask =
        |f: &dyn Fn(f32, f32) -> bool| (0u32..).zip(a.iter().zip(b)).map(|(i, (&a, &b))| u32::from(f(a, b)) << i).sum();
    Results {
        sums: [number(&|a, b| a + b), number(&|a, b| a - b), number(&|a, b| a * b), number(&|a, b| a / b)],
        chosen: [
            each(&|a, _| a),
            each(&|_, _| a[0]),
            each(&|a, _| a.abs()),
            each(&|a, b| a.abs().copysign(b)),
            each(&least),
            each(&most),
            each(&|a, _| f32::from_bits(if a.is_sign_negative() { u32::MAX } else { 0 })),
            each(&|a, b| if a.is_sign_negative() { b } else { a }),
            each(&|a, b| if a.is_sign_negative() { a } else { b }),
        ],
        masks: [mask(&|a, b| a < b), mask(&|a, b| a <= b)],
    }
}

/// Rows against each other, with eight lanes and with the first four.
struct All<'r>(&'r [([f32; 8], [f32; 8])]);

impl Work for All<'_> {
    type Output = Vec<[Results; 2]>;

    #[inline(always)]
    fn run<L8: Lanes<8>, L4: Lanes<4>>(self) -> Self::Output {
        for (a, b) in self.0 {
            quick::<8, L8>(a, b);
            quick::<4, L4>(&four(a), &four(b));
        }
        self.0.iter().map(|(a, b)| [lanes::<8, L8>(a, b), lanes::<4, L4>(&four(a), &four(b))]).collect()
    }
}

fn four(&[a, b, c, d, ..]: &[f32; 8]) -> [f32; 4] {
    [a, b, c, d]
}

/// What is promised of the quick operations on each pair; nothing of NaN.
fn quick<const N: usize, L: Lanes<N>>(a: &[f32; N], b: &[f32; N]) {
    let (x, y) = (L::load(a), L::load(b));
    let (greater, lesser, le) = (x.quick_most(y).store(), x.quick_least(y).store(), x.quick_le(y));
    for (lane, (&a, &b)) in a.iter().zip(b).enumerate().filter(|(_, (a, b))| !a.is_nan() && !b.is_nan()) {
        let (a_minus, b_minus) = (a.is_sign_negative(), b.is_sign_negative());
        if a_minus && b_minus {
            assert!(greater[lane].is_sign_negative(), "{a:e} {b:e}: {greater:?}");
        } else {
            assert_eq!(greater[lane], most(a, b), "{a:e} {b:e}");
        }
        if a_minus || b_minus {
            // Of zeros of two signs either may be taken for the lesser.
            assert!(lesser[lane].is_sign_negative() || lesser[lane] == 0.0 && a == b, "{a:e} {b:e}: {lesser:?}");
        } else {
            assert_eq!(lesser[lane].to_bits(), least(a, b).to_bits(), "{a:e} {b:e}");
        }
        let (says, surely, maybe) = (le >> lane & 1 == 1, a <= b && (a < b || !b_minus), a <= b);
        assert!(a_minus || says >= surely && says <= maybe, "{a:e} <= {b:e}");
    }
}

/// Work that counts its lanes, called from within.
struct Called;

impl Work for Called {
    type Output = (u32, u32);

    #[inline(always)]
    fn run<L8: Lanes<8>, L4: Lanes<4>>(self) -> Self::Output {
        (L8::splat(1.0).le(L8::splat(1.0)), L4::splat(1.0).le(L4::splat(1.0)))
    }
}

struct Calls;

impl Work for Calls {
    type Output = [(u32, u32); 2];

    #[inline(always)]
    fn run<L8: Lanes<8>, L4: Lanes<4>>(self) -> Self::Output {
        [L8::call(Called), L4::call(Called)]
    }
}

#[test]
fn work_calls_work() {
    for isa in Isa::all() {
        assert_eq!(isa.run(Calls), [(255, 15); 2], "{isa:?}");
    }
}

/// The columns of 16 rows as bits: with four lanes, with eight and with twice eight.
struct Columns<'r>(&'r [[f32; 8]; 16]);

impl Work for Columns<'_> {
    type Output = [Vec<Vec<u32>>; 3];

    #[inline(always)]
    fn run<L8: Lanes<8>, L4: Lanes<4>>(self) -> Self::Output {
        [columns::<4, L4>(self.0), columns::<8, L8>(self.0), columns::<16, Two<L8>>(self.0)]
    }
}

fn columns<const N: usize, L: Lanes<N>>(rows: &[[f32; 8]; 16]) -> Vec<Vec<u32>> {
    let all = L::columns(core::array::from_fn(|i| &rows[i]));
    all.iter().map(|column| column.store().map(f32::to_bits).to_vec()).collect()
}

#[test]
fn columns_of_rows() {
    // Every number differs, and every bit of it is kept, of a NaN, too.
    let number = |i: usize, k: usize| count(i << 8 | k) | 0x7f80_0000;
    let rows = core::array::from_fn(|i| core::array::from_fn(|k| f32::from_bits(number(i, k))));
    for isa in Isa::all() {
        for (lanes, columns) in [4, 8, 16].into_iter().zip(isa.run(Columns(&rows))) {
            let right = (0..8).map(|k| (0..lanes).map(|i| number(i, k)).collect::<Vec<_>>()).collect::<Vec<_>>();
            assert_eq!(columns, right, "{isa:?}, {lanes} lanes");
        }
    }
}

/// Panics unless every instruction set gives on these rows what single numbers give.
fn same(rows: &[([f32; 8], [f32; 8])]) {
    for isa in Isa::all() {
        for ((a, b), [eight, quad]) in rows.iter().zip(isa.run(All(rows))) {
            assert_eq!(eight, numbers(a, b), "{isa:?}: {a:?} {b:?}");
            assert_eq!(quad, numbers(&four(a), &four(b)), "{isa:?}: {a:?} {b:?}");
        }
    }
}

#[test]
fn hostile_values_in_every_lane() {
    // Each with each, and each pair in each lane.
    let row = |from: usize| core::array::from_fn(|lane| HOSTILE[(from + lane) % HOSTILE.len()]);
    let turns = 0..HOSTILE.len();
    same(&turns.clone().flat_map(|a| turns.clone().map(move |b| (row(a), row(b)))).collect::<Vec<_>>());
}

#[test]
fn the_scalar_level_is_everywhere_and_names_differ() {
    let names: Vec<_> = Isa::all().map(Isa::name).collect();
    assert_eq!(names[0], "scalar");
    assert!(names.iter().enumerate().all(|(i, name)| !name.is_empty() && !names[..i].contains(name)), "{names:?}");
    #[cfg(target_arch = "x86_64")]
    assert!(names.contains(&"sse2"), "{names:?}");
    #[cfg(target_arch = "aarch64")]
    assert!(names.contains(&"neon"), "{names:?}");
}

proptest::proptest! {
    #[test]
    fn any_bits(a in any::<[u32; 8]>(), b in any::<[u32; 8]>()) {
        same(&[(a.map(f32::from_bits), b.map(f32::from_bits))]);
    }
}

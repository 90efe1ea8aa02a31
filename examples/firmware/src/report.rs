//! The report: one `key=value` a line, scene after scene.
use crate::platform::{self, TICK, measure};
use crate::scenes::SCENES;
use core::hint::black_box;
use flashray::{BlobError, Scene};
use flashray_firmware::probe::{self, RAYS, Set, Watch};

/// So many starts are counted together, since one is shorter than a tick of the clock.
const STARTS: u32 = 64;

/// What the two sets of rays took.
#[derive(Default)]
struct Cost {
    camera: u32,
    chords: u32,
    stack: u32,
}

impl Watch for Cost {
    fn around(&mut self, set: Set, work: impl FnOnce()) {
        let (ticks, stack) = measure(work);
        match set {
            Set::Camera => self.camera = self.camera.saturating_add(ticks),
            Set::Chords => self.chords = self.chords.saturating_add(ticks),
        }
        self.stack = self.stack.max(stack);
    }
}

/// Checks every blob, traces the rays and prints everything.
///
/// # Errors
/// The first rule that a blob breaks; it is printed too.
pub fn run() -> Result<(), BlobError> {
    platform::start_clock();
    black_box(&SCENES).iter().try_for_each(|bytes| scene(bytes))
}

fn scene(bytes: &[u8]) -> Result<(), BlobError> {
    number("blob_bytes", bytes.len() as u32);
    let mut checked = Scene::trust(bytes);
    let (check_ticks, check_stack) = measure(|| checked = Scene::from_bytes(bytes));
    let scene = match checked {
        Ok(scene) => scene,
        Err(error) => {
            number("check", u32::from(error.rule.number()));
            return Err(error);
        }
    };
    text("check", "ok");
    text("structure", scene.kind().name());
    number("primitives", scene.len());
    let mut cost = Cost::default();
    let answer = probe::run(black_box(&scene), &mut cost);
    hex("crc", answer.crc);
    number("hits", answer.hits);
    number("camera_instructions_per_ray", share(cost.camera, RAYS));
    number("chords_instructions_per_ray", share(cost.chords, RAYS));
    number("check_instructions", check_ticks.saturating_mul(TICK));
    number("start_instructions", share(starts(bytes), STARTS));
    number("check_stack_bytes", check_stack);
    number("query_stack_bytes", cost.stack);
    number("static_ram_bytes", platform::static_ram());
    number("flash_bytes", platform::flash(&SCENES));
    Ok(())
}

/// Ticks of [`STARTS`] loads without the check.
fn starts(bytes: &[u8]) -> u32 {
    let work = || {
        for _ in 0..STARTS {
            let _ = black_box(Scene::trust(black_box(bytes)));
        }
    };
    measure(work).0
}

/// Ticks as instructions of each of `n`, a power of two.
fn share(ticks: u32, n: u32) -> u32 {
    ((u64::from(ticks) * u64::from(TICK)) >> n.trailing_zeros()) as u32
}

fn text(key: &str, value: &str) {
    for part in [key, "=", value, "\n"] {
        part.bytes().for_each(platform::write);
    }
}

fn number(key: &str, mut value: u32) {
    let mut digits = [b'0'; 10];
    for digit in digits.iter_mut().rev() {
        *digit |= (value % 10) as u8;
        value /= 10;
    }
    let zeros = digits.iter().take(digits.len() - 1).take_while(|&&d| d == b'0').count();
    line(key, "", digits.iter().skip(zeros));
}

fn hex(key: &str, value: u32) {
    let digit = |shift: u32| match value.wrapping_shr(shift) as u8 & 15 {
        d @ 0..=9 => b'0' | d,
        d => b'a'.wrapping_add(d).wrapping_sub(10),
    };
    line(key, "0x", [28, 24, 20, 16, 12, 8, 4, 0].map(digit).iter());
}

fn line<'a>(key: &str, prefix: &str, digits: impl Iterator<Item = &'a u8>) {
    for part in [key, "=", prefix] {
        part.bytes().for_each(platform::write);
    }
    digits.for_each(|&d| platform::write(d));
    platform::write(b'\n');
}

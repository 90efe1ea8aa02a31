//! Numbers that look random and are the same everywhere.

/// `xorshift64*` (Vigna, ACM TOMS 42(4), 2016).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn next(&mut self) -> u32 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 32) as u32
    }

    /// From 0 to below 1.
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 8) as f32 / 16_777_216.0
    }

    /// From -1 to below 1.
    pub fn signed(&mut self) -> f32 {
        self.unit() * 2.0 - 1.0
    }

    pub fn below(&mut self, n: usize) -> usize {
        self.next() as usize % n.max(1)
    }

    /// A point of a box.
    pub fn point(&mut self, middle: [f32; 3], half: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|k| middle[k] + half[k] * self.signed())
    }

    /// One of two.
    pub fn either<T>(&mut self, a: T, b: T) -> T {
        if self.below(2) == 0 { a } else { b }
    }
}

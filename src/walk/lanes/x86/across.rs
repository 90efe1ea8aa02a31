//! What goes from lane to lane: columns of rows, a choice by bits, and extremes. Macros, since the two kinds of four lanes
//! have it alike; the module above states why their intrinsics are sound.

/// Four columns of four rows, or of four rows and of four more.
macro_rules! turned {
    ($low:ident, $high:ident, $shuffle:ident, [$a:expr, $b:expr, $c:expr, $d:expr]) => {{
        let (low, high, more_low, more_high) = ($low($a, $b), $high($a, $b), $low($c, $d), $high($c, $d));
        [
            Self($shuffle::<0b01_00_01_00>(low, more_low)),
            Self($shuffle::<0b11_10_11_10>(low, more_low)),
            Self($shuffle::<0b01_00_01_00>(high, more_high)),
            Self($shuffle::<0b11_10_11_10>(high, more_high)),
        ]
    }};
}

/// The choice of four lanes by bits, and their extremes, and columns.
macro_rules! across {
    () => {
        #[inline(always)]
        fn columns(rows: [&[f32; 8]; 4]) -> [Self; 8] {
            // SAFETY: as for `load`; half of a row at a time.
            unsafe {
                let at = |i: usize, half: usize| _mm_loadu_ps(rows[i].as_ptr().add(half));
                let [a, b, c, d] =
                    turned!(_mm_unpacklo_ps, _mm_unpackhi_ps, _mm_shuffle_ps, [at(0, 0), at(1, 0), at(2, 0), at(3, 0)]);
                let [e, f, g, h] =
                    turned!(_mm_unpacklo_ps, _mm_unpackhi_ps, _mm_shuffle_ps, [at(0, 4), at(1, 4), at(2, 4), at(3, 4)]);
                [a, b, c, d, e, f, g, h]
            }
        }

        #[inline(always)]
        fn choose(lanes: u32, yes: Self, no: Self) -> Self {
            // SAFETY: as for `splat`.
            unsafe {
                let each = _mm_set_epi32(8, 4, 2, 1);
                let on = _mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32(lanes.cast_signed()), each), each);
                let on = _mm_castsi128_ps(on);
                Self(_mm_or_ps(_mm_and_ps(on, yes.0), _mm_andnot_ps(on, no.0)))
            }
        }

        #[inline(always)]
        fn greatest(self) -> f32 {
            // SAFETY: as for `splat`.
            unsafe {
                let two = _mm_max_ps(self.0, _mm_movehl_ps(self.0, self.0));
                _mm_cvtss_f32(_mm_max_ps(two, _mm_shuffle_ps::<1>(two, two)))
            }
        }

        #[inline(always)]
        fn smallest(self) -> f32 {
            // SAFETY: as for `splat`.
            unsafe {
                let two = _mm_min_ps(self.0, _mm_movehl_ps(self.0, self.0));
                _mm_cvtss_f32(_mm_min_ps(two, _mm_shuffle_ps::<1>(two, two)))
            }
        }
    };
}

/// The same of eight.
macro_rules! across256 {
    () => {
        #[inline(always)]
        fn columns(rows: [&[f32; 8]; 8]) -> [Self; 8] {
            // SAFETY: as for `load`; half of a row at a time.
            unsafe {
                let half = |i: usize, half: usize| _mm_loadu_ps(rows[i].as_ptr().add(half));
                let at = |i: usize, at: usize| {
                    _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(half(i, at)), half(i + 4, at))
                };
                let [a, b, c, d] = turned!(
                    _mm256_unpacklo_ps,
                    _mm256_unpackhi_ps,
                    _mm256_shuffle_ps,
                    [at(0, 0), at(1, 0), at(2, 0), at(3, 0)]
                );
                let [e, f, g, h] = turned!(
                    _mm256_unpacklo_ps,
                    _mm256_unpackhi_ps,
                    _mm256_shuffle_ps,
                    [at(0, 4), at(1, 4), at(2, 4), at(3, 4)]
                );
                [a, b, c, d, e, f, g, h]
            }
        }

        #[inline(always)]
        fn choose(lanes: u32, yes: Self, no: Self) -> Self {
            // SAFETY: as for `splat`.
            unsafe {
                let each = _mm256_set_epi32(128, 64, 32, 16, 8, 4, 2, 1);
                let on = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(lanes.cast_signed()), each), each);
                Self(_mm256_blendv_ps(no.0, yes.0, _mm256_castsi256_ps(on)))
            }
        }

        #[inline(always)]
        fn greatest(self) -> f32 {
            // SAFETY: as for `splat`.
            let four = unsafe { _mm_max_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0)) };
            Avx4(four).greatest()
        }

        #[inline(always)]
        fn smallest(self) -> f32 {
            // SAFETY: as for `splat`.
            let four = unsafe { _mm_min_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0)) };
            Avx4(four).smallest()
        }
    };
}

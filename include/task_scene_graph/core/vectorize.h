// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Marks a function whose loops are compiled twice, for the baseline and for AVX2, and chosen when
/// the library is loaded. Both give the same bits: "avx2" alone allows no fused multiply-add.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TSG_VECTORIZE __attribute__((target_clones("avx2", "default")))
#else
#define TSG_VECTORIZE
#endif

#pragma once

// Before a function that computes much for each pixel: compiled for wide vectors, too, and the one that fits the
// processor is taken when the program starts.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define RAYTRACE_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define RAYTRACE_WIDE
#endif

#pragma once

// Before a function: wider vectors where the processor has them. The operations are the same and nothing is fused, so
// are the bits. The choice is made by the loader, before a sanitizer's run-time library is ready.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define VPS_WIDE_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define VPS_WIDE_CLONES
#endif

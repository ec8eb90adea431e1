// Sixteen lanes; compiled for x86-64-v4 and called only on processors that have it.

#if defined(__AVX512F__) && defined(__AVX512DQ__)
#if !defined(__clang__)  // GCC 12 warns of the deliberately undefined values inside its own header (GCC bug 105593)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif
#include <immintrin.h>

#include "vps/surface/patch_block.hpp"
#include "vps/walk/walk_kernel.hpp"

namespace vps {
namespace {

constexpr int kLanes = 16;
typedef float F __attribute__((vector_size(64)));
typedef std::int32_t I __attribute__((vector_size(64)));
typedef std::uint32_t U __attribute__((vector_size(64)));

// Into zeros: the plain form waits for what the register held before.
inline U Gather(const std::uint32_t* base, U index) {
  return (U)_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), 0xffff, (__m512i)index, base, 4);
}
inline F Sqrt(F v) {
  return _mm512_sqrt_ps(v);
}
inline unsigned Bits(I mask) {
  return _mm512_movepi32_mask((__m512i)mask);
}
inline unsigned LessBits(F a, F b) {
  return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}
inline F Fma(F a, F b, F c) {
  return _mm512_fmadd_ps(a, b, c);
}
// In a register first: with a mask the store itself takes many times as long.
inline void Compress(std::uint32_t* to, U v, unsigned mask) {
  _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(static_cast<__mmask16>(mask), (__m512i)v));
}

#include "vps/walk/walk_lanes.hpp"

}  // namespace

WalkKernels Avx512WalkKernels() {
  return {Cull, Evaluate, Bound, MeasureFacets, ReadPatches, JudgePatches};
}

}  // namespace vps
#endif

// Sixteen lanes; compiled for x86-64-v4 and called only on processors that have it.

#if defined(__AVX512F__) && defined(__AVX512DQ__)
// GCC 12 warns of the deliberately undefined values inside its own header (GCC bug 105593).
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>

#include "vps/walk/walk_kernel.hpp"

namespace vps {
namespace {

constexpr int kLanes = 16;
typedef float F __attribute__((vector_size(64)));
typedef std::int32_t I __attribute__((vector_size(64)));
typedef std::uint32_t U __attribute__((vector_size(64)));

inline U Gather(const std::uint32_t* base, U index) {
  return (U)_mm512_i32gather_epi32((__m512i)index, reinterpret_cast<const int*>(base), 4);
}
inline F Sqrt(F v) {
  return _mm512_sqrt_ps(v);
}
inline unsigned Bits(I mask) {
  return _mm512_movepi32_mask((__m512i)mask);
}

#include "vps/walk/walk_lanes.hpp"

}  // namespace

void WalkAvx512(const WalkInput& input, const WalkScratch& scratch, WalkOutput* output) {
  Walk(input, scratch, output);
}

}  // namespace vps
#endif

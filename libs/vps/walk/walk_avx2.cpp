// Eight lanes; compiled for x86-64-v3 and called only on processors that have it.

#if defined(__AVX2__)
#include <immintrin.h>

#include "vps/surface/patch_block.hpp"
#include "vps/walk/walk_kernel.hpp"

namespace vps {
namespace {

constexpr int kLanes = 8;
typedef float F __attribute__((vector_size(32)));
typedef std::int32_t I __attribute__((vector_size(32)));
typedef std::uint32_t U __attribute__((vector_size(32)));

// Into zeros: the plain form waits for what the register held before.
inline U Gather(const std::uint32_t* base, U index) {
  return (U)_mm256_mask_i32gather_epi32(_mm256_setzero_si256(), reinterpret_cast<const int*>(base), (__m256i)index,
                                        _mm256_set1_epi32(-1), 4);
}
inline F Sqrt(F v) {
  return _mm256_sqrt_ps(v);
}
inline unsigned Bits(I mask) {
  return static_cast<unsigned>(_mm256_movemask_ps((__m256)mask));
}
inline unsigned LessBits(F a, F b) {
  return Bits(a < b);
}
inline F Fma(F a, F b, F c) {
  return _mm256_fmadd_ps(a, b, c);
}
// For each mask the numbers of its lanes, one after the other, four bits each.
struct Orders {
  std::uint32_t of[256];
};
constexpr Orders MakeOrders() {
  Orders orders{};
  for (std::uint32_t mask = 0; mask < 256; ++mask) {
    std::uint32_t count = 0;
    for (std::uint32_t k = 0; k < 8; ++k) {
      if ((mask >> k & 1U) != 0) orders.of[mask] |= k << 4 * count++;
    }
  }
  return orders;
}
constexpr Orders kOrders = MakeOrders();
inline void Compress(std::uint32_t* to, U v, unsigned mask) {
  const __m256i order = _mm256_srlv_epi32(_mm256_set1_epi32(static_cast<int>(kOrders.of[mask])),
                                          _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_permutevar8x32_epi32((__m256i)v, order));
}

#include "vps/walk/walk_lanes.hpp"

}  // namespace

WalkKernels Avx2WalkKernels() {
  return {Cull, Evaluate, Bound, MeasureFacets, ReadPatches, JudgePatches};
}

}  // namespace vps
#endif

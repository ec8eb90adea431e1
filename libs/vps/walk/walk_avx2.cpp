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

inline unsigned EqualBits(U a, U b) {
  return Bits((I)(a == b));
}
inline unsigned LessBits(F a, F b) {
  return Bits(a < b);
}
inline F Fma(F a, F b, F c) {
  return _mm256_fmadd_ps(a, b, c);
}
typedef __m256i Octet;
inline Octet LoadOctet(const std::uint32_t* corner, std::size_t stride_y, std::size_t stride_z) {
  // _mm_load_sd would ask for the alignment of a double.
  const __m128d low = _mm_castsi128_pd(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(corner)));
  const __m128d high = _mm_castsi128_pd(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(corner + stride_z)));
  const __m128d a = _mm_loadh_pd(low, reinterpret_cast<const double*>(corner + stride_y));
  const __m128d b = _mm_loadh_pd(high, reinterpret_cast<const double*>(corner + stride_z + stride_y));
  const __m256i all = _mm256_castpd_si256(_mm256_insertf128_pd(_mm256_castpd128_pd256(a), b, 1));
  return _mm256_sub_epi32(all, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(kTaken)));
}
inline U LookUp(const Octet& octet, U index) {
  return (U)_mm256_permutevar8x32_epi32(octet, (__m256i)index);
}
struct Place {
  __m256i low, high;
};
inline Place LoadPlace(const std::uint32_t* sixteen) {
  return {_mm256_loadu_si256(reinterpret_cast<const __m256i*>(sixteen)),
          _mm256_loadu_si256(reinterpret_cast<const __m256i*>(sixteen + 8))};
}
// The look-up uses the last three bits; the fourth, moved to the sign, chooses the half.
inline U PlaceOf(const Place& place, U coordinate) {
  const __m256i index = (__m256i)coordinate;
  return (U)_mm256_castps_si256(_mm256_blendv_ps(_mm256_castsi256_ps(_mm256_permutevar8x32_epi32(place.low, index)),
                                                 _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(place.high, index)),
                                                 _mm256_castsi256_ps(_mm256_slli_epi32(index, 28))));
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
  return {Cull, Evaluate, BoundSpheres, MeasureFacets, ReadPatches, JudgePatches};
}

}  // namespace vps
#endif

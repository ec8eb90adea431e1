// Eight lanes; compiled for x86-64-v3 and called only on processors that have it.

#if defined(__AVX2__)
#include <immintrin.h>

#include "vps/walk/walk_kernel.hpp"

namespace vps {
namespace {

constexpr int kLanes = 8;
typedef float F __attribute__((vector_size(32)));
typedef std::int32_t I __attribute__((vector_size(32)));
typedef std::uint32_t U __attribute__((vector_size(32)));

inline U Gather(const std::uint32_t* base, U index) {
  return (U)_mm256_i32gather_epi32(reinterpret_cast<const int*>(base), (__m256i)index, 4);
}
inline F Sqrt(F v) {
  return _mm256_sqrt_ps(v);
}
inline unsigned Bits(I mask) {
  return static_cast<unsigned>(_mm256_movemask_ps((__m256)mask));
}

#include "vps/walk/walk_lanes.hpp"

}  // namespace

void WalkAvx2(const WalkInput& input, const WalkScratch& scratch, WalkOutput* output) {
  Walk(input, scratch, output);
}

}  // namespace vps
#endif

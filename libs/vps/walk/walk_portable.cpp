// Four lanes by GCC's vectors: SSE4.2 on x86-64, whatever else elsewhere.

#if defined(__SSE4_1__)
#include <smmintrin.h>
#endif

#include "vps/surface/patch_block.hpp"
#include "vps/walk/walk_kernel.hpp"

namespace vps {
namespace {

constexpr int kLanes = 4;
typedef float F __attribute__((vector_size(16)));
typedef std::int32_t I __attribute__((vector_size(16)));
typedef std::uint32_t U __attribute__((vector_size(16)));

inline U Gather(const std::uint32_t* base, U index) {
  return U{base[index[0]], base[index[1]], base[index[2]], base[index[3]]};
}
#if defined(__SSE4_1__)
inline F Sqrt(F v) {
  return _mm_sqrt_ps(v);
}
inline unsigned Bits(I mask) {
  return static_cast<unsigned>(_mm_movemask_ps((__m128)mask));
}
#else
inline F Sqrt(F v) {
  return F{__builtin_sqrtf(v[0]), __builtin_sqrtf(v[1]), __builtin_sqrtf(v[2]), __builtin_sqrtf(v[3])};
}
inline unsigned Bits(I m) {
  return (m[0] & 1U) | (m[1] & 2U) | (m[2] & 4U) | (m[3] & 8U);
}
#endif
inline unsigned LessBits(F a, F b) {
  return Bits(a < b);
}
// Rounded once, as on processors that have the instruction, but for one case in 2^29: doubles hold the product exactly.
// Otherwise a point that barely touches would have another depth here.
inline F Fma(F a, F b, F c) {
  typedef double D __attribute__((vector_size(32)));
  return __builtin_convertvector(
      __builtin_convertvector(a, D) * __builtin_convertvector(b, D) + __builtin_convertvector(c, D), F);
}
inline void Compress(std::uint32_t* to, U v, unsigned mask) {
  for (; mask != 0; mask &= mask - 1) *to++ = v[__builtin_ctz(mask)];
}

#include "vps/walk/walk_lanes.hpp"

}  // namespace

WalkKernels PortableWalkKernels() {
  return {Cull, Evaluate, Bound, MeasureFacets, ReadPatches, JudgePatches};
}

}  // namespace vps

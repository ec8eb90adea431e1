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

inline unsigned EqualBits(U a, U b) {
  return Bits((I)(a == b));
}
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
struct Octet {
  std::uint32_t of[8];
};
inline Octet LoadOctet(const std::uint32_t* corner, std::size_t stride_y, std::size_t stride_z) {
  Octet octet;
  for (std::size_t k = 0; k < 8; ++k) {
    octet.of[k] = corner[(k & 1) + (k >> 1 & 1) * stride_y + (k >> 2) * stride_z] - kTaken[k];
  }
  return octet;
}
inline U LookUp(const Octet& octet, U index) {
  return U{octet.of[index[0]], octet.of[index[1]], octet.of[index[2]], octet.of[index[3]]};
}
struct Place {
  const std::uint32_t* of;
};
inline Place LoadPlace(const std::uint32_t* sixteen) {
  return {sixteen};
}
inline U PlaceOf(const Place& place, U coordinate) {
  const U k = coordinate & 15U;
  return U{place.of[k[0]], place.of[k[1]], place.of[k[2]], place.of[k[3]]};
}
inline void Compress(std::uint32_t* to, U v, unsigned mask) {
  for (; mask != 0; mask &= mask - 1) *to++ = v[__builtin_ctz(mask)];
}

#include "vps/walk/walk_lanes.hpp"

}  // namespace

WalkKernels PortableWalkKernels() {
  return {Cull, Evaluate, BoundSpheres, MeasureFacets, ReadPatches, JudgePatches};
}

}  // namespace vps

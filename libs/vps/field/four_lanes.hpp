#pragma once

#include <cstring>

namespace vps {

// Four lanes, where the compiler makes no vectors of a loop by itself.
typedef float F4 __attribute__((vector_size(16)));

inline F4 Load4(const float* p) {
  F4 v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
inline void Store4(F4 v, float* p) {
  std::memcpy(p, &v, sizeof v);
}
inline F4 Max4(F4 a, F4 b) {
  return a > b ? a : b;
}

}  // namespace vps

#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <type_traits>

// For constants_sensitivity.py alone, which has the engine's constants read by this in a copy of the tree.
namespace vps {

// 1, unless the environment names the constant.
inline double StudiedFactor(const char* name) {
  const char* const studied = std::getenv("VR_OOS_CONSTANT");
  const char* const factor = std::getenv("VR_OOS_FACTOR");
  const bool is_it = studied != nullptr && factor != nullptr && std::strcmp(studied, name) == 0;
  return is_it ? std::atof(factor) : 1.0;
}

template <class T>
T Studied(std::type_identity_t<T> value, const char* name) {
  const double scaled = StudiedFactor(name) * static_cast<double>(value);
  if constexpr (std::is_integral_v<T>) return std::max<T>(1, static_cast<T>(std::lrint(scaled)));
  return static_cast<T>(scaled);
}

// The angle is scaled.
template <class T>
T StudiedCosine(std::type_identity_t<T> value, const char* name) {
  const double factor = StudiedFactor(name);
  return factor == 1.0 ? value : static_cast<T>(std::cos(factor * std::acos(static_cast<double>(value))));
}

}  // namespace vps

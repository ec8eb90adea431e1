#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>

#include "bus/wire/wire.hpp"
#include "core/messages/fields.hpp"
#include "core/pose.hpp"
#include "core/wrench.hpp"

// Conversions of a field's value between memory and wire.
namespace bus::detail {

using core::Wire;

// --- Compounds: packed arrays of a fixed number of doubles or floats.

using PoseNumbers = std::array<double, 7>;
using SixNumbers = std::array<double, 6>;

inline PoseNumbers NumbersOf(const core::Pose& X) {
  return {X.rotation.w, X.rotation.x, X.rotation.y, X.rotation.z, X.translation.x, X.translation.y, X.translation.z};
}
inline SixNumbers NumbersOf(const core::Twist& V) {
  const glm::dvec3 &w = V.angular_rad_per_s, &v = V.linear_m_per_s;
  return {w.x, w.y, w.z, v.x, v.y, v.z};
}
inline SixNumbers NumbersOf(const core::Wrench& F) {
  const glm::dvec3 &f = F.force_N, &t = F.torque_Nm;
  return {f.x, f.y, f.z, t.x, t.y, t.z};
}
inline std::array<float, 3> NumbersOf(const glm::vec3& v) {
  return {v.x, v.y, v.z};
}
inline std::array<double, 3> NumbersOf(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

inline void Assign(const PoseNumbers& in, core::Pose* X) {
  *X = {glm::dquat(in[0], in[1], in[2], in[3]), glm::dvec3(in[4], in[5], in[6])};
}
inline void Assign(const SixNumbers& in, core::Twist* V) {
  *V = {glm::dvec3(in[0], in[1], in[2]), glm::dvec3(in[3], in[4], in[5])};
}
inline void Assign(const SixNumbers& in, core::Wrench* F) {
  *F = {glm::dvec3(in[0], in[1], in[2]), glm::dvec3(in[3], in[4], in[5])};
}
inline void Assign(const std::array<float, 3>& in, glm::vec3* v) {
  *v = {in[0], in[1], in[2]};
}
inline void Assign(const std::array<double, 3>& in, glm::dvec3* v) {
  *v = {in[0], in[1], in[2]};
}

template <class T>
concept IsCompound = requires(const T& value) {
  NumbersOf(value);
};
template <class T>
concept IsNumber = std::is_arithmetic_v<T> || std::is_enum_v<T>;
template <IsCompound T>
using Numbers = decltype(NumbersOf(std::declval<const T&>()));

// --- Numbers: as the 64 bits that a WireReader finds.

constexpr bool IsVarint(Wire wire) {
  return wire <= Wire::kSint64;
}
constexpr std::size_t FixedBytes(Wire wire) {
  return wire == Wire::kFixed32 || wire == Wire::kFloat ? 4 : 8;
}
constexpr WireType TypeOf(Wire wire) {
  if (wire == Wire::kString || wire == Wire::kMessage || wire == Wire::kBytes) return kBytes;
  if (IsVarint(wire)) return kVarint;
  return FixedBytes(wire) == 4 ? kFixed32 : kFixed64;
}

template <Wire wire, IsNumber T>
std::uint64_t ToBits(T value) {
  if constexpr (wire == Wire::kDouble) {
    return std::bit_cast<std::uint64_t>(value);
  } else if constexpr (wire == Wire::kFloat) {
    return std::bit_cast<std::uint32_t>(value);
  } else if constexpr (wire == Wire::kSint32 || wire == Wire::kSint64) {  // zigzag
    const auto number = static_cast<std::int64_t>(value);
    return (static_cast<std::uint64_t>(number) << 1) ^ static_cast<std::uint64_t>(number >> 63);
  } else {
    return static_cast<std::uint64_t>(value);
  }
}

template <IsNumber T>
constexpr std::uint64_t MaxOf() {
  if constexpr (std::is_enum_v<T>) {
    return MaxOf<std::underlying_type_t<T>>();
  } else {
    return static_cast<std::uint64_t>(std::numeric_limits<T>::max());
  }
}

// Of a uint32 the low 32 bits count, as in protobuf's library; they must fit the type in memory.
template <Wire wire, IsNumber T>
bool IsInRange(std::uint64_t bits) {
  if constexpr (wire == Wire::kUint32 || wire == Wire::kFixed32) return static_cast<std::uint32_t>(bits) <= MaxOf<T>();
  return true;
}

template <Wire wire, IsNumber T>
T FromBits(std::uint64_t bits) {
  if constexpr (wire == Wire::kDouble) {
    return std::bit_cast<double>(bits);
  } else if constexpr (wire == Wire::kFloat) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
  } else if constexpr (wire == Wire::kBool) {
    return bits != 0;
  } else if constexpr (wire == Wire::kSint32) {
    const auto low = static_cast<std::uint32_t>(bits);
    return static_cast<T>((low >> 1) ^ (~(low & 1) + 1));
  } else if constexpr (wire == Wire::kSint64) {
    return static_cast<T>((bits >> 1) ^ (~(bits & 1) + 1));
  } else if constexpr (wire == Wire::kUint32 || wire == Wire::kFixed32) {
    return static_cast<T>(static_cast<std::uint32_t>(bits));
  } else {
    return static_cast<T>(bits);
  }
}

// Upper bound of the bytes of a value, without its tag.
template <Wire wire, class T>
constexpr std::size_t MaxValueBytes() {
  if constexpr (IsCompound<T>) {
    return sizeof(Numbers<T>);
  } else if constexpr (!IsVarint(wire)) {
    return FixedBytes(wire);
  } else if constexpr (wire == Wire::kSint32 || wire == Wire::kSint64) {
    return VarintBytes(wire == Wire::kSint32 ? 0xffff'ffff : ~std::uint64_t{0});
  } else {
    return VarintBytes(MaxOf<T>());
  }
}

// Calls take(bits) for each number of a field, which may be packed. False: damaged, or take returned false.
template <Wire wire, class Take>
bool ForEachNumber(const WireField& field, Take&& take) {
  if (field.type != kBytes) return take(field.value);
  std::span<const std::uint8_t> left = field.bytes;
  while (!left.empty()) {
    std::uint64_t bits = 0;
    if constexpr (IsVarint(wire)) {
      if (!TakeVarint(&left, &bits)) return false;
    } else {
      if (left.size() < FixedBytes(wire)) return false;
      std::memcpy(&bits, left.data(), FixedBytes(wire));
      left = left.subspan(FixedBytes(wire));
    }
    if (!take(bits)) return false;
  }
  return true;
}

}  // namespace bus::detail

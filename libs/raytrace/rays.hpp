#pragma once

#include <embree3/rtcore.h>
#include <pmmintrin.h>
#include <xmmintrin.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <limits>

#include "raytrace/world.hpp"

namespace raytrace {

constexpr int kSide = 4;  // of the square of pixels whose rays go together
constexpr int kLanes = kSide * kSide;
constexpr float kNever = std::numeric_limits<float>::infinity();

// Denormal numbers, which only waste time, count as zero while this exists.
class NoDenormals {
 public:
  NoDenormals() : old_(_mm_getcsr()) { _mm_setcsr(old_ | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON); }
  ~NoDenormals() { _mm_setcsr(old_); }
  NoDenormals(const NoDenormals&) = delete;
  NoDenormals& operator=(const NoDenormals&) = delete;

 private:
  unsigned old_;
};

// Sixteen rays.
struct Rays {
  RTCRayHit16 embree;
  alignas(64) std::array<int, kLanes> is_valid{};  // -1: yes, as Embree has it

  Rays() { is_valid.fill(0); }

  void Set(int lane, const glm::vec3& from, const glm::vec3& along, float near, float far, unsigned mask) {
    RTCRay16& ray = embree.ray;
    ray.org_x[lane] = from.x;
    ray.org_y[lane] = from.y;
    ray.org_z[lane] = from.z;
    ray.dir_x[lane] = along.x;
    ray.dir_y[lane] = along.y;
    ray.dir_z[lane] = along.z;
    ray.tnear[lane] = near;
    ray.tfar[lane] = far;
    ray.time[lane] = 0.0f;
    ray.mask[lane] = mask;
    ray.id[lane] = 0;
    ray.flags[lane] = 0;
    embree.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    embree.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    is_valid[static_cast<std::size_t>(lane)] = -1;
  }
  [[nodiscard]] bool IsSet(int lane) const { return is_valid[static_cast<std::size_t>(lane)] != 0; }
  [[nodiscard]] bool HasAny() const {
    return std::any_of(is_valid.begin(), is_valid.end(), [](int valid) { return valid != 0; });
  }
  [[nodiscard]] bool HasHit(int lane) const {
    return IsSet(lane) && embree.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
  }
  [[nodiscard]] bool HasAnyHit() const {
    for (int lane = 0; lane < kLanes; ++lane) {
      if (HasHit(lane)) return true;
    }
    return false;
  }
  // After Block.
  [[nodiscard]] bool IsFree(int lane) const { return IsSet(lane) && embree.ray.tfar[lane] >= 0.0f; }
  [[nodiscard]] glm::vec3 Along(int lane) const {
    return {embree.ray.dir_x[lane], embree.ray.dir_y[lane], embree.ray.dir_z[lane]};
  }
  [[nodiscard]] World::Place PlaceOf(int lane, float pixel_m) const {
    const RTCHit16& hit = embree.hit;
    return {hit.instID[0][lane], hit.geomID[lane], hit.primID[lane], hit.u[lane], hit.v[lane], Along(lane), pixel_m};
  }
  // Whether two rays have met the same part of the same thing.
  [[nodiscard]] bool HaveSameHit(int a, int b) const {
    const RTCHit16& hit = embree.hit;
    return HasHit(a) && HasHit(b) && hit.instID[0][a] == hit.instID[0][b] && hit.geomID[a] == hit.geomID[b];
  }

  void Meet(RTCScene tree, RTCIntersectContextFlags flags) {
    if (!FillLanes()) return;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = flags;
    rtcIntersect16(is_valid.data(), tree, &context, &embree);
  }
  // Of each ray whether something is in its way: its tfar is negative then. Not with the flag of coherent rays: with
  // instances and partly valid packets, Embree 3.13.5 does not return.
  void Block(RTCScene tree) {
    if (!FillLanes()) return;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded16(is_valid.data(), tree, &context, &embree.ray);
  }

 private:
  // Lanes without a ray get one that goes nowhere. False: all are such.
  bool FillLanes() {
    if (!HasAny()) return false;
    for (int lane = 0; lane < kLanes; ++lane) {
      if (IsSet(lane)) continue;
      Set(lane, glm::vec3(0.0f), glm::vec3(0, 0, 1), 0.0f, -1.0f, 0);
      is_valid[static_cast<std::size_t>(lane)] = 0;
    }
    return true;
  }
};

}  // namespace raytrace

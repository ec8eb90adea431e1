#pragma once

#include <array>

#include "core/fixed_vector.hpp"
#include "core/messages/haptic.hpp"
#include "core/pose.hpp"
#include "vps/coupling/contact_memory.hpp"

namespace vps {

// As many planes as the coupling takes, two thirds of them for places (not derived), the rest for their other faces.
constexpr std::size_t kMaxGapPlanes = kMaxToolPlanes;
constexpr std::size_t kMaxGapPlaces = 64;
constexpr std::size_t kMaxOtherFaces = kMaxGapPlanes - kMaxGapPlaces;

// The planes of a pair for a tool that rests on the surface: gaps of single places of S, exact, whether they touch or
// not, so that a plane is the same just before, at and just after touching. A slot holds a place of S while it matters.
// A place in a groove of G has a plane for either face: with one at a time the tool would go to and fro between them.
// An id is a slot and which of its two faces.
struct GapPlanes {
  // Cycles for which a place keeps its plane after others have become nearer: longer than a contact fades.
  static constexpr std::int8_t kStay = 8;
  struct Slot {
    std::uint32_t point = 0;
    std::int8_t cycles_left = -1;   // negative: free
    bool is_loaded = false;         // since the last cycle
    glm::dvec3 corner{0.0};         // of a corner of G: it, in G, voxels
    std::array<glm::dvec3, 2> n{};  // normals of its faces, in G; 0: none yet
  };
  core::FixedVector<core::ContactPlane, kMaxGapPlanes> planes;
  std::array<Slot, kMaxGapPlaces> slots;

  static std::uint32_t IdOf(std::size_t slot, std::size_t face) {
    return static_cast<std::uint32_t>(slot + face * kMaxGapPlaces);
  }
  // Its place is the first to have a plane in the next cycle.
  void Keep(std::uint32_t id) { slots[id % kMaxGapPlaces].is_loaded = true; }
  void Clear() {
    planes.clear();
    slots.fill({});
  }
};

}  // namespace vps

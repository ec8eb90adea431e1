#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "core/messages/haptic.hpp"
#include "core/pose.hpp"

namespace tactile {

// What a finger's pad touches. Places on the pad are (y, z) of the device's frame B: across and along the finger.
struct FingerContact {
  double depth_m = 0.0;
  double force_N = 0.0;
  glm::dvec2 place_m{0.0};         // middle of the pressure
  glm::dvec2 slip_m_per_s{0.0};    // of what it touches, over the skin
  glm::dvec2 travel_m_per_s{0.0};  // of the place, over the skin
};

// Adds up the contacts of one finger, step by step: slip and travel are differences of two steps.
class FingerSense {
 public:
  explicit FingerSense(std::size_t num_pairs) : before_(num_pairs) {}

  void Begin(std::int64_t now_ns, const core::Pose& X_WB);
  // Of pair number `pair`, whose set has the finger as S (`is_sampled`) or as G.
  void Add(std::size_t pair, const core::ContactSet& contacts, const core::Pose& X_WS, const core::Pose& X_WG,
           bool is_sampled);
  FingerContact End();

 private:
  struct Seen {
    std::int64_t time_ns = 0;  // 0: not in the step before
    core::Pose X_BO;           // of the other body
  };
  std::vector<Seen> before_;
  std::int64_t now_ns_ = 0, before_ns_ = 0;
  core::Pose X_BW_;
  FingerContact sum_;  // places and speeds times force
  std::optional<glm::dvec2> place_before_m_;
};

}  // namespace tactile

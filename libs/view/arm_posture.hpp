#pragma once

#include <array>
#include <glm/glm.hpp>

#include "core/pose.hpp"
#include "scene/scenario.hpp"

namespace view {

// Where the links of a shown arm stand so that its flange is at a given pose: in closed form, and of this pose alone,
// so that every viewer shows the same. Joints 1 to 3 are a shoulder, 4 an elbow, 5 to 7 a wrist, as of a light-weight
// robot.
class ArmPosture {
 public:
  static constexpr std::size_t kNumJoints = scene::ShownArm::kNumLinks;

  explicit ArmPosture(const scene::ShownArm& arm);

  struct Links {
    std::array<core::Pose, kNumJoints> X_WL;  // link frames
    core::Pose X_WF;                          // the flange
    bool is_reached = false;                  // false: too far, and the arm stretches towards it; or too near
  };
  [[nodiscard]] Links At(const core::Pose& X_WF) const;

 private:
  scene::ShownArm arm_;
  glm::dvec3 p_BShoulder_{0.0};
  double upper_m_ = 0.0;  // shoulder to elbow
  double fore_m_ = 0.0;   // elbow to wrist
  double wrist_m_ = 0.0;  // wrist to the frame of link 7
};

}  // namespace view

#include "hug/machine.hpp"

#include <algorithm>

namespace hug {

Machine::Machine(const MachineFigures& figures) : figures_(figures) {
  if (figures.has_bodies) {
    const auto upright = [&](double x_m, double from_m, double to_m, double radius_m) {
      bodies_.push_back(
          {figures_.X_WB * glm::dvec3(x_m, 0.0, from_m), figures_.X_WB * glm::dvec3(x_m, 0.0, to_m), radius_m});
    };
    upright(-0.30, -0.8, 0.8, 0.12);  // the column behind the arms
    upright(1.20, -0.9, 0.5, 0.20);   // the operator
  }
  for (const Side side : {Side::kRight, Side::kLeft}) {
    ArmFigures parked;
    parked.X_WB = X_WB(side);
    arms_[Index(side)].emplace(parked);
    arms_[Index(side)]->Sense();
  }
}

core::Pose Machine::X_WB(Side side) const {
  const double y_m = (side == Side::kRight ? -0.5 : 0.5) * figures_.between_arms_m;
  return figures_.X_WB * core::Pose{glm::dquat(1, 0, 0, 0), {0.0, y_m, 0.0}};
}

bool Machine::Open(Side side, ArmFigures figures, const core::Pose& X_WD_start) {
  figures.X_WB = X_WB(side);
  Arm& arm = arms_[Index(side)].emplace(figures);
  in_service_[Index(side)] = true;
  const bool reaches = arm.Start(X_WD_start);
  arm.Sense();
  return reaches;
}

void Machine::Sense() {
  for (std::size_t i = 0; i < 2; ++i) {
    if (in_service_[i]) arms_[i]->Sense();
  }
}

void Machine::Move() {
  Arm& right = *arms_[0];
  Arm& left = *arms_[1];
  const AvoidanceResult between = AvoidEachOther(figures_.avoidance, right.measured(), right.measured_speed(),
                                                 left.measured(), left.measured_speed());
  least_m_ = std::min(least_m_, between.least_m);
  for (std::size_t i = 0; i < 2; ++i) {
    if (!in_service_[i]) continue;
    Arm& arm = *arms_[i];
    const AvoidanceResult around = AvoidBodies(figures_.avoidance, arm.measured(), arm.measured_speed(), bodies_);
    arm.Move((i == 0 ? between.first : between.second) + around.first, std::min(between.least_m, around.least_m));
  }
}

void Machine::AdvanceTo(std::int64_t now_ns) {
  constexpr std::int64_t kStepsPerSecond = 3000, kSecond_ns = 1'000'000'000, kPause_ns = 100'000'000;
  if (!is_begun_) begin_ns_ = now_ns;
  is_begun_ = true;
  const std::int64_t there_ns = begin_ns_ + num_steps_ * kSecond_ns / kStepsPerSecond;
  if (now_ns - there_ns > kPause_ns) begin_ns_ += now_ns - there_ns - kPause_ns;
  const std::int64_t due = (now_ns - begin_ns_) * kStepsPerSecond / kSecond_ns;
  for (; num_steps_ < due; ++num_steps_) {
    Move();
    Sense();
  }
}

}  // namespace hug

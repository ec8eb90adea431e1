#include "physics/slider.hpp"

namespace physics {
namespace {

enum SliderRow : std::size_t { kSliderX, kSliderY, kTurnX, kTurnY, kTurnZ };

}  // namespace

Slider::Slider(const SliderParams& params) : Mechanism(kFirstAxisRow + JointAxis::kNumRows), params_(params) {
  AddTunable("damping", &params_.axis.damping);
  AddTunable("locked", &params_.axis.locked);
  AddTunable("motor_m_per_s", &params_.axis.motor_speed, true);
  AddTunable("motor_force_N", &params_.axis.motor_limit);
}

void Slider::Prepare(const BodyView& parent, const BodyView& child, double dt_s) {
  const core::Pose X_WJp = parent.X_WO * params_.X_PJ;
  const core::Pose X_WJc = child.X_WO * params_.X_CJ;
  const glm::dvec3 p_W = X_WJc.translation;
  const glm::dvec3 offset_W = X_WJc.translation - X_WJp.translation;
  const glm::dvec3 turn_W = core::RotationVector(X_WJc.rotation * glm::conjugate(X_WJp.rotation));
  const glm::dvec3 axes_W[3] = {X_WJp.rotate({1, 0, 0}), X_WJp.rotate({0, 1, 0}), X_WJp.rotate({0, 0, 1})};
  position_ = glm::dot(axes_W[2], offset_W);

  // The child's point must be on the guide at the end of the step. In the parent's rotating frame its acceleration is
  // the difference of the accelerations of both bodies at that point minus the Coriolis term 2 w x u, with w of the
  // parent and u the relative velocity. As for a hinge, v = -e / dt - dt e'' / 2 (SHAKE).
  const double rate = kErrorReduction / dt_s;
  const glm::dvec3& w_W = parent.V_WO.angular_rad_per_s;
  const glm::dvec3 v_child_W = core::PointVelocity(child.V_WO, p_W - child.X_WO.translation);
  const glm::dvec3 v_parent_W = core::PointVelocity(parent.V_WO, p_W - parent.X_WO.translation);
  const glm::dvec3 curvature_W = PointAcceleration(child, p_W - child.p_WCm) -
                                 PointAcceleration(parent, p_W - parent.p_WCm) -
                                 2.0 * glm::cross(w_W, v_child_W - v_parent_W);
  for (std::size_t i = 0; i < 2; ++i) {
    const double bias = -rate * glm::dot(axes_W[i], offset_W) - 0.5 * dt_s * glm::dot(axes_W[i], curvature_W);
    SetHard(&rows()[kSliderX + i], axes_W[i], glm::dvec3(0.0), p_W, bias);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const double bias =
        -rate * glm::dot(axes_W[i], turn_W) - 0.5 * dt_s * glm::dot(axes_W[i], child.alpha_W - parent.alpha_W);
    SetHard(&rows()[kTurnX + i], glm::dvec3(0.0), axes_W[i], p_W, bias);
  }
  axis_.Prepare(params_.axis, axis_rows(), axes_W[2], glm::dvec3(0.0), p_W, position_, dt_s);
}

void Slider::Finish(double dt_s) {
  force_ = JointAxis::Force(axis_rows(), dt_s);
}

void Slider::ExchangeState(Checkpoint* checkpoint) {
  Mechanism::ExchangeState(checkpoint);
  axis_.ExchangeState(checkpoint);
}

}  // namespace physics

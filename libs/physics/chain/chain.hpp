#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/pose.hpp"
#include "core/result.hpp"
#include "core/wrench.hpp"
#include "physics/chain/spatial.hpp"

namespace physics {

// A link L and its joint: L turns about z of J (or moves along it, when prismatic), J is fixed in the parent link, and
// L coincides with J at position 0.
struct ChainLink {
  int parent = -1;  // an earlier link; -1: the base
  bool is_prismatic = false;
  core::Pose X_PJ;
  MassProperties mass;       // in the axes of L, without the motor's rotor
  double rotor_kg_m2 = 0.0;  // inertia of the rotor at the joint's output (kg for a prismatic joint)
  double damping = 0.0;      // Nm s/rad or N s/m
  double lower = -1e9;       // rad or m; the joint stops there without rebound
  double upper = 1e9;
};

struct ChainState {
  core::Pose X_WB;   // base
  core::Twist V_WB;  // zero when the base is fixed
  std::vector<double> position;
  std::vector<double> speed;
};

struct ChainAcceleration {
  std::vector<double> joint;
  glm::dvec3 base_angular_W{0.0};
  glm::dvec3 base_linear_W{0.0};  // of the base's origin
};

// Serial chains and trees of links in reduced coordinates, so joints cannot drift apart. The base is fixed or free.
// Accelerations by the articulated-body algorithm [Featherstone 2008, ch. 7 and 9.4], about 1 us for seven joints.
// Allocates only in Create.
class Chain {
 public:
  // `base`: mass of a free base; none: the base is fixed. Error: kInvalidInput for a parent that is not an earlier
  // link, a physically impossible mass, limits that are not in order, and poses that are not finite.
  static core::Result<Chain> Create(std::vector<ChainLink> links, std::optional<MassProperties> base = std::nullopt);

  [[nodiscard]] std::size_t num_joints() const { return links_.size(); }
  [[nodiscard]] const ChainLink& link(std::size_t i) const { return links_[i]; }
  [[nodiscard]] bool is_free() const { return base_.has_value(); }
  [[nodiscard]] ChainState MakeState() const;  // at rest at position 0

  // Pose and velocity of a link's origin, for the state of the last call of a function below.
  [[nodiscard]] const core::Pose& X_WL(std::size_t i) const { return works_[i].X_WL; }
  [[nodiscard]] core::Twist V_WL(std::size_t i) const;

  void Place(const ChainState& state);
  // Computes the accelerations. `force`: of the motors, Nm or N per joint. `F_Lo_W`: wrench on each link about its
  // origin, in W; empty: none.
  void Accelerate(const ChainState& state, std::span<const double> force, std::span<const core::Wrench> F_Lo_W,
                  ChainAcceleration* acceleration);
  // One step of the classical fourth-order Runge-Kutta method with constant forces. Then joints beyond a limit are set
  // back to it and stopped by an impulse that acts on the whole chain.
  void Step(double dt_s, std::span<const double> force, std::span<const core::Wrench> F_Lo_W, ChainState* state);

  // Sums over a free base and all links; momentum is about the origin of W.
  [[nodiscard]] double KineticEnergy_J(const ChainState& state);
  [[nodiscard]] Force Momentum(const ChainState& state);
  // Column k: velocity of link i's origin in W, angular then linear, per unit speed of joint k. 6 x num_joints numbers.
  void Jacobian(std::size_t i, std::span<double> columns) const;

 private:
  struct Work {  // all spatial quantities in world axes about the origin of the base
    core::Pose X_WL;
    Motion S;
    Motion v;
    Motion c;
    SpatialInertia I;
    SpatialInertia IA;
    Force pA;
    Force U;
    double D = 0.0;
    double u = 0.0;
    Motion a;
  };

  Chain() = default;
  static SpatialInertia InertiaOf(const MassProperties& mass, const core::Pose& X_WL, const glm::dvec3& origin_W);
  void Move(const ChainState& from, const ChainState& rate_state, const ChainAcceleration& acceleration, double dt_s,
            ChainState* to) const;
  void StopAtLimits(ChainState* state);

  std::vector<ChainLink> links_;
  std::optional<MassProperties> base_;
  std::vector<Work> works_;
  glm::dvec3 origin_W_{0.0};
  Motion v_base_;
  SpatialInertia I_base_;

  // Of Step.
  ChainState stages_[3];
  ChainState mean_;
  ChainAcceleration accelerations_[4];
  std::vector<double> unit_;
};

}  // namespace physics

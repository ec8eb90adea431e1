#pragma once

#include <memory>
#include <vector>

#include "core/pose.hpp"
#include "core/result.hpp"
#include "core/wrench.hpp"
#include "physics/checkpoint.hpp"
#include "physics/cloth/cloth_grid.hpp"
#include "physics/cloth/cloth_shape.hpp"
#include "physics/mass_properties.hpp"
#include "physics/world.hpp"

namespace physics {

// Something that a cloth touches or hangs on. A dynamic body is moved by the cloth's impulses within a step, so that
// the two exchange no more than its inertia allows; who owns it takes the wrench and sets its state before the next.
struct ClothBodyParams {
  BodyKind kind = BodyKind::kFixed;
  core::Pose X_WO;
  MassProperties mass;                      // dynamic only
  std::shared_ptr<const ClothShape> shape;  // null: nodes pass through it
};

// Springs between points of the sheet and points of a body. Hook-and-loop when they can break.
struct ClothBondParams {
  int body = 0;
  double stiffness_N_per_m = 0.0;  // of each point
  double damping_N_s_per_m = 0.0;
  double release_force_N = 1e30;  // a point that pulls with more breaks for good
};

// A deformable sheet in zero gravity: nodes joined by springs that are implicit along their line, as a world's rows,
// and by explicit bending forces; contacts and bonds are rows of the same sequential-impulse solver. Every impulse acts
// along a line through the positions at the start of a substep, so linear and angular momentum are kept exactly however
// far the solver has converged (Sheet: x' = x + h v' and sum x cross impulse = 0 give x' cross m v' = x cross m v).
// Energy swings about a value that falls: springs lose a little, as implicit ones do, and bending as an explicit force
// of a symplectic step neither gains nor loses in the mean.
//
// Same inputs, same bits. Step does not allocate, lock or throw.
class Cloth {
 public:
  static core::Result<std::unique_ptr<Cloth>> Create(const ClothParams& params);

  // Setup. Points are where they are on the flat sheet at the start, in W; they are bonded to the body as they lie.
  core::Result<int> AddBody(const ClothBodyParams& params);
  // One bond of points (index for held()). Errors: no such body, a point off the sheet.
  core::Result<int> AddBond(const ClothBondParams& params, const std::vector<glm::dvec3>& points_W);

  // Between steps. A kinematic body moves to the pose given, evenly over the next step; a dynamic one starts there with
  // the velocity of its mesh-frame origin.
  void SetBody(int body, const core::Pose& X_WO, const core::Twist& V_WO = {});
  // Stops every node; bodies are placed anew by their next SetBody instead of being led there.
  void Rest();
  void SetReleaseForce(int bond, double release_force_N);
  // Holds every node inside a box of the body's mesh frame where it is now; returns how many. One grip per body;
  // CountInside tells how many there are. Gripped nodes do not touch kinematic bodies.
  [[nodiscard]] int CountInside(int body, const glm::dvec3& lower_O, const glm::dvec3& upper_O) const;
  int Grip(const ClothBondParams& params, const glm::dvec3& lower_O, const glm::dvec3& upper_O);
  void Release(int body);
  [[nodiscard]] int num_gripped(int body) const;

  void Step(double dt_s);

  [[nodiscard]] const std::vector<glm::dvec3>& positions_W() const { return x_W_; }
  [[nodiscard]] const std::vector<glm::dvec3>& velocities_W() const { return v_W_; }
  [[nodiscard]] int cells_x() const { return params_.cells_x; }
  [[nodiscard]] int cells_y() const { return params_.cells_y; }
  [[nodiscard]] int held(int bond) const;  // points that still hold
  // Of the last step: mean wrench on a body about a point fixed in W.
  [[nodiscard]] core::Wrench MeanWrenchOn(int body, const glm::dvec3& p_W) const;
  // Mean force with which a bond pulled on its body in the last step.
  [[nodiscard]] glm::dvec3 BondForce_W(int bond) const;

  [[nodiscard]] glm::dvec3 momentum_Ns() const;
  [[nodiscard]] glm::dvec3 angular_momentum_Nms() const;  // about the origin of W
  [[nodiscard]] double energy_J() const;                  // kinetic, stretching and bending
  [[nodiscard]] double mass_kg() const { return mass_kg_; }

  void ExchangeState(Checkpoint* checkpoint);
  [[nodiscard]] std::uint64_t StateHash() const;

 private:
  struct Body {
    BodyKind kind = BodyKind::kFixed;
    std::shared_ptr<const ClothShape> shape;
    glm::dvec3 p_OCm{0.0};
    glm::dmat3 I_Cm_O{0.0};
    double inverse_mass = 0.0;
    core::Pose X_WO;
    core::Pose X_WO_target;
    bool is_placed = false;
    // Within a step.
    glm::dvec3 p_WCm{0.0};
    glm::dvec3 v_W{0.0};  // of Cm
    glm::dvec3 w_W{0.0};
    glm::dmat3 inverse_inertia_W{0.0};
    glm::dvec3 impulse_Ns{0.0};
    glm::dvec3 moment_Nms{0.0};  // about the origin of W
    double duration_s = 0.0;
    double share = 0.0;  // of the points that hold the sheet, by number
  };
  // A point of the sheet, of up to four nodes, on a spring to a body.
  struct Hold {
    std::array<std::uint32_t, 4> node{};
    std::array<double, 4> weight{};
    int body = 0;
    int bond = 0;  // -1: a grip
    glm::dvec3 p_O{0.0};
    double stiffness_N_per_m = 0.0;
    double damping_N_s_per_m = 0.0;
    bool is_active = true;
    // Within a step.
    glm::dvec3 p_W{0.0};
    glm::dvec3 force_N{0.0};  // at the start of the substep
    glm::dvec3 mobility{0.0};
    glm::dvec3 impulse_Ns{0.0};
  };
  struct Bond {
    int body = 0;
    double release_force_N = 1e30;
    int num_held = 0;
    glm::dvec3 impulse_Ns{0.0};  // on the body, over the step
  };
  struct Contact {
    std::uint32_t node = 0;
    int body = 0;
    glm::dvec3 normal_W{0.0};
    double gap_m = 0.0;
    double mobility = 0.0;
    double push_Ns = 0.0;
    glm::dvec3 friction_Ns{0.0};
  };
  struct RigidMotion {  // that carries the sheet's momentum
    glm::dvec3 p_WCm{0.0};
    glm::dvec3 v_W{0.0};
    glm::dvec3 w_W{0.0};
    glm::dmat3 inertia_W{0.0};
  };

  explicit Cloth(const ClothParams& params, ClothGrid&& grid);

  [[nodiscard]] bool IsInside(std::size_t node, const core::Pose& X_OW, const glm::dvec3& lower_O,
                              const glm::dvec3& upper_O) const;
  void StartBodies(double dt_s);
  void FindContacts(double dt_s);
  void TouchBody(int body, double dt_s);
  void Substep(double h_s);
  void ApplyBending(double h_s);
  void PrepareSprings(double h_s);
  void PrepareHolds();
  void PrepareContacts();
  void SolveSprings();
  void SolveHolds(double h_s);
  void SolveContacts(double h_s);
  void PushBody(Body* body, const glm::dvec3& p_W, const glm::dvec3& impulse_W);
  void MoveBodies(double h_s);
  void CountHolds();
  void Damp(double dt_s);
  [[nodiscard]] RigidMotion FitRigidMotion() const;
  void ScaleInnerMotion(const RigidMotion& rigid, double scale);
  [[nodiscard]] double kinetic_J() const;
  [[nodiscard]] double elastic_J() const;

  ClothParams params_;
  ClothGrid grid_;
  double mass_kg_ = 0.0;
  std::vector<double> inverse_mass_;
  std::vector<glm::dvec3> x_W_;
  std::vector<glm::dvec3> v_W_;
  std::vector<Body> bodies_;
  std::vector<Bond> bonds_;
  std::vector<Hold> holds_;  // of bonds, then of grips
  std::size_t num_bonded_ = 0;
  std::vector<Contact> contacts_;
  std::vector<std::uint8_t> is_gripped_;

  // Scratch of a substep.
  struct SpringState {
    glm::dvec3 direction_W{0.0};
    double target_Ns = 0.0;    // impulse at rest
    double per_speed = 0.0;    // change of it with the speed, N s per m/s
    double per_impulse = 0.0;  // and with the impulse so far
    double impulse_Ns = 0.0;
  };
  double spring_h_s_ = 0.0;  // substep that the two factors hold for
  std::vector<SpringState> spring_states_;
  int num_holding_ = 0;  // points that hold the sheet
};

}  // namespace physics

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

// A body that a cloth touches or is attached to. Within a step the cloth's impulses move a dynamic body, so that its
// inertia limits the forces between them; its owner applies the mean wrench and sets its state before the next step.
struct ClothBodyParams {
  BodyKind kind = BodyKind::kFixed;
  core::Pose X_WO;
  MassProperties mass;                      // dynamic only
  std::shared_ptr<const ClothShape> shape;  // null: nodes pass through it
};

// Springs between points of the sheet and points of a body. With a release force they are hook-and-loop.
struct ClothBondParams {
  int body = 0;
  double stiffness_N_per_m = 0.0;  // per point
  double damping_N_s_per_m = 0.0;
  double release_force_N = 1e30;  // a point breaks for good when its spring exceeds this
};

// A deformable sheet: nodes joined by stretch springs that are implicit along their line, like a world's soft rows, and
// by explicit bending forces. Contacts and bonds are constraint rows of the same projected Gauss-Seidel solver
// (sequential impulses).
//
// Momentum: every pair of opposite impulses acts along a line through positions at the start of a substep, so linear
// and angular momentum are exact for any number of sweeps: with x' = x + h v' and sum x x p = 0 over the impulses p,
// sum x' x m v' = sum x x m v.
//
// Energy: the implicit springs dissipate a little; bending, an explicit force in a symplectic step, neither gains nor
// loses energy in the mean.
//
// Equal inputs give equal bits. Step does not allocate, lock or throw.
class Cloth {
 public:
  // Errors: those of BuildClothGrid.
  static core::Result<std::unique_ptr<Cloth>> Create(const ClothParams& params);

  // Setup, with the sheet flat and the bodies at their initial poses. Points are given in W; a bond has zero force
  // there.
  core::Result<int> AddBody(const ClothBodyParams& params);
  // Adds a bond of several points and returns its index. Error: kInvalidInput for an unknown body or a point off the
  // sheet.
  core::Result<int> AddBond(const ClothBondParams& params, const std::vector<glm::dvec3>& points_W);

  // Between steps. A kinematic body moves to this pose at constant velocity over the next step; a dynamic one starts
  // there with this velocity of its mesh-frame origin.
  void SetBody(int body, const core::Pose& X_WO, const core::Twist& V_WO = {});
  // Stops every node. The next SetBody places a body at once instead of moving it there.
  void Rest();
  void SetReleaseForce(int bond, double release_force_N);
  // Grips all nodes inside a box of the body's mesh frame at their current positions and returns their number, which
  // CountInside computes without gripping. One grip per body. Gripped nodes do not touch kinematic bodies.
  [[nodiscard]] int CountInside(int body, const glm::dvec3& lower_O, const glm::dvec3& upper_O) const;
  int Grip(const ClothBondParams& params, const glm::dvec3& lower_O, const glm::dvec3& upper_O);
  void Release(int body);
  [[nodiscard]] int num_gripped(int body) const;

  void Step(double dt_s);

  [[nodiscard]] const std::vector<glm::dvec3>& positions_W() const { return x_W_; }
  [[nodiscard]] const std::vector<glm::dvec3>& velocities_W() const { return v_W_; }
  [[nodiscard]] int cells_x() const { return params_.cells_x; }
  [[nodiscard]] int cells_y() const { return params_.cells_y; }
  [[nodiscard]] int held(int bond) const;  // points that are not broken
  // Mean wrench on a body over the last step, about a point fixed in W.
  [[nodiscard]] core::Wrench MeanWrenchOn(int body, const glm::dvec3& p_W) const;
  // Mean force of a bond on its body over the last step.
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
    double share = 0.0;  // fraction of the holding points that are on this body
  };
  // A spring from a point of the sheet, interpolated from up to four nodes, to a body.
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
  struct RigidMotion {  // the rigid motion with the sheet's momentum and angular momentum
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
  void FindContactsWith(int body, double dt_s);
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
    double target_Ns = 0.0;    // impulse at speed 0
    double per_speed = 0.0;    // its derivative by the speed, N s per m/s
    double per_impulse = 0.0;  // and by the impulse before the update
    double impulse_Ns = 0.0;
  };
  double spring_h_s_ = 0.0;  // substep for which the two derivatives were computed
  std::vector<SpringState> spring_states_;
  int num_holding_ = 0;  // points of bonds and grips that hold the sheet
};

}  // namespace physics

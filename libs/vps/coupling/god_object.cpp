#include "vps/coupling/god_object.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "vps/coupling/stick_slip.hpp"

namespace vps {
namespace {

constexpr int kMostPasses = 2;             // linearisations in a cycle
constexpr double kNonlinear_m = 1e-6;      // what a linearisation may be off before there is another
constexpr double kLeastWork_J = 1e-5;      // that is judged: what a linearisation may be off at a hand's 10 N
constexpr double kContradiction_m = 1e-9;  // of planes that leave no room for the tool
constexpr int kMostRounds = 4;             // of friction
constexpr int kSweepsInARound = 8;
constexpr double kSettled = 1e-3;    // of the largest normal force
constexpr double kMostDetour = 3.0;  // of the way out of planes, of the depth
constexpr double kLeastTravel_m = 1e-5;
// What rounding leaves of gaps, of poses in single precision.
constexpr double kStuck_m = 1e-8;
constexpr int kMostTurns = 8;
constexpr double kStuckBeyond = 1.01;  // of the cone: what FindFriction leaves of a force that slides is on it so well

// A pose of the tool as its centre of mass, and back.
glm::dvec3 CentreOfMass(const core::Pose& X_WC, const glm::dvec3& p_CoCm_C) {
  return X_WC * p_CoCm_C;
}

// K (d - d_D), at the centre of mass.
core::Wrench SpringWrench(const GodObjectParameters& p, const core::Pose& X_WC, const core::Pose& X_WD) {
  return {p.stiffness_N_per_m * (CentreOfMass(X_WC, p.p_CoCm_C) - CentreOfMass(X_WD, p.p_CoCm_C)),
          p.stiffness_Nm_per_rad * core::RotationVector(X_WC.rotation * glm::conjugate(X_WD.rotation))};
}

// Two unit vectors orthogonal to n and to each other.
std::array<glm::dvec3, 2> Tangents(const glm::dvec3& n) {
  const glm::dvec3 axis = std::abs(n.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 u = glm::normalize(glm::cross(n, axis));
  return {u, glm::cross(n, u)};
}

using Matrix6 = std::array<Vector6, 6>;

void AddOuter(const Vector6& row, Matrix6* m) {
  for (std::size_t i = 0; i < 6; ++i) AddScaled(row[i], row, &(*m)[i]);
}

// m = L L^T, with L in its lower half. Not where m leaves a direction as good as free.
bool Factor(Matrix6* m) {
  constexpr double kFree = 1e-6;  // of the mean
  double trace = 0.0;
  for (std::size_t k = 0; k < 6; ++k) trace += (*m)[k][k];
  for (std::size_t j = 0; j < 6; ++j) {
    for (std::size_t i = j; i < 6; ++i) {
      double sum = (*m)[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= (*m)[i][k] * (*m)[j][k];
      if (i == j && sum < kFree * trace / 6.0) return false;
      (*m)[i][j] = i == j ? std::sqrt(sum) : sum / (*m)[j][j];
    }
  }
  return true;
}

Vector6 Solved(const Matrix6& lower, Vector6 b) {
  for (std::size_t k = 0; k < 6; ++k) {
    for (std::size_t j = 0; j < k; ++j) b[k] -= lower[k][j] * b[j];
    b[k] /= lower[k][k];
  }
  for (std::size_t k = 6; k-- > 0;) {
    for (std::size_t j = k + 1; j < 6; ++j) b[k] -= lower[j][k] * b[j];
    b[k] /= lower[k][k];
  }
  return b;
}

// The tool with mass M about its centre of mass, implicitly over a cycle T, on a spring K and a damper B to the device,
// with contact forces l along the rows J of the planes:
//   M (d / T - v) / T = K (d_D - d) + B (e_D - d) / T + J^T l,
// d: its motion in this cycle, v: its velocity, d_D: the way from it to the device, e_D: the device's motion. Sorted,
//   A (d - d_F) = J^T l,   A = M / T^2 + B / T + K,   A d_F = (M / T) v + (B / T) e_D + K d_D.
// With gaps g + J d >= 0, l >= 0 and l (g + J d) = 0 these are the conditions of
//   min 1/2 (d - d_F)^T A (d - d_F)  subject to  g + J d >= 0:
// the tool goes where it is nearest to where it would go freely, in the metric A. Without mass A = K and d_F = d_D: it
// is nearest to the device, K (d - d_D) = J^T l, so the spring's wrench is exactly the contacts' sum, and the force is
// the gradient of 1/2 |d - d_D|^2_K minimised over a fixed set: it makes no energy.
// Friction adds forces along the planes to the right side (stick_slip.hpp).
//
// Where the tool is inside a plane it is first moved out, with no device and no friction (Recover): so planes that
// leave it no room, a peg's in its hole, make no forces against each other and no friction from them. Then it goes
// towards the device with every plane's bound as it stands: to stay is always allowed, so there is a solution.
struct Pass {
  const GodObjectParameters& parameters;
  const ToolMetric& metric;
  const core::Pose& X_WC;  // about which it is linearised
  std::span<HeldContact> contacts;
  HalfSpaces rows;
  NearestPoint nearest;
  std::array<FrictionContact, kMaxFrictionContacts> friction;
  std::array<std::size_t, kMaxFrictionContacts> friction_rows{};
  std::size_t num_friction = 0;

  Pass(const GodObjectParameters& p, const ToolMetric& m, const core::Pose& X, std::span<HeldContact> c)
      : parameters(p), metric(m), X_WC(X), contacts(c) {}

  [[nodiscard]] Vector6 Row(const glm::dvec3& p_W, const glm::dvec3& direction_W) const {
    const glm::dquat R_CW = glm::conjugate(X_WC.rotation);
    const glm::dvec3 n_C = R_CW * direction_W;
    const glm::dvec3 r_C = R_CW * (p_W - X_WC.translation) - parameters.p_CoCm_C;
    return metric.FromRow(n_C, glm::cross(r_C, n_C));
  }
  [[nodiscard]] Vector6 MotionTo(const core::Pose& X_WF) const {
    const glm::dvec3 x_W = CentreOfMass(X_WF, parameters.p_CoCm_C) - CentreOfMass(X_WC, parameters.p_CoCm_C);
    const glm::dquat R_CW = glm::conjugate(X_WC.rotation);
    return metric.FromMotion(R_CW * x_W, core::RotationVector(R_CW * X_WF.rotation));
  }

  void Linearise() {
    rows.count = contacts.size();
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const HeldContact& contact = contacts[i];
      rows.of[i] = {Row(contact.p_W, contact.n_W), -contact.gap_m, false, contact.normal_N > 0.0};
    }
  }

  // min 1/2 |y|^2 over the planes. Where they contradict each other, as those of two jaws that close on a part do, or
  // nearly so, and there is only a long way out to the side, the tool stays where it is. Bounds that are not met are
  // lowered to what is.
  Vector6 Recover() {
    double deepest_m = 0.0;
    for (std::size_t i = 0; i < rows.count; ++i) {
      rows.of[i].is_left_out = contacts[i].cycles_lost > 0;
      if (!rows.of[i].is_left_out) deepest_m = std::max(deepest_m, rows.of[i].b);
    }
    Vector6 y{};
    if (deepest_m > 0.0) {
      ProjectOntoHalfSpaces({}, rows, &nearest);
      const bool is_short = Travel_m(nearest.y) <= kMostDetour * deepest_m + kLeastTravel_m;
      if (nearest.worst_violation <= kContradiction_m && is_short) y = nearest.y;
    }
    for (std::size_t i = 0; i < rows.count; ++i) {
      rows.of[i].b = std::min(rows.of[i].b, Dot(rows.of[i].a, y));
      rows.of[i].is_left_out = false;
    }
    return y;
  }
  // Bound of a motion's way at any point of the tool: a point at distance r moves by at most |x| + r |phi|.
  [[nodiscard]] double Travel_m(const Vector6& y) const {
    glm::dvec3 x_C;
    glm::dvec3 phi_C;
    metric.ToMotion(y, &x_C, &phi_C);
    return glm::length(x_C) + parameters.bounding_radius_m * glm::length(phi_C);
  }
  // Not farther than is known to be free. Where planes are near that is the look-ahead, so nothing is passed whose
  // planes were not there before. The way out of what the tool is in is always gone; what is between the two meets
  // every plane's bound, because both ends do.
  bool KeepWithin(double free_m, const Vector6& out, Vector6* way) const {
    const double travel_m = Travel_m(*way);
    if (travel_m <= free_m) return false;
    const double out_m = Travel_m(out);
    const double share = std::max(free_m - out_m, 0.0) / (travel_m - std::min(out_m, free_m));
    for (std::size_t k = 0; k < 6; ++k) (*way)[k] = out[k] + share * ((*way)[k] - out[k]);
    return true;
  }

  [[nodiscard]] core::Pose Moved(const Vector6& way) const {
    glm::dvec3 x_C;
    glm::dvec3 phi_C;
    metric.ToMotion(way, &x_C, &phi_C);
    core::Pose moved;
    moved.rotation = glm::normalize(X_WC.rotation * core::QuaternionFromRotationVector(phi_C));
    moved.translation = CentreOfMass(X_WC, parameters.p_CoCm_C) + X_WC.rotate(x_C) - moved.rotate(parameters.p_CoCm_C);
    return moved;
  }

  void AddFriction(std::size_t i) {
    if (num_friction == kMaxFrictionContacts) return;
    const HeldContact& contact = contacts[i];
    const std::array<glm::dvec3, 2> tangents = Tangents(contact.n_W);
    FrictionContact& f = friction[num_friction];
    friction_rows[num_friction++] = i;
    f.normal = rows.of[i].a;
    f.bound = rows.of[i].b;
    f.friction = contact.friction;
    f.most_N = contact.most_N;
    f.normal_N = contact.normal_N > 0.0 ? contact.normal_N : nearest.multipliers[i];
    for (std::size_t k = 0; k < 2; ++k) {
      f.tangents[k] = Row(contact.p_W, tangents[k]);
      f.slip_m[k] = glm::dot(tangents[k], contact.slip_W);
      f.tangent_N[k] = glm::dot(tangents[k], contact.tangent_W_N);
    }
  }
  [[nodiscard]] bool HasFriction(std::size_t i) const {
    return std::find(friction_rows.begin(), friction_rows.begin() + num_friction, i) !=
           friction_rows.begin() + num_friction;
  }

  // True when the tool is stuck: small changes of the last cycle's forces hold it where they hold it fast, all inside
  // their cones. The rows J of the loaded contacts' normals and tangents leave the motion y that is nearest to what all
  // of them want, J y = w, and forces l + J z, the least change, make it the balanced one:
  //   J^T J y = J^T w,   J^T J z = y - free - J^T l.
  // FindFriction would find it, too, but only about, and what it is off by adds up: a tool at rest would creep.
  bool Stick(const Vector6& free) {
    Matrix6 square{};
    Vector6 wanted{};
    bool has_friction = false;
    const auto add = [&](const Vector6& row, double to) {
      AddOuter(row, &square);
      AddScaled(to, row, &wanted);
    };
    num_friction = 0;
    for (std::size_t i = 0; i < rows.count; ++i) {
      const HeldContact& contact = contacts[i];
      if (!(contact.normal_N > 0.0)) continue;
      if (contact.cycles_lost > 0 || num_friction == kMaxFrictionContacts) return false;
      has_friction = has_friction || contact.friction > 0.0;
      AddFriction(i);
      const FrictionContact& f = friction[num_friction - 1];
      add(f.normal, f.bound);
      if (f.friction == 0.0) continue;
      for (std::size_t k = 0; k < 2; ++k) add(f.tangents[k], -f.slip_m[k]);
    }
    if (!has_friction || !Factor(&square)) return false;
    const Vector6 y = Solved(square, wanted);
    for (std::size_t k = 0; k < num_friction; ++k) {
      const FrictionContact& f = friction[k];
      if (std::abs(Dot(f.normal, y) - f.bound) > kStuck_m) return false;
      for (std::size_t t = 0; t < 2 && f.friction > 0.0; ++t) {
        if (std::abs(Dot(f.tangents[t], y) + f.slip_m[t]) > kStuck_m) return false;
      }
    }
    for (std::size_t i = 0; i < rows.count; ++i) {
      if (rows.of[i].b - Dot(rows.of[i].a, y) > kStuck_m) return false;
    }
    if (!Hold(free, y, square)) return false;
    nearest.y = y;
    std::fill_n(nearest.multipliers.begin(), rows.count, 0.0);
    for (std::size_t k = 0; k < num_friction; ++k) nearest.multipliers[friction_rows[k]] = friction[k].normal_N;
    return true;
  }

  // In turns: forces that balance at y, then those outside their cones back onto them.
  bool Hold(const Vector6& free, const Vector6& y, const Matrix6& factor) {
    for (int turn = 0; turn < kMostTurns; ++turn) {
      Vector6 lack = y;
      AddScaled(-1.0, free, &lack);
      for (std::size_t k = 0; k < num_friction; ++k) {
        const FrictionContact& f = friction[k];
        AddScaled(-f.normal_N, f.normal, &lack);
        for (std::size_t t = 0; t < 2; ++t) AddScaled(-f.tangent_N[t], f.tangents[t], &lack);
      }
      const Vector6 z = Solved(factor, lack);
      bool is_held = true;
      for (std::size_t k = 0; k < num_friction; ++k) {
        FrictionContact& f = friction[k];
        f.normal_N += Dot(f.normal, z);
        if (!(f.normal_N > 0.0)) return false;
        if (f.friction == 0.0) continue;
        for (std::size_t t = 0; t < 2; ++t) f.tangent_N[t] += Dot(f.tangents[t], z);
        is_held = is_held && std::hypot(f.tangent_N[0], f.tangent_N[1]) <= kStuckBeyond * f.friction * f.normal_N;
      }
      if (is_held) return true;
      for (std::size_t k = 0; k < num_friction; ++k) {
        FrictionContact& f = friction[k];
        const double length_N = std::hypot(f.tangent_N[0], f.tangent_N[1]);
        const double limit_N = f.friction * f.normal_N;
        if (length_N <= limit_N) continue;
        for (double& force_N : f.tangent_N) force_N *= limit_N / length_N;
      }
    }
    return false;
  }

  // Solved exactly without friction. If something is touched, friction is found for what is, and what it runs into
  // besides; then, with the forces along the planes as they are, exactly again.
  Vector6 Project(const Vector6& free, const Vector6& out) {
    if (!Stick(free)) {
      FindForces(free);
      Dissipate(free, out);
    }
    for (std::size_t i = 0; i < rows.count; ++i) {
      contacts[i].normal_N = nearest.multipliers[i];
      contacts[i].tangent_W_N = glm::dvec3(0.0);
    }
    for (std::size_t k = 0; k < num_friction; ++k) {
      HeldContact& contact = contacts[friction_rows[k]];
      const std::array<glm::dvec3, 2> tangents = Tangents(contact.n_W);
      contact.tangent_W_N = friction[k].tangent_N[0] * tangents[0] + friction[k].tangent_N[1] * tangents[1];
      if (rows.of[friction_rows[k]].is_left_out) contact.normal_N = friction[k].normal_N;
    }
    return nearest.y;
  }
  // Forces of contacts take energy out: A (y - free) is their sum, so on the way from `out` to y the sum does work
  //   W = 1/2 |y - free|^2 - 1/2 |out - free|^2,
  // and W is at most what parts that have moved along their planes since the last cycle put in by friction, -t . slip.
  // Where the search for friction stopped too early, W can be larger: then the tool goes only as far as W is least.
  // Less than a linearisation's error is let go: to stop for it would keep a search from its end over several cycles.
  void Dissipate(const Vector6& free, const Vector6& out) {
    double put_in_J = 0.0;
    for (std::size_t k = 0; k < num_friction; ++k) {
      const FrictionContact& f = friction[k];
      put_in_J += std::max(-f.tangent_N[0] * f.slip_m[0] - f.tangent_N[1] * f.slip_m[1], 0.0);
    }
    Vector6 way = nearest.y;
    Vector6 wish = free;
    AddScaled(-1.0, out, &way);
    AddScaled(-1.0, out, &wish);
    const double length2 = Dot(way, way);
    const double along = Dot(way, wish);
    if (0.5 * length2 - along <= put_in_J + kLeastWork_J) return;
    const double share = std::clamp(along / length2, 0.0, 1.0);
    nearest.y = out;
    AddScaled(share, way, &nearest.y);
  }
  void FindForces(const Vector6& free) {
    ProjectOntoHalfSpaces(free, rows, &nearest);
    num_friction = 0;
    bool is_touching = false;
    bool is_simple = true;
    for (std::size_t i = 0; i < rows.count; ++i) {
      const bool is_active = nearest.multipliers[i] > 0.0;
      is_touching = is_touching || is_active;
      if (!is_active && !(contacts[i].normal_N > 0.0)) continue;
      AddFriction(i);
      is_simple = is_simple && contacts[i].friction == 0.0 && contacts[i].cycles_lost == 0;
    }
    if (!is_touching || is_simple) {
      num_friction = 0;
    } else {
      FindFriction(free);
    }
  }
  // In turns: some sweeps over all forces, then the normal ones exactly for the forces along the planes as they are.
  // The sweeps alone take long where a tool is held at several places far apart.
  void FindFriction(const Vector6& free) {
    for (int round = 0; round < kMostRounds; ++round) {
      SolveStickSlip(free, {friction.data(), num_friction}, kSweepsInARound);
      Vector6 pushed = free;
      for (std::size_t k = 0; k < num_friction; ++k) {
        const FrictionContact& f = friction[k];
        for (std::size_t t = 0; t < 2; ++t) AddScaled(f.tangent_N[t], f.tangents[t], &pushed);
        rows.of[friction_rows[k]].is_left_out = f.normal_N >= f.most_N;
        if (f.normal_N >= f.most_N) AddScaled(f.normal_N, f.normal, &pushed);
      }
      for (std::size_t i = 0; i < rows.count; ++i) rows.of[i].was_active = nearest.multipliers[i] > 0.0;
      ProjectOntoHalfSpaces(pushed, rows, &nearest);
      if (TakeNormals()) break;
    }
  }
  // True when they are what they were.
  bool TakeNormals() {
    double change_N = 0.0;
    double largest_N = 0.0;
    for (std::size_t k = 0; k < num_friction; ++k) {
      FrictionContact& f = friction[k];
      if (f.normal_N >= f.most_N) continue;
      const double normal_N = nearest.multipliers[friction_rows[k]];
      change_N = std::max(change_N, std::abs(normal_N - f.normal_N));
      largest_N = std::max(largest_N, normal_N);
      f.normal_N = normal_N;
    }
    bool is_complete = true;
    for (std::size_t i = 0; i < rows.count; ++i) {
      if (!(nearest.multipliers[i] > 0.0) || HasFriction(i)) continue;
      AddFriction(i);
      is_complete = false;
    }
    return is_complete && change_N <= kSettled * largest_N;
  }
};

}  // namespace

void GodObject::Reset(const core::Pose& X_WD) {
  X_WC_ = X_WC_before_ = X_WD_before_ = X_WD;
  memory_.Reset();
}

// Where the tool would go without contact.
core::Pose GodObject::FreePose(const core::Pose& X_WD) const {
  if (parameters_.mass_kg == 0.0) return X_WD;
  const GodObjectParameters& p = parameters_;
  const double T = p.period_s;
  const glm::dvec3 p_WCm = CentreOfMass(X_WC_, p.p_CoCm_C);
  const glm::dvec3 x_D = CentreOfMass(X_WD, p.p_CoCm_C) - p_WCm;
  const glm::dvec3 x_before = p_WCm - CentreOfMass(X_WC_before_, p.p_CoCm_C);
  const glm::dvec3 e_D = CentreOfMass(X_WD, p.p_CoCm_C) - CentreOfMass(X_WD_before_, p.p_CoCm_C);
  const double M = p.mass_kg / (T * T);
  const double B = metric_.damping_N_s_per_m() / T;
  const glm::dvec3 x_F = (M * x_before + B * e_D + p.stiffness_N_per_m * x_D) / (M + B + p.stiffness_N_per_m);

  const glm::dquat R_CW = glm::conjugate(X_WC_.rotation);
  const glm::dvec3 phi_D = core::RotationVector(R_CW * X_WD.rotation);
  const glm::dvec3 phi_before = core::RotationVector(glm::conjugate(X_WC_before_.rotation) * X_WC_.rotation);
  const glm::dvec3 turn_D = core::RotationVector(X_WD.rotation * glm::conjugate(X_WD_before_.rotation));
  const glm::dmat3 I = p.I_Cm_C_kg_m2 / (T * T);
  const double B_t = metric_.damping_Nm_s_per_rad() / T;
  const glm::dvec3 phi_F = glm::inverse(I + glm::dmat3(B_t + p.stiffness_Nm_per_rad)) *
                           (I * phi_before + B_t * (R_CW * turn_D) + p.stiffness_Nm_per_rad * phi_D);
  core::Pose X_WF;
  X_WF.rotation = glm::normalize(X_WC_.rotation * core::QuaternionFromRotationVector(phi_F));
  X_WF.translation = p_WCm + x_F - X_WF.rotate(p.p_CoCm_C);
  return X_WF;
}

core::Wrench GodObject::Step(const core::Pose& X_WD, const ToolContact& contact,
                             std::span<const core::Pose> X_WO) noexcept {
  const GodObjectParameters& p = parameters_;
  const core::Pose X_WC_found = X_WC_;
  const core::Pose X_WF = FreePose(X_WD);
  memory_.Take({contact.planes.begin(), contact.planes.size()}, X_WC_, X_WO);
  const std::span<HeldContact> contacts = memory_.contacts();

  double free_m = std::max(contact.free_distance_m, kLeastTravel_m);
  bool is_held = false;
  for (int linearisation = 0; linearisation < kMostPasses; ++linearisation) {
    Pass pass(p, metric_, X_WC_, contacts);
    pass.Linearise();
    const Vector6 out = pass.Recover();
    Vector6 way = pass.Project(pass.MotionTo(X_WF), out);
    is_held = pass.KeepWithin(free_m, out, &way);
    free_m = std::max(free_m - pass.Travel_m(way), 0.0);
    const core::Pose moved = pass.Moved(way);
    const core::Pose motion = moved * X_WC_.inverse();
    double off_m = 0.0;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      HeldContact& held = contacts[i];
      is_held = is_held || held.normal_N > 0.0;
      const glm::dvec3 moved_by = motion * held.p_W - held.p_W;
      if (held.cycles_lost == 0) off_m = std::max(off_m, pass.rows.of[i].b - glm::dot(held.n_W, moved_by));
      held.p_W += moved_by;
      held.gap_m += glm::dot(held.n_W, moved_by);
      held.slip_W += moved_by - glm::dot(held.n_W, moved_by) * held.n_W;
    }
    X_WC_ = moved;
    if (off_m < kNonlinear_m) break;
  }
  memory_.Keep(X_WC_found, X_WO);
  if (!is_held && p.mass_kg == 0.0) X_WC_ = X_WD;  // free: exactly D
  const core::Wrench F_Do_W = CouplingWrench(X_WC_found, X_WD);
  X_WC_before_ = X_WC_found;
  X_WD_before_ = X_WD;
  return F_Do_W;
}

// K (d - d_D) and, of a tool with mass, B (d - e_D) / T, at the centre of mass; then about Do.
core::Wrench GodObject::CouplingWrench(const core::Pose& X_WC_found, const core::Pose& X_WD) const {
  const GodObjectParameters& p = parameters_;
  const glm::dvec3 p_WCm = CentreOfMass(X_WC_, p.p_CoCm_C);
  const glm::dvec3 p_WCm_D = CentreOfMass(X_WD, p.p_CoCm_C);
  core::Wrench F_Cm_W = SpringWrench(p, X_WC_, X_WD);
  if (p.mass_kg > 0.0) {
    const glm::dvec3 d = p_WCm - CentreOfMass(X_WC_found, p.p_CoCm_C);
    const glm::dvec3 e_D = p_WCm_D - CentreOfMass(X_WD_before_, p.p_CoCm_C);
    const glm::dvec3 turn = core::RotationVector(X_WC_.rotation * glm::conjugate(X_WC_found.rotation));
    const glm::dvec3 turn_D = core::RotationVector(X_WD.rotation * glm::conjugate(X_WD_before_.rotation));
    F_Cm_W += {metric_.damping_N_s_per_m() / p.period_s * (d - e_D),
               metric_.damping_Nm_s_per_rad() / p.period_s * (turn - turn_D)};
  }
  return core::ShiftWrench(F_Cm_W, p_WCm_D - X_WD.translation);
}

core::Wrench ContactWrench(const GodObjectParameters& parameters, const ToolMetric& metric, const core::Pose& X_WC,
                           const core::Pose& X_WD, std::span<HeldContact> contacts) noexcept {
  Pass pass(parameters, metric, X_WC, contacts);
  pass.Linearise();
  const Vector6 out = pass.Recover();
  const core::Pose moved = pass.Moved(pass.Project(pass.MotionTo(X_WD), out));
  return core::ShiftWrench(SpringWrench(parameters, moved, X_WD), X_WD.rotate(parameters.p_CoCm_C));
}

}  // namespace vps

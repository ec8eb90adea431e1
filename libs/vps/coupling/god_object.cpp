#include "vps/coupling/god_object.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "vps/coupling/stick_slip.hpp"

namespace vps {
namespace {

// Linearisations in a cycle, and what one may be off before there is another: a twentieth of the 20 um within which the
// tool is to rest on a plane. With one, or with 10 um, GodObject.ATwistDoesNotCarryItIntoAWall fails; four change no
// bit of peg_in_hole/tight.xml and two_hands.
constexpr int kMostPasses = 2;
constexpr double kNonlinear_m = 1e-6;
// Of planes that leave no room for the tool: a hundred times what ProjectOntoHalfSpaces is off by, and nothing that is
// felt (2.5 uN). From 1e-11 to 1e-7 every test passes.
constexpr double kContradiction_m = 1e-9;
// The longest way out of planes, of the depth, beyond which they count as a contradiction. Out of a wedge of 39 degrees
// it is 3 depths (1 / sin 19.5); a free choice between longer jumps and wedges that are taken for jaws. 10 changes no
// bit of those two scenarios, 1 does.
constexpr double kMostDetour = 3.0;
// A way that is always short, and always free: half of the 20 um. With 1 um a tool on walls that stand still gives
// energy (GodObject.FrictionOfWallsThatStandStillGivesNoEnergy); 0.1 mm passes, and is five times the rest depth.
constexpr double kLeastTravel_m = 1e-5;

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
  bool is_first;  // of the cycle: the next one only corrects it, under the same limits of friction
  NearestPoint nearest;

  Pass(const GodObjectParameters& p, const ToolMetric& m, const core::Pose& X, std::span<HeldContact> c,
       bool is_first_pass)
      : parameters(p), metric(m), X_WC(X), contacts(c), is_first(is_first_pass) {}

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

  // Exact where there is no friction: then nothing else is asked.
  Vector6 Project(const Vector6& free, const Vector6& out) {
    const auto has_any = [&](const auto& is_one) {
      for (std::size_t i = 0; i < rows.count; ++i) {
        if (is_one(i)) return true;
      }
      return false;
    };
    const auto carries = [&](std::size_t i) { return contacts[i].normal_N > 0.0; };
    const auto is_plain = [&](std::size_t i) { return contacts[i].friction == 0.0 && contacts[i].cycles_lost == 0; };
    if (has_any([&](std::size_t i) { return carries(i) && !is_plain(i); })) return ProjectWithFriction(free, out);
    ProjectOntoHalfSpaces(free, rows, &nearest);
    for (std::size_t i = 0; i < rows.count; ++i) {
      contacts[i].normal_N = nearest.multipliers[i];
      contacts[i].tangent_W_N = glm::dvec3(0.0);
    }
    if (has_any([&](std::size_t i) { return carries(i) && !is_plain(i); })) return ProjectWithFriction(free, out);
    return nearest.y;
  }

  Vector6 ProjectWithFriction(const Vector6& free, const Vector6& out) {
    std::array<Contact, kMaxHalfSpaces> of;
    std::array<std::array<glm::dvec3, 2>, kMaxHalfSpaces> tangents_W;
    const std::span<Contact> solved(of.data(), rows.count);
    for (std::size_t i = 0; i < rows.count; ++i) {
      const HeldContact& contact = contacts[i];
      Contact& c = of[i];
      c.normal = rows.of[i].a;
      c.bound = rows.of[i].b;
      c.most_N = contact.most_N;
      c.friction = contact.friction;
      c.limit_N = is_first ? contact.friction * std::min(contact.normal_N, contact.most_N) : contact.limit_N;
      if (c.friction == 0.0) continue;
      tangents_W[i] = Tangents(contact.n_W);
      for (std::size_t t = 0; t < 2; ++t) {
        c.tangents[t] = Row(contact.p_W, tangents_W[i][t]);
        c.slip_m[t] = glm::dot(tangents_W[i][t], contact.slip_W);
      }
    }
    const Vector6 y = is_first ? SolveStickSlip(free, out, solved) : SolveStickSlipWithLimits(free, out, solved);
    for (std::size_t i = 0; i < rows.count; ++i) {
      contacts[i].normal_N = of[i].normal_N;
      contacts[i].limit_N = of[i].limit_N;
      contacts[i].tangent_W_N = glm::dvec3(0.0);
      if (of[i].friction == 0.0) continue;
      for (std::size_t t = 0; t < 2; ++t) contacts[i].tangent_W_N += of[i].tangent_N[t] * tangents_W[i][t];
    }
    return y;
  }
};

// A contact that sticks is off its anchor by what the force along its plane bends it.
void Bend(std::span<HeldContact> contacts) {
  for (HeldContact& contact : contacts) contact.slip_W -= contact.tangent_W_N / kContactStiffness_N_per_m;
}

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
  Bend(contacts);

  double free_m = std::max(contact.free_distance_m, kLeastTravel_m);
  bool is_held = false;
  for (int linearisation = 0; linearisation < kMostPasses; ++linearisation) {
    Pass pass(p, metric_, X_WC_, contacts, linearisation == 0);
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
      is_held = is_held || held.normal_N > 0.0 || held.tangent_W_N != glm::dvec3(0.0);
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
  Bend(contacts);
  Pass pass(parameters, metric, X_WC, contacts, true);
  pass.Linearise();
  const Vector6 out = pass.Recover();
  const core::Pose moved = pass.Moved(pass.Project(pass.MotionTo(X_WD), out));
  return core::ShiftWrench(SpringWrench(parameters, moved, X_WD), X_WD.rotate(parameters.p_CoCm_C));
}

}  // namespace vps

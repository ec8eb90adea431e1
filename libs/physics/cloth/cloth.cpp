#include "physics/cloth/cloth.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/hash.hpp"

namespace physics {
namespace {

constexpr std::size_t kMaxGrips = 128;       // nodes in grips
constexpr std::size_t kContactsPerNode = 3;  // room for contacts; a node in a corner of three bodies
constexpr double kLookAhead_m = 0.001;       // beyond what the motion of one step covers
constexpr double kRecovery_m_per_s = 0.25;   // at which a node that is too near is moved out
constexpr double kBendingStepLimit = 1.4;    // of the explicit limit 2 for omega h
constexpr int kSweeps = 2;                   // of the solver, per substep

glm::dmat3 RotationMatrix(const glm::dquat& q) {
  return glm::mat3_cast(q);
}

}  // namespace

core::Result<std::unique_ptr<Cloth>> Cloth::Create(const ClothParams& params) {
  auto grid = BuildClothGrid(params);
  if (!grid) return core::Fail(grid.error().code, grid.error().detail);
  return std::unique_ptr<Cloth>(new Cloth(params, std::move(*grid)));
}

Cloth::Cloth(const ClothParams& params, ClothGrid&& grid)
    : params_(params), grid_(std::move(grid)), x_W_(grid_.p_W), v_W_(grid_.p_W.size(), glm::dvec3(0.0)) {
  for (const double mass : grid_.mass_kg) {
    inverse_mass_.push_back(1.0 / mass);
    mass_kg_ += mass;
  }
  is_gripped_.resize(x_W_.size(), 0);
  spring_states_.resize(grid_.springs.size());
  contacts_.reserve(x_W_.size() * kContactsPerNode);
  holds_.reserve(kMaxGrips);
}

core::Result<int> Cloth::AddBody(const ClothBodyParams& params) {
  if (params.kind == BodyKind::kDynamic && !IsPhysical(params.mass)) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "cloth: body " + std::to_string(bodies_.size()) + " moves freely but has no real mass");
  }
  Body body;
  body.kind = params.kind;
  body.shape = params.shape;
  body.X_WO = params.X_WO;
  body.X_WO_target = params.X_WO;
  if (params.kind == BodyKind::kDynamic) {
    body.p_OCm = params.mass.p_OCm_m;
    body.I_Cm_O = params.mass.I_Cm_O_kg_m2;
    body.inverse_mass = 1.0 / params.mass.mass_kg;
  }
  body.p_WCm = body.X_WO * body.p_OCm;
  bodies_.push_back(std::move(body));
  return static_cast<int>(bodies_.size()) - 1;
}

core::Result<int> Cloth::AddBond(const ClothBondParams& params, const std::vector<glm::dvec3>& points_W) {
  if (params.body < 0 || static_cast<std::size_t>(params.body) >= bodies_.size()) {
    return core::Fail(core::ErrorCode::kInvalidInput, "cloth: a bond to a body that was not added");
  }
  const core::Pose X_SW = params_.X_WS.inverse();
  const Body& body = bodies_[static_cast<std::size_t>(params.body)];
  for (std::size_t i = 0; i < points_W.size(); ++i) {
    const glm::dvec3 p_S = X_SW * points_W[i];
    // In cells from the lower corner; a hair outside is a rounding of the border itself.
    const double u = (p_S.x / params_.size_x_m + 0.5) * params_.cells_x;
    const double v = (p_S.y / params_.size_y_m + 0.5) * params_.cells_y;
    if (u < -0.01 || v < -0.01 || u > params_.cells_x + 0.01 || v > params_.cells_y + 0.01) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        "cloth: point " + std::to_string(i) + " of a bond is beside the sheet, at " +
                            std::to_string(p_S.x) + " " + std::to_string(p_S.y) + " m from its middle");
    }
    const int ci = std::clamp(static_cast<int>(u), 0, params_.cells_x - 1);
    const int cj = std::clamp(static_cast<int>(v), 0, params_.cells_y - 1);
    const double s = std::clamp(u - ci, 0.0, 1.0);
    const double t = std::clamp(v - cj, 0.0, 1.0);
    const auto node = [&](int di, int dj) {
      return static_cast<std::uint32_t>((cj + dj) * (params_.cells_x + 1) + ci + di);
    };
    Hold hold;
    hold.node = {node(0, 0), node(1, 0), node(0, 1), node(1, 1)};
    hold.weight = {(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t};
    hold.body = params.body;
    hold.bond = static_cast<int>(bonds_.size());
    glm::dvec3 p_W(0.0);
    for (std::size_t k = 0; k < 4; ++k) p_W += hold.weight[k] * x_W_[hold.node[k]];
    hold.p_O = body.X_WO.inverse() * p_W;
    hold.stiffness_N_per_m = params.stiffness_N_per_m;
    hold.damping_N_s_per_m = params.damping_N_s_per_m;
    holds_.push_back(hold);
  }
  num_bonded_ = holds_.size();
  holds_.reserve(num_bonded_ + kMaxGrips);
  bonds_.push_back({params.body, params.release_force_N, static_cast<int>(points_W.size()), glm::dvec3(0.0)});
  return static_cast<int>(bonds_.size()) - 1;
}

void Cloth::SetBody(int index, const core::Pose& X_WO, const core::Twist& V_WO) {
  Body& body = bodies_[static_cast<std::size_t>(index)];
  body.X_WO_target = X_WO;
  if (body.kind == BodyKind::kDynamic || !body.is_placed) body.X_WO = X_WO;
  body.is_placed = true;
  if (body.kind == BodyKind::kDynamic) {
    body.w_W = V_WO.angular_rad_per_s;
    body.v_W = core::PointVelocity(V_WO, X_WO.rotate(body.p_OCm));
  }
}

void Cloth::Rest() {
  std::fill(v_W_.begin(), v_W_.end(), glm::dvec3(0.0));
  for (Body& body : bodies_) body.is_placed = false;
}

void Cloth::SetReleaseForce(int bond, double release_force_N) {
  bonds_[static_cast<std::size_t>(bond)].release_force_N = release_force_N;
}

bool Cloth::IsInside(std::size_t node, const core::Pose& X_OW, const glm::dvec3& lower_O,
                     const glm::dvec3& upper_O) const {
  const glm::dvec3 p_O = X_OW * x_W_[node];
  return is_gripped_[node] == 0 && glm::all(glm::greaterThanEqual(p_O, lower_O)) &&
         glm::all(glm::lessThanEqual(p_O, upper_O));
}

int Cloth::CountInside(int body, const glm::dvec3& lower_O, const glm::dvec3& upper_O) const {
  const core::Pose X_OW = bodies_[static_cast<std::size_t>(body)].X_WO.inverse();
  int count = 0;
  for (std::size_t i = 0; i < x_W_.size(); ++i) count += IsInside(i, X_OW, lower_O, upper_O) ? 1 : 0;
  return count;
}

int Cloth::Grip(const ClothBondParams& params, const glm::dvec3& lower_O, const glm::dvec3& upper_O) {
  Release(params.body);
  const core::Pose X_OW = bodies_[static_cast<std::size_t>(params.body)].X_WO.inverse();
  int count = 0;
  for (std::size_t i = 0; i < x_W_.size(); ++i) {
    if (!IsInside(i, X_OW, lower_O, upper_O) || holds_.size() == num_bonded_ + kMaxGrips) continue;
    const auto node = static_cast<std::uint32_t>(i);
    Hold hold;
    hold.node = {node, node, node, node};
    hold.weight = {1.0, 0.0, 0.0, 0.0};
    hold.body = params.body;
    hold.bond = -1;
    hold.p_O = X_OW * x_W_[i];
    hold.stiffness_N_per_m = params.stiffness_N_per_m;
    hold.damping_N_s_per_m = params.damping_N_s_per_m;
    holds_.push_back(hold);
    is_gripped_[i] = 1;
    ++count;
  }
  return count;
}

void Cloth::Release(int body) {
  std::erase_if(holds_, [&](const Hold& hold) {
    const bool is_mine = hold.bond < 0 && hold.body == body;
    if (is_mine) is_gripped_[hold.node[0]] = 0;
    return is_mine;
  });
}

int Cloth::num_gripped(int body) const {
  return static_cast<int>(std::count_if(holds_.begin(), holds_.end(),
                                        [&](const Hold& hold) { return hold.bond < 0 && hold.body == body; }));
}

void Cloth::Step(double dt_s) {
  StartBodies(dt_s);
  FindContacts(dt_s);
  const double limit_s = grid_.highest_bending_rad_per_s > 0.0
                             ? std::min(params_.max_substep_s, kBendingStepLimit / grid_.highest_bending_rad_per_s)
                             : params_.max_substep_s;
  const int num_substeps = std::max(1, static_cast<int>(std::ceil(dt_s / limit_s - 1e-9)));
  for (int i = 0; i < num_substeps; ++i) Substep(dt_s / num_substeps);
  for (Body& body : bodies_) {
    if (body.kind == BodyKind::kKinematic) body.X_WO = body.X_WO_target;
  }
  CountHolds();
  Damp(dt_s);
}

void Cloth::StartBodies(double dt_s) {
  for (Body& body : bodies_) {
    body.impulse_Ns = glm::dvec3(0.0);
    body.moment_Nms = glm::dvec3(0.0);
    body.duration_s = dt_s;
    body.p_WCm = body.X_WO * body.p_OCm;
    if (body.kind == BodyKind::kKinematic) {
      body.v_W = (body.X_WO_target.translation - body.X_WO.translation) / dt_s;
      body.w_W = core::RotationVector(body.X_WO_target.rotation * glm::conjugate(body.X_WO.rotation)) / dt_s;
    } else if (body.kind == BodyKind::kDynamic) {
      const glm::dmat3 R_WO = RotationMatrix(body.X_WO.rotation);
      body.inverse_inertia_W = R_WO * glm::inverse(body.I_Cm_O) * glm::transpose(R_WO);
    }
  }
  for (Bond& bond : bonds_) bond.impulse_Ns = glm::dvec3(0.0);
}

void Cloth::MoveBodies(double h_s) {
  for (Body& body : bodies_) {
    if (body.kind == BodyKind::kFixed) continue;
    const double angle = glm::length(body.w_W) * h_s;
    if (angle > 0.0) {
      body.X_WO.rotation = glm::normalize(glm::angleAxis(angle, glm::normalize(body.w_W)) * body.X_WO.rotation);
    }
    body.p_WCm += h_s * body.v_W;
    body.X_WO.translation = body.p_WCm - body.X_WO.rotate(body.p_OCm);
  }
}

void Cloth::PushBody(Body* body, const glm::dvec3& p_W, const glm::dvec3& impulse_W) {
  body->impulse_Ns += impulse_W;
  body->moment_Nms += glm::cross(p_W, impulse_W);
  if (body->kind != BodyKind::kDynamic) return;
  body->v_W += body->inverse_mass * impulse_W;
  body->w_W += body->inverse_inertia_W * glm::cross(p_W - body->p_WCm, impulse_W);
}

// One substep: all impulses act at the positions of its start, then everything moves with the new velocities.
void Cloth::Substep(double h_s) {
  if (params_.acceleration_W != glm::dvec3(0.0)) {
    for (std::size_t i = 0; i < v_W_.size(); ++i) {
      v_W_[i] += h_s * params_.acceleration_W;
    }
  }
  ApplyBending(h_s);
  PrepareSprings(h_s);
  PrepareHolds();
  PrepareContacts();
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    SolveSprings();
    SolveHolds(h_s);
    SolveContacts(h_s);
  }
  for (const Hold& hold : holds_) {
    if (hold.is_active && hold.bond >= 0) bonds_[static_cast<std::size_t>(hold.bond)].impulse_Ns -= hold.impulse_Ns;
  }
  for (std::size_t i = 0; i < x_W_.size(); ++i) x_W_[i] += h_s * v_W_[i];
  for (Contact& contact : contacts_) {
    const Body& body = bodies_[static_cast<std::size_t>(contact.body)];
    const glm::dvec3 p_W = x_W_[contact.node] - h_s * v_W_[contact.node];
    const glm::dvec3 v_W = v_W_[contact.node] - body.v_W - glm::cross(body.w_W, p_W - body.p_WCm);
    contact.gap_m += h_s * glm::dot(contact.normal_W, v_W);
  }
  MoveBodies(h_s);
}

// Forces -c g_k (sum of g_l x_l) of bending, explicit: they are soft, and at the positions of the start they have no
// moment.
void Cloth::ApplyBending(double h_s) {
  for (const ClothGrid::Bend& bend : grid_.bends) {
    const glm::dvec3 curl = bend.weight[0] * x_W_[bend.node[0]] + bend.weight[1] * x_W_[bend.node[1]] +
                            bend.weight[2] * x_W_[bend.node[2]] + bend.weight[3] * x_W_[bend.node[3]];
    const glm::dvec3 impulse = (-h_s * bend.stiffness_N_per_m) * curl;
    for (std::size_t k = 0; k < 4; ++k) {
      v_W_[bend.node[k]] += (bend.weight[k] * inverse_mass_[bend.node[k]]) * impulse;
    }
  }
}

// A spring is a soft row (physics/row.hpp): F = F0 - k h v' along its direction at the start. With w the mobility and
// the impulse l = h F, v' = v + w (l - l_before): l = (h F0 - s v + s w l_before) / (1 + s w), s = h (k h).
void Cloth::PrepareSprings(double h_s) {
  if (h_s != spring_h_s_) {
    spring_h_s_ = h_s;
    for (std::size_t i = 0; i < grid_.springs.size(); ++i) {
      const ClothGrid::Spring& spring = grid_.springs[i];
      SpringState& s = spring_states_[i];
      const double mobility = inverse_mass_[spring.a] + inverse_mass_[spring.b];
      const double slope = h_s * h_s * spring.stiffness_N_per_m;
      s.per_speed = -slope / (1.0 + slope * mobility);
      s.per_impulse = slope * mobility / (1.0 + slope * mobility);
    }
  }
  for (std::size_t i = 0; i < grid_.springs.size(); ++i) {
    const ClothGrid::Spring& spring = grid_.springs[i];
    SpringState& s = spring_states_[i];
    const glm::dvec3 line = x_W_[spring.b] - x_W_[spring.a];
    const double length = std::sqrt(glm::dot(line, line));
    s.direction_W = length > 0.0 ? line / length : glm::dvec3(0.0);
    // h F0 / (1 + s w), by s = h^2 k.
    s.target_Ns = s.per_speed / h_s * (length - spring.rest_m);
    // Warm start.
    const glm::dvec3 impulse = s.impulse_Ns * s.direction_W;
    v_W_[spring.b] += inverse_mass_[spring.b] * impulse;
    v_W_[spring.a] -= inverse_mass_[spring.a] * impulse;
  }
}

void Cloth::SolveSprings() {
  for (std::size_t i = 0; i < grid_.springs.size(); ++i) {
    const ClothGrid::Spring& spring = grid_.springs[i];
    SpringState& s = spring_states_[i];
    const double speed = glm::dot(s.direction_W, v_W_[spring.b] - v_W_[spring.a]);
    const double total = s.target_Ns + s.per_speed * speed + s.per_impulse * s.impulse_Ns;
    const glm::dvec3 change = (total - s.impulse_Ns) * s.direction_W;
    s.impulse_Ns = total;
    v_W_[spring.b] += inverse_mass_[spring.b] * change;
    v_W_[spring.a] -= inverse_mass_[spring.a] * change;
  }
}

void Cloth::PrepareHolds() {
  for (Hold& hold : holds_) {
    if (!hold.is_active) continue;
    const Body& body = bodies_[static_cast<std::size_t>(hold.body)];
    hold.p_W = glm::dvec3(0.0);
    double mobility = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      hold.p_W += hold.weight[k] * x_W_[hold.node[k]];
      mobility += hold.weight[k] * hold.weight[k] * inverse_mass_[hold.node[k]];
    }
    hold.force_N = -hold.stiffness_N_per_m * (hold.p_W - body.X_WO * hold.p_O);
    hold.impulse_Ns = glm::dvec3(0.0);
    if (hold.bond >= 0) {
      Bond& bond = bonds_[static_cast<std::size_t>(hold.bond)];
      if (glm::dot(hold.force_N, hold.force_N) > bond.release_force_N * bond.release_force_N) {
        hold.is_active = false;
        --bond.num_held;
        continue;
      }
    }
    hold.mobility = glm::dvec3(mobility);
    if (body.kind == BodyKind::kDynamic) {
      const glm::dvec3 r_W = hold.p_W - body.p_WCm;
      for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 e(0.0);
        e[axis] = 1.0;
        const glm::dvec3 lever = glm::cross(r_W, e);
        hold.mobility[axis] += body.inverse_mass + glm::dot(lever, body.inverse_inertia_W * lever);
      }
    }
  }
}

// The three axes of a hold are rows of their own. The impulse acts on both sides at the sheet's point.
void Cloth::SolveHolds(double h_s) {
  for (Hold& hold : holds_) {
    if (!hold.is_active) continue;
    Body& body = bodies_[static_cast<std::size_t>(hold.body)];
    const double slope = h_s * (h_s * hold.stiffness_N_per_m + hold.damping_N_s_per_m);
    glm::dvec3 v_W = -body.v_W - glm::cross(body.w_W, hold.p_W - body.p_WCm);
    for (std::size_t k = 0; k < 4; ++k) v_W += hold.weight[k] * v_W_[hold.node[k]];
    const glm::dvec3 total = (h_s * hold.force_N - slope * (v_W - hold.mobility * hold.impulse_Ns)) /
                             (glm::dvec3(1.0) + slope * hold.mobility);
    const glm::dvec3 change = total - hold.impulse_Ns;
    hold.impulse_Ns = total;
    for (std::size_t k = 0; k < 4; ++k) {
      if (hold.weight[k] == 0.0) continue;
      v_W_[hold.node[k]] += (hold.weight[k] * inverse_mass_[hold.node[k]]) * change;
    }
    PushBody(&body, hold.p_W, -change);
  }
}

void Cloth::PrepareContacts() {
  for (Contact& contact : contacts_) {
    const Body& body = bodies_[static_cast<std::size_t>(contact.body)];
    contact.mobility = inverse_mass_[contact.node];
    if (body.kind == BodyKind::kDynamic) {
      const glm::dvec3 lever = glm::cross(x_W_[contact.node] - body.p_WCm, contact.normal_W);
      contact.mobility += body.inverse_mass + glm::dot(lever, body.inverse_inertia_W * lever);
    }
    contact.push_Ns = 0.0;
    contact.friction_Ns = glm::dvec3(0.0);
  }
}

// Hard rows: apart by g, a node may close at g / h at most; too near, it leaves at a speed that is bounded. Coulomb
// friction takes out the speed along the surface, up to its cone.
void Cloth::SolveContacts(double h_s) {
  for (Contact& contact : contacts_) {
    Body& body = bodies_[static_cast<std::size_t>(contact.body)];
    const glm::dvec3 p_W = x_W_[contact.node];
    const glm::dvec3 v_W = v_W_[contact.node] - body.v_W - glm::cross(body.w_W, p_W - body.p_WCm);
    const double allowed =
        contact.gap_m >= 0.0 ? -contact.gap_m / h_s : std::min(-contact.gap_m / h_s, kRecovery_m_per_s);
    const double push = std::max(0.0, contact.push_Ns + (allowed - glm::dot(contact.normal_W, v_W)) / contact.mobility);
    glm::dvec3 change = (push - contact.push_Ns) * contact.normal_W;
    contact.push_Ns = push;
    if (push > 0.0 || contact.friction_Ns != glm::dvec3(0.0)) {
      const glm::dvec3 slide_W = v_W - glm::dot(contact.normal_W, v_W) * contact.normal_W;
      glm::dvec3 friction = contact.friction_Ns - slide_W / contact.mobility;
      friction -= glm::dot(contact.normal_W, friction) * contact.normal_W;
      const double size = glm::length(friction);
      const double limit = params_.friction * push;
      if (size > limit) friction *= limit / size;
      change += friction - contact.friction_Ns;
      contact.friction_Ns = friction;
    }
    v_W_[contact.node] += inverse_mass_[contact.node] * change;
    PushBody(&body, p_W, -change);
  }
}

void Cloth::FindContacts(double dt_s) {
  contacts_.clear();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (bodies_[i].shape != nullptr) TouchBody(static_cast<int>(i), dt_s);
  }
}

// Contact planes of one body, which hold for this step: where a node's clearance can be used up by its motion.
void Cloth::TouchBody(int index, double dt_s) {
  const Body& body = bodies_[static_cast<std::size_t>(index)];
  const ClothShape& shape = *body.shape;
  const glm::dvec3 centre_W = body.X_WO * shape.centre_O();
  const core::Pose X_OW = body.X_WO.inverse();
  const double radius_m = 0.5 * params_.thickness_m;
  for (std::size_t i = 0; i < x_W_.size(); ++i) {
    if (is_gripped_[i] != 0 && body.kind == BodyKind::kKinematic) continue;
    const glm::dvec3 v_W = v_W_[i] - body.v_W - glm::cross(body.w_W, x_W_[i] - body.p_WCm);
    const double reach_m = radius_m + kLookAhead_m + 1.5 * dt_s * std::sqrt(glm::dot(v_W, v_W));
    const glm::dvec3 to = x_W_[i] - centre_W;
    const double limit_m = shape.radius_m() + reach_m;
    if (glm::dot(to, to) > limit_m * limit_m) continue;
    glm::dvec3 gradient_O(0.0);
    const double distance_m = shape.Distance(X_OW * x_W_[i], &gradient_O);
    if (distance_m > reach_m) continue;
    if (contacts_.size() == contacts_.capacity()) return;
    Contact contact;
    contact.node = static_cast<std::uint32_t>(i);
    contact.body = index;
    contact.normal_W = body.X_WO.rotate(gradient_O);
    contact.gap_m = distance_m - radius_m;
    contacts_.push_back(contact);
  }
}

Cloth::RigidMotion Cloth::FitRigidMotion() const {
  RigidMotion motion;
  for (std::size_t i = 0; i < x_W_.size(); ++i) {
    motion.p_WCm += grid_.mass_kg[i] * x_W_[i];
    motion.v_W += grid_.mass_kg[i] * v_W_[i];
  }
  motion.p_WCm /= mass_kg_;
  motion.v_W /= mass_kg_;
  glm::dvec3 spin(0.0);
  for (std::size_t i = 0; i < x_W_.size(); ++i) {
    const glm::dvec3 r = x_W_[i] - motion.p_WCm;
    spin += grid_.mass_kg[i] * glm::cross(r, v_W_[i]);
    motion.inertia_W += grid_.mass_kg[i] * (glm::dot(r, r) * glm::dmat3(1.0) - glm::outerProduct(r, r));
  }
  motion.w_W = glm::inverse(motion.inertia_W) * spin;
  return motion;
}

void Cloth::CountHolds() {
  num_holding_ = 0;
  for (Body& body : bodies_) body.share = 0.0;
  for (const Hold& hold : holds_) num_holding_ += hold.is_active ? 1 : 0;
  for (const Hold& hold : holds_) {
    if (hold.is_active) bodies_[static_cast<std::size_t>(hold.body)].share += 1.0 / num_holding_;
  }
}

// Loss inside the sheet, as a drag on the motion relative to what holds it: to the mean motion of the bodies that it
// hangs on, which get the opposite, or to its own rigid motion when it is free. Either way momentum is kept.
void Cloth::Damp(double dt_s) {
  const double loss = -std::expm1(-params_.damping_per_s * dt_s);
  if (loss == 0.0) return;
  if (num_holding_ == 0) {
    ScaleInnerMotion(FitRigidMotion(), 1.0 - loss);
    return;
  }
  for (std::size_t i = 0; i < x_W_.size(); ++i) {
    glm::dvec3 holder_W(0.0);
    for (const Body& body : bodies_) {
      if (body.share == 0.0) continue;
      holder_W += body.share * (body.v_W + glm::cross(body.w_W, x_W_[i] - body.p_WCm));
    }
    const glm::dvec3 change = -loss * (v_W_[i] - holder_W);
    const glm::dvec3 impulse = grid_.mass_kg[i] * change;
    v_W_[i] += change;
    for (Body& body : bodies_) {
      if (body.share == 0.0) continue;
      body.impulse_Ns -= body.share * impulse;
      body.moment_Nms -= body.share * glm::cross(x_W_[i], impulse);
    }
  }
}

void Cloth::ScaleInnerMotion(const RigidMotion& rigid, double scale) {
  for (std::size_t i = 0; i < x_W_.size(); ++i) {
    const glm::dvec3 rigid_v = rigid.v_W + glm::cross(rigid.w_W, x_W_[i] - rigid.p_WCm);
    v_W_[i] = rigid_v + scale * (v_W_[i] - rigid_v);
  }
}

int Cloth::held(int bond) const {
  return bonds_[static_cast<std::size_t>(bond)].num_held;
}

core::Wrench Cloth::MeanWrenchOn(int index, const glm::dvec3& p_W) const {
  const Body& body = bodies_[static_cast<std::size_t>(index)];
  if (body.duration_s <= 0.0) return {};
  return {body.impulse_Ns / body.duration_s, (body.moment_Nms - glm::cross(p_W, body.impulse_Ns)) / body.duration_s};
}

glm::dvec3 Cloth::BondForce_W(int index) const {
  const Bond& bond = bonds_[static_cast<std::size_t>(index)];
  const double duration_s = bodies_[static_cast<std::size_t>(bond.body)].duration_s;
  return duration_s > 0.0 ? bond.impulse_Ns / duration_s : glm::dvec3(0.0);
}

glm::dvec3 Cloth::momentum_Ns() const {
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < v_W_.size(); ++i) sum += grid_.mass_kg[i] * v_W_[i];
  return sum;
}

glm::dvec3 Cloth::angular_momentum_Nms() const {
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < v_W_.size(); ++i) sum += grid_.mass_kg[i] * glm::cross(x_W_[i], v_W_[i]);
  return sum;
}

double Cloth::kinetic_J() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < v_W_.size(); ++i) sum += 0.5 * grid_.mass_kg[i] * glm::dot(v_W_[i], v_W_[i]);
  return sum;
}

double Cloth::elastic_J() const {
  double sum = 0.0;
  for (const ClothGrid::Spring& spring : grid_.springs) {
    const glm::dvec3 line = x_W_[spring.b] - x_W_[spring.a];
    const double stretch = std::sqrt(glm::dot(line, line)) - spring.rest_m;
    sum += 0.5 * spring.stiffness_N_per_m * stretch * stretch;
  }
  for (const ClothGrid::Bend& bend : grid_.bends) {
    glm::dvec3 curl(0.0);
    for (std::size_t k = 0; k < 4; ++k) curl += bend.weight[k] * x_W_[bend.node[k]];
    sum += 0.5 * bend.stiffness_N_per_m * glm::dot(curl, curl);
  }
  return sum;
}

double Cloth::energy_J() const {
  return kinetic_J() + elastic_J();
}

void Cloth::ExchangeState(Checkpoint* checkpoint) {
  for (glm::dvec3& x : x_W_) checkpoint->Exchange(&x);
  for (glm::dvec3& v : v_W_) checkpoint->Exchange(&v);
  for (SpringState& s : spring_states_) checkpoint->Exchange(&s.impulse_Ns);
  // Room for all grips, so that a checkpoint is of one size.
  std::size_t num_holds = holds_.size();
  checkpoint->Exchange(&num_holds);
  const std::size_t most = num_bonded_ + kMaxGrips;
  holds_.resize(most);
  for (Hold& hold : holds_) checkpoint->Exchange(&hold);
  holds_.resize(std::min(num_holds, most));
  for (Bond& bond : bonds_) checkpoint->Exchange(&bond);
  for (std::uint8_t& flag : is_gripped_) checkpoint->Exchange(&flag);
  for (Body& body : bodies_) {
    checkpoint->Exchange(&body.X_WO);
    checkpoint->Exchange(&body.X_WO_target);
    checkpoint->Exchange(&body.is_placed);
    checkpoint->Exchange(&body.v_W);
    checkpoint->Exchange(&body.w_W);
    checkpoint->Exchange(&body.impulse_Ns);
    checkpoint->Exchange(&body.moment_Nms);
    checkpoint->Exchange(&body.duration_s);
  }
}

std::uint64_t Cloth::StateHash() const {
  const std::uint64_t hash = core::Hash64(x_W_.data(), x_W_.size() * sizeof(glm::dvec3));
  return core::Hash64(v_W_.data(), v_W_.size() * sizeof(glm::dvec3), hash);
}

}  // namespace physics

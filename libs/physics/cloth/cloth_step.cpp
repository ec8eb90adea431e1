// The step of a sheet: substeps with springs, holds and contacts, then internal damping.

#include <algorithm>
#include <cmath>

#include "physics/cloth/cloth.hpp"

namespace physics {
namespace {

// The first two are chosen without a study: a larger look-ahead finds contacts of faster turns and costs time; a faster
// recovery leaves more motion behind.
constexpr double kLookAhead_m = 0.001;      // beyond the distance that a node can move in one step
constexpr double kRecovery_m_per_s = 0.25;  // speed at which a penetrating node is moved out
// Largest omega h of bending: the symplectic Euler step is stable up to 2; 1.4 leaves a margin, as omega is a bound for
// bending alone.
constexpr double kBendingStepLimit = 1.4;
// Gauss-Seidel sweeps per substep, warm started. cloth_test holds the stiffness to 1 % with 2; more cost time in
// proportion (`oos bench physics --pair cloth`).
constexpr int kSweeps = 2;

glm::dmat3 RotationMatrix(const glm::dquat& q) {
  return glm::mat3_cast(q);
}

}  // namespace

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

// One substep of the symplectic Euler method: all impulses act at the positions x of its start, then x' = x + h v'.
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

// Bending energy E = c |sum_l g_l x_l|^2 / 2 gives the force -c g_k sum_l g_l x_l on node k. It is explicit: soft, with
// zero moment at the positions of the start.
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

// A spring is a soft row (physics/row.hpp), F = F0 - k h v' along its direction at the start, F0 = -k (length - rest)
// [N]. With the row's inverse effective mass w [1/kg], impulse l = h F [N s] and v' = v + w (l - l_before):
//   l = (h F0 - s v + s w l_before) / (1 + s w),   s = h^2 k [kg].
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
    // h F0 / (1 + s w) = per_speed / h * (length - rest), by s = h^2 k.
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

// Each axis of a hold is a soft row like a spring's, with s = h (h k + d). The impulse acts on both sides at the
// sheet's point.
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

// Hard rows for the normal speed v_n at the end of the substep: v_n >= -g / h for a gap g >= 0, and v_n >= min(-g / h,
// recovery speed) for g < 0. Coulomb friction removes the tangential speed up to the cone |friction| <= mu push.
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
    if (bodies_[i].shape != nullptr) FindContactsWith(static_cast<int>(i), dt_s);
  }
}

// Finds the contact planes with one body for this step: nodes whose motion, with a margin of 50 %, can reach it.
void Cloth::FindContactsWith(int index, double dt_s) {
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

// Internal damping with rate d [1/s]: v <- v_ref + exp(-d dt) (v - v_ref). v_ref is the mean motion of the bodies that
// hold the sheet, which receive the opposite impulses, or the sheet's own rigid motion when it is free; so momentum is
// kept.
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

}  // namespace physics

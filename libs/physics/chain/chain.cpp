#include "physics/chain/chain.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace physics {
namespace {

bool IsFinite(const core::Pose& X) {
  return std::isfinite(glm::dot(X.translation, X.translation)) &&
         std::abs(glm::dot(X.rotation, X.rotation) - 1.0) < 1e-6;
}

core::Pose JointMotion(const ChainLink& link, double position) {
  if (link.is_prismatic) return {glm::dquat(1.0, 0.0, 0.0, 0.0), {0.0, 0.0, position}};
  return {glm::dquat(std::cos(0.5 * position), 0.0, 0.0, std::sin(0.5 * position)), glm::dvec3(0.0)};
}

}  // namespace

core::Result<Chain> Chain::Create(std::vector<ChainLink> links, std::optional<MassProperties> base) {
  const auto refuse = [](std::size_t i, const char* why) {
    return core::Fail(core::ErrorCode::kInvalidInput, "link " + std::to_string(i) + ": " + why);
  };
  for (std::size_t i = 0; i < links.size(); ++i) {
    const ChainLink& link = links[i];
    if (link.parent >= static_cast<int>(i) || link.parent < -1) {
      return refuse(i, "its parent does not come before it; order links from the base outwards");
    }
    if (!IsPhysical(link.mass)) {
      return refuse(i, "mass or inertia is not that of a real body; moments must satisfy the triangle inequality");
    }
    if (!IsFinite(link.X_PJ)) return refuse(i, "pose of its joint is not finite");
    if (!(link.lower < link.upper)) return refuse(i, "lower limit is not below the upper one");
    if (!(link.damping >= 0.0) || !(link.rotor_kg_m2 >= 0.0)) return refuse(i, "damping or rotor inertia is negative");
  }
  if (base && !IsPhysical(*base)) {
    return core::Fail(core::ErrorCode::kInvalidInput, "base: mass or inertia is not that of a real body");
  }
  Chain chain;
  chain.links_ = std::move(links);
  chain.base_ = base;
  chain.works_.resize(chain.links_.size());
  for (ChainState& stage : chain.stages_) stage = chain.MakeState();
  chain.mean_ = chain.MakeState();
  for (ChainAcceleration& a : chain.accelerations_) a.joint.resize(chain.links_.size());
  chain.unit_.resize(chain.links_.size());
  return chain;
}

ChainState Chain::MakeState() const {
  ChainState state;
  state.position.resize(links_.size());
  state.speed.resize(links_.size());
  return state;
}

core::Twist Chain::V_WL(std::size_t i) const {
  const Work& w = works_[i];
  return {w.v.angular, w.v.linear + glm::cross(w.v.angular, w.X_WL.translation - origin_W_)};
}

SpatialInertia Chain::InertiaOf(const MassProperties& mass, const core::Pose& X_WL, const glm::dvec3& origin_W) {
  const glm::dmat3 R = glm::mat3_cast(X_WL.rotation);
  return RigidInertia(mass.mass_kg, X_WL * mass.p_OCm_m - origin_W, R * mass.I_Cm_O_kg_m2 * glm::transpose(R));
}

void Chain::Place(const ChainState& state) {
  origin_W_ = state.X_WB.translation;
  v_base_ = {};
  if (base_) {
    v_base_ = {state.V_WB.angular_rad_per_s, state.V_WB.linear_m_per_s};
    I_base_ = InertiaOf(*base_, state.X_WB, origin_W_);
  }
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const ChainLink& link = links_[i];
    Work& w = works_[i];
    const Work* parent = link.parent < 0 ? nullptr : &works_[static_cast<std::size_t>(link.parent)];
    w.X_WL = (parent != nullptr ? parent->X_WL : state.X_WB) * link.X_PJ * JointMotion(link, state.position[i]);
    const glm::dvec3 z_W = w.X_WL.rotate({0.0, 0.0, 1.0});
    if (link.is_prismatic) {
      w.S = {glm::dvec3(0.0), z_W};
    } else {
      w.S = {z_W, glm::cross(w.X_WL.translation - origin_W_, z_W)};
    }
    const Motion joint = state.speed[i] * w.S;
    w.v = (parent != nullptr ? parent->v : v_base_) + joint;
    w.c = Cross(w.v, joint);
    w.I = InertiaOf(link.mass, w.X_WL, origin_W_);
  }
}

// Articulated-body algorithm [Featherstone 2008, Table 7.1, floating base of Table 9.4]. For each link, from the tips
// to the base, with joint axis S, rigid inertia I, velocity v, joint force tau [N or Nm], rotor inertia J_r and damping
// d:
//   pA = v x* I v - F_ext,   U = IA S,   D = S.U + J_r,   u = tau - d q' - S.pA,
//   Ia = IA - U U^T / D,     pa = pA + Ia c + U u / D,   added to IA and pA of the parent;
// then from the base to the tips, a' = a_parent + c, q'' = (u - U.a') / D, a = a' + S q''. All spatial quantities are
// about the current position of the base's origin, a point at rest in W.
void Chain::Accelerate(const ChainState& state, std::span<const double> force, std::span<const core::Wrench> F_Lo_W,
                       ChainAcceleration* acceleration) {
  Place(state);
  for (std::size_t i = 0; i < links_.size(); ++i) {
    Work& w = works_[i];
    w.IA = w.I;
    w.pA = Cross(w.v, w.I * w.v);
    if (!F_Lo_W.empty()) {
      const glm::dvec3 r = w.X_WL.translation - origin_W_;
      w.pA = w.pA - Force{F_Lo_W[i].torque_Nm + glm::cross(r, F_Lo_W[i].force_N), F_Lo_W[i].force_N};
    }
  }
  SpatialInertia IA_base = I_base_;
  Force pA_base = Cross(v_base_, I_base_ * v_base_);
  for (std::size_t i = links_.size(); i-- > 0;) {
    Work& w = works_[i];
    w.U = w.IA * w.S;
    w.D = Dot(w.S, w.U) + links_[i].rotor_kg_m2;
    w.u = force[i] - links_[i].damping * state.speed[i] - Dot(w.S, w.pA);
    const bool is_on_base = links_[i].parent < 0;
    if (is_on_base && !base_) continue;
    SpatialInertia Ia = w.IA;
    Ia.Subtract(w.U, w.D);
    const Force pa = w.pA + Ia * w.c + (w.u / w.D) * w.U;
    Work* parent = is_on_base ? nullptr : &works_[static_cast<std::size_t>(links_[i].parent)];
    (is_on_base ? IA_base : parent->IA) += Ia;
    Force& p = is_on_base ? pA_base : parent->pA;
    p = p + pa;
  }
  Motion a_base;
  if (base_) a_base = Solve(IA_base, -1.0 * pA_base);
  for (std::size_t i = 0; i < links_.size(); ++i) {
    Work& w = works_[i];
    const int parent = links_[i].parent;
    const Motion a = (parent < 0 ? a_base : works_[static_cast<std::size_t>(parent)].a) + w.c;
    acceleration->joint[i] = (w.u - Dot(a, w.U)) / w.D;
    w.a = a + acceleration->joint[i] * w.S;
  }
  acceleration->base_angular_W = a_base.angular;
  // The spatial acceleration is that at a fixed place. The acceleration of the base's origin has w x v in addition.
  acceleration->base_linear_W = a_base.linear + glm::cross(v_base_.angular, v_base_.linear);
}

// Computes to = from + dt * rates, with the speeds of `rate_state` and these accelerations.
void Chain::Move(const ChainState& from, const ChainState& rate_state, const ChainAcceleration& acceleration,
                 double dt_s, ChainState* to) const {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    to->position[i] = from.position[i] + dt_s * rate_state.speed[i];
    to->speed[i] = from.speed[i] + dt_s * acceleration.joint[i];
  }
  to->X_WB = from.X_WB;
  to->V_WB = from.V_WB;
  if (!base_) return;
  to->X_WB.translation = from.X_WB.translation + dt_s * rate_state.V_WB.linear_m_per_s;
  // Rate of a unit quaternion: q' = (0, w) q / 2.
  const glm::dvec3& w = rate_state.V_WB.angular_rad_per_s;
  const glm::dquat rate = 0.5 * (glm::dquat(0.0, w.x, w.y, w.z) * rate_state.X_WB.rotation);
  to->X_WB.rotation = from.X_WB.rotation + dt_s * rate;
  to->V_WB.angular_rad_per_s = from.V_WB.angular_rad_per_s + dt_s * acceleration.base_angular_W;
  to->V_WB.linear_m_per_s = from.V_WB.linear_m_per_s + dt_s * acceleration.base_linear_W;
}

void Chain::Step(double dt_s, std::span<const double> force, std::span<const core::Wrench> F_Lo_W, ChainState* state) {
  const auto normalized = [](ChainState* s) { s->X_WB.rotation = glm::normalize(s->X_WB.rotation); };
  Accelerate(*state, force, F_Lo_W, &accelerations_[0]);
  Move(*state, *state, accelerations_[0], 0.5 * dt_s, &stages_[0]);
  Accelerate(stages_[0], force, F_Lo_W, &accelerations_[1]);
  Move(*state, stages_[0], accelerations_[1], 0.5 * dt_s, &stages_[1]);
  Accelerate(stages_[1], force, F_Lo_W, &accelerations_[2]);
  Move(*state, stages_[1], accelerations_[2], dt_s, &stages_[2]);
  Accelerate(stages_[2], force, F_Lo_W, &accelerations_[3]);
  // Runge-Kutta: x(t + h) = x + h (k1 + 2 k2 + 2 k3 + k4) / 6.
  const double shares[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
  mean_ = *state;
  for (int i = 0; i < 4; ++i) {
    const ChainState& rates = i == 0 ? *state : stages_[i - 1];
    Move(mean_, rates, accelerations_[i], shares[i] * dt_s, &mean_);
  }
  normalized(&mean_);
  std::swap(*state, mean_);
  StopAtLimits(state);
}

// An impulse lambda on joint k changes the speeds by M^-1 e_k lambda; lambda = -q'_k / (M^-1)_kk stops joint k. The
// column M^-1 e_k is the acceleration of the chain at rest under a unit force on joint k. Stopping one joint may set
// another in motion, so this repeats; 20 rounds bound the time, and chains in use need one or two.
void Chain::StopAtLimits(ChainState* state) {
  const auto is_beyond = [&](std::size_t k) {
    return (state->position[k] <= links_[k].lower && state->speed[k] < 0.0) ||
           (state->position[k] >= links_[k].upper && state->speed[k] > 0.0);
  };
  for (int round = 0; round < 20; ++round) {
    bool any = false;
    for (std::size_t k = 0; k < links_.size(); ++k) {
      if (!is_beyond(k)) continue;
      any = true;
      mean_ = *state;
      std::fill(mean_.speed.begin(), mean_.speed.end(), 0.0);
      mean_.V_WB = {};
      std::fill(unit_.begin(), unit_.end(), 0.0);
      unit_[k] = 1.0;
      Accelerate(mean_, unit_, {}, &accelerations_[0]);
      const ChainAcceleration& column = accelerations_[0];
      const double impulse = -state->speed[k] / column.joint[k];
      for (std::size_t i = 0; i < links_.size(); ++i) state->speed[i] += impulse * column.joint[i];
      state->speed[k] = 0.0;
      state->V_WB.angular_rad_per_s += impulse * column.base_angular_W;
      state->V_WB.linear_m_per_s += impulse * column.base_linear_W;
    }
    if (!any) break;
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {
    state->position[k] = std::clamp(state->position[k], links_[k].lower, links_[k].upper);
  }
}

double Chain::KineticEnergy_J(const ChainState& state) {
  Place(state);
  double energy_J = 0.0;
  if (base_) energy_J += 0.5 * Dot(v_base_, I_base_ * v_base_);
  for (std::size_t i = 0; i < links_.size(); ++i) {
    energy_J += 0.5 * Dot(works_[i].v, works_[i].I * works_[i].v) +
                0.5 * links_[i].rotor_kg_m2 * state.speed[i] * state.speed[i];
  }
  return energy_J;
}

Force Chain::Momentum(const ChainState& state) {
  Place(state);
  Force sum;
  if (base_) sum = I_base_ * v_base_;
  for (const Work& w : works_) sum = sum + w.I * w.v;
  sum.torque += glm::cross(origin_W_, sum.force);
  return sum;
}

void Chain::Jacobian(std::size_t i, std::span<double> columns) const {
  std::fill(columns.begin(), columns.end(), 0.0);
  const glm::dvec3 r = works_[i].X_WL.translation - origin_W_;
  for (int k = static_cast<int>(i); k >= 0; k = links_[static_cast<std::size_t>(k)].parent) {
    const Motion& S = works_[static_cast<std::size_t>(k)].S;
    const glm::dvec3 linear = S.linear + glm::cross(S.angular, r);
    for (int c = 0; c < 3; ++c) {
      columns[6 * static_cast<std::size_t>(k) + static_cast<std::size_t>(c)] = S.angular[c];
      columns[6 * static_cast<std::size_t>(k) + 3 + static_cast<std::size_t>(c)] = linear[c];
    }
  }
}

}  // namespace physics

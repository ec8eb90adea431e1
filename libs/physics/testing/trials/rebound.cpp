#include "physics/testing/trials/rebound.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <vector>

#include "physics/testing/trials/build.hpp"

namespace physics::trials {
namespace {

struct Observation {
  core::ContactSet planes;
  core::Wrench F_So_W;  // of the same planes as springs, about S's origin
};

// A free body S, the body that it hits, and the result of a contact query at any poses: planes nearer than `reach_m`.
struct Scene {
  World world;
  int body = -1;
  int other = -1;
  std::function<void(const core::Pose& X_WS, const core::Pose& X_WG, double reach_m, Observation*)> observe;
};

struct Point {
  glm::dvec3 p_W, q_W, n_W;
  double stiffness_N_per_m;
};

void AddIfNear(Observation* seen, std::uint32_t id, const core::Pose& X_WS, const core::Pose& X_WG, const Point& at,
               double reach_m) {
  const double gap_m = glm::dot(at.n_W, at.p_W - at.q_W);
  if (gap_m > reach_m) return;
  AddPlane(&seen->planes, id, X_WS.inverse() * at.p_W, X_WG.inverse() * at.q_W, X_WG.inverse().rotate(at.n_W),
           at.stiffness_N_per_m);
  const glm::dvec3 force_W = std::max(0.0, -gap_m) * at.stiffness_N_per_m * at.n_W;
  seen->F_So_W.force_N += force_W;
  seen->F_So_W.torque_Nm += glm::cross(at.p_W - X_WS.translation, force_W);
}

// Vertices of S over the floor z = 0; each has an equal share of the stiffness.
auto VerticesOverFloor(double stiffness, std::vector<glm::dvec3> vertices_S) {
  return [=](const core::Pose& X_WS, const core::Pose& X_WG, double reach_m, Observation* seen) {
    std::uint32_t id = 0;
    for (const glm::dvec3& p_S : vertices_S) {
      const glm::dvec3 p_W = X_WS * p_S;
      AddIfNear(seen, ++id, X_WS, X_WG,
                {p_W, {p_W.x, p_W.y, 0.0}, {0, 0, 1}, stiffness / static_cast<double>(vertices_S.size())}, reach_m);
    }
  };
}

// Ball S of radius r_S over ball G of radius r_G; r_S = 0 is a vertex.
auto BallOverBall(double stiffness, const glm::dvec3& center_S, double r_S, double r_G) {
  return [=](const core::Pose& X_WS, const core::Pose& X_WG, double reach_m, Observation* seen) {
    const glm::dvec3 c_W = X_WS * center_S;
    const glm::dvec3 n_W = glm::normalize(c_W - X_WG.translation);
    AddIfNear(seen, 1, X_WS, X_WG, {c_W - r_S * n_W, X_WG.translation + r_G * n_W, n_W, stiffness}, reach_m);
  };
}

MassProperties BallMass(double mass_kg, double radius_m) {
  MassProperties m;
  m.mass_kg = mass_kg;
  m.I_Cm_O_kg_m2 = glm::dmat3(0.4 * mass_kg * radius_m * radius_m);
  return m;
}

void BallOnFloor(Scene* s, const ReboundParams& p) {
  constexpr double kRadius = 0.03;
  const double spin = p.spin_rad_per_s;
  s->body = AddDynamic(&s->world, {{1, 0, 0, 0}, {0, 0, kRadius + 0.0043}}, BallMass(p.mass_kg, kRadius),
                       {{0.2 * spin, spin, 0.3 * spin}, {0.02, 0, -p.speed_m_per_s}});
  s->other = s->world.world_body();
  s->observe = [k = p.stiffness_N_per_m](const core::Pose& X_WS, const core::Pose& X_WG, double reach_m,
                                         Observation* seen) {
    const glm::dvec3 p_W = X_WS.translation - glm::dvec3(0, 0, kRadius);
    AddIfNear(seen, 1, X_WS, X_WG, {p_W, {p_W.x, p_W.y, 0.0}, {0, 0, 1}, k}, reach_m);
  };
}

void PlateOnFloor(Scene* s, const ReboundParams& p) {
  const double spin = p.spin_rad_per_s;
  s->body = AddDynamic(&s->world, {{1, 0, 0, 0}, {0, 0, 0.0143}}, BoxMass(p.mass_kg, {0.1, 0.08, 0.02}),
                       {{0.2 * spin, 0.3 * spin, spin}, {0.02, 0, -p.speed_m_per_s}});
  s->other = s->world.world_body();
  s->observe = VerticesOverFloor(p.stiffness_N_per_m,
                                 {{.05, .04, -.01}, {.05, -.04, -.01}, {-.05, .04, -.01}, {-.05, -.04, -.01}});
}

// A box that is turned about y falls on its lower edge, off its centre of mass.
void EdgeOnFloor(Scene* s, const ReboundParams& p) {
  const glm::dquat R = core::QuaternionFromRotationVector({0, 1.3, 0});
  const glm::dvec3 lowest = R * glm::dvec3(.05, 0, -.02);
  const double spin = p.spin_rad_per_s;
  s->body = AddDynamic(&s->world, {R, {0, 0, -lowest.z + 0.0043}}, BoxMass(p.mass_kg, {0.1, 0.08, 0.04}),
                       {{0, spin, 0.2 * spin}, {0.02, 0, -p.speed_m_per_s}});
  s->other = s->world.world_body();
  s->observe = VerticesOverFloor(p.stiffness_N_per_m, {{.05, .04, -.02}, {.05, -.04, -.02}});
}

// Two free balls that turn, off centre by a third of the radius.
void TwoBalls(Scene* s, const ReboundParams& p) {
  constexpr double kA = 0.03;
  constexpr double kB = 0.05;
  const double spin = p.spin_rad_per_s;
  s->other = AddDynamic(&s->world, {}, BallMass(3.0 * p.mass_kg, kB), {{0, -0.5 * spin, 0.1}, {}});
  s->body = AddDynamic(&s->world, {{1, 0, 0, 0}, {0.01, 0, kA + kB + 0.0013}}, BallMass(p.mass_kg, kA),
                       {{0, spin, 0}, {0, 0.01, -p.speed_m_per_s}});
  s->observe = BallOverBall(p.stiffness_N_per_m, {}, kA, kB);
}

// A vertex of a box on a free ball as the field.
void VertexOnBall(Scene* s, const ReboundParams& p) {
  const double spin = p.spin_rad_per_s;
  s->other = AddDynamic(&s->world, {}, BallMass(2.0 * p.mass_kg, 0.05), {{0, 0.5 * spin, 0}, {}});
  s->body = AddDynamic(&s->world, {{1, 0, 0, 0}, {0.01, 0, 0.05 + 0.05 + 0.0013}},
                       BoxMass(p.mass_kg, {0.06, 0.06, 0.1}), {{spin, spin, 0}, {0, 0, -p.speed_m_per_s}});
  s->observe = BallOverBall(p.stiffness_N_per_m, {0.01, 0.005, -0.05}, 0.0, 0.05);
}

void Build(const ReboundParams& params, Scene* scene) {
  switch (params.shape) {
    case ReboundShape::kFlat:
      return PlateOnFloor(scene, params);
    case ReboundShape::kEdge:
      return EdgeOnFloor(scene, params);
    case ReboundShape::kBall:
      return BallOnFloor(scene, params);
    case ReboundShape::kBalls:
      return TwoBalls(scene, params);
    case ReboundShape::kVertex:
      return VertexOnBall(scene, params);
  }
}

double Energy_J(const Scene& scene) {
  double energy_J = scene.world.kinetic_energy_J(scene.body);
  if (scene.world.kind(scene.other) == BodyKind::kDynamic) energy_J += scene.world.kinetic_energy_J(scene.other);
  return energy_J;
}

}  // namespace

double ReboundRatio(const ReboundParams& params) {
  Scene scene;
  Build(params, &scene);
  World& world = scene.world;
  const ContactKind kind = params.input == ReboundInput::kHard      ? ContactKind::kHard
                           : params.input == ReboundInput::kPassive ? ContactKind::kPassive
                                                                    : ContactKind::kCompliant;
  const int pair = world.AddContactPair(scene.body, scene.other, kind).value();
  const double before_J = Energy_J(scene);
  const double reach_m = 0.002 + params.speed_m_per_s * (params.delay_ms + 2) * kDt;
  std::deque<Observation> delayed;
  int last_push = -1;
  for (int i = 0; i < 4000; ++i) {
    Observation seen;
    scene.observe(world.X_WO(scene.body), world.X_WO(scene.other), reach_m, &seen);
    delayed.push_back(seen);
    bool is_pushed = false;
    if (static_cast<int>(delayed.size()) > params.delay_ms) {
      const Observation& late = delayed.front();
      world.SetContactPlanes(pair, late.planes);
      if (params.input == ReboundInput::kWrench) world.SetContactWrench(pair, late.F_So_W);
      is_pushed = params.input == ReboundInput::kWrench && glm::length(late.F_So_W.force_N) > 0.0;
      delayed.pop_front();
    }
    world.Step(kDt);
    is_pushed = is_pushed || (params.input != ReboundInput::kWrench && world.contact(pair).num_pushing > 0);
    if (is_pushed) last_push = i;
    // With hard contact the bodies may rest on each other at gap 0: they have parted after 40 ms without a force.
    const bool is_apart = world.SmallestGap_m(pair) > 0.0 || params.input == ReboundInput::kHard;
    if (last_push >= 0 && i - last_push > 40 && is_apart) return std::sqrt(Energy_J(scene) / before_J);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace physics::trials

// Undamped rebounds under delay: total energy after against before, for flat, edge and curved contact with rotation.
#include <cmath>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "physics/test_support.hpp"

namespace physics {
namespace {

using test::kDt;

constexpr double kStiffness_N_per_m = 1.0e4;

// A free body (and another, or the world) with exact geometry that tells the planes at any poses.
struct Rebound {
  World world;
  int body = -1;
  int other = -1;  // a second free body, or the world's
  int pair = -1;
  // Planes at these poses, with all gaps below `reach_m`.
  std::function<void(const core::Pose& X_WS, const core::Pose& X_WG, double reach_m, core::ContactSet*)> look;
  int delay_ticks = 0;
  double speed_m_per_s = 0.1;

  [[nodiscard]] double Energy_J() const {
    double energy = world.kinetic_energy_J(body);
    if (world.kind(other) == BodyKind::kDynamic) energy += world.kinetic_energy_J(other);
    return energy;
  }

  // Root of total energy after over before; the bodies have parted when nothing has pushed for 40 ms.
  double Run() {
    const double before = Energy_J();
    std::deque<core::ContactSet> under_way;
    int last_push = -1;
    for (int i = 0; i < 4000; ++i) {
      core::ContactSet set;
      const double reach = 0.002 + speed_m_per_s * (delay_ticks + 2) * kDt;
      look(world.X_WO(body), world.X_WO(other), reach, &set);
      under_way.push_back(set);
      if (static_cast<int>(under_way.size()) > delay_ticks) {
        world.SetContactPlanes(pair, under_way.front());
        under_way.pop_front();
      }
      world.Step(kDt);
      if (world.contact(pair).num_pushing > 0) last_push = i;
      if (last_push >= 0 && i - last_push > 40 && world.SmallestGap_m(pair) > 0.0) break;
    }
    EXPECT_GE(last_push, 0);
    return std::sqrt(Energy_J() / before);
  }
};

void AddIfNear(core::ContactSet* set, std::uint32_t id, const core::Pose& X_WS, const core::Pose& X_WG,
               const glm::dvec3& p_W, const glm::dvec3& q_W, const glm::dvec3& n_W, double k, double reach) {
  if (glm::dot(n_W, p_W - q_W) > reach) return;
  test::AddPlane(set, id, X_WS.inverse() * p_W, X_WG.inverse() * q_W, X_WG.inverse().rotate(n_W), k);
}

// Vertices of S over the floor z = 0.
auto VerticesOverFloor(std::vector<glm::dvec3> vertices_S) {
  return [vertices_S](const core::Pose& X_WS, const core::Pose& X_WG, double reach, core::ContactSet* set) {
    std::uint32_t id = 0;
    for (const glm::dvec3& p_S : vertices_S) {
      const glm::dvec3 p_W = X_WS * p_S;
      AddIfNear(set, ++id, X_WS, X_WG, p_W, {p_W.x, p_W.y, 0.0}, {0, 0, 1},
                kStiffness_N_per_m / static_cast<double>(vertices_S.size()), reach);
    }
  };
}

// Ball S of radius r_S over ball G of radius r_G; r_S = 0 is a vertex.
auto BallOverBall(const glm::dvec3& center_S, double r_S, double r_G) {
  return [=](const core::Pose& X_WS, const core::Pose& X_WG, double reach, core::ContactSet* set) {
    const glm::dvec3 c_W = X_WS * center_S;
    const glm::dvec3 n_W = glm::normalize(c_W - X_WG.translation);
    AddIfNear(set, 1, X_WS, X_WG, c_W - r_S * n_W, X_WG.translation + r_G * n_W, n_W, kStiffness_N_per_m, reach);
  };
}

void BallOnFloor(Rebound* s, double mass, double spin) {
  constexpr double kRadius = 0.03;
  MassProperties m;
  m.mass_kg = mass;
  m.I_Cm_O_kg_m2 = glm::dmat3(0.4 * mass * kRadius * kRadius);
  s->body = test::AddDynamic(&s->world, {{1, 0, 0, 0}, {0, 0, kRadius + 0.0043}}, m,
                             {{0.2 * spin, spin, 0.3 * spin}, {0.02, 0, -s->speed_m_per_s}});
  s->other = s->world.world_body();
  s->look = [](const core::Pose& X_WS, const core::Pose& X_WG, double reach, core::ContactSet* set) {
    const glm::dvec3 p_W = X_WS.translation - glm::dvec3(0, 0, kRadius);
    AddIfNear(set, 1, X_WS, X_WG, p_W, {p_W.x, p_W.y, 0.0}, {0, 0, 1}, kStiffness_N_per_m, reach);
  };
}

void FlatPlate(Rebound* s, double mass, double spin) {
  s->body = test::AddDynamic(&s->world, {{1, 0, 0, 0}, {0, 0, 0.0143}}, BoxMass(mass, {0.1, 0.08, 0.02}),
                             {{0.2 * spin, 0.3 * spin, spin}, {0.02, 0, -s->speed_m_per_s}});
  s->other = s->world.world_body();
  s->look = VerticesOverFloor({{.05, .04, -.01}, {.05, -.04, -.01}, {-.05, .04, -.01}, {-.05, -.04, -.01}});
}

// A box turned by 45 degrees about y falls on its lower edge, off its centre of mass by 30 degrees more.
void Edge(Rebound* s, double mass, double spin) {
  const double angle = 1.3;
  const glm::dquat R = core::QuaternionFromRotationVector({0, angle, 0});
  const glm::dvec3 lowest = R * glm::dvec3(.05, 0, -.02);
  s->body = test::AddDynamic(&s->world, {R, {0, 0, -lowest.z + 0.0043}}, BoxMass(mass, {0.1, 0.08, 0.04}),
                             {{0, spin, 0.2 * spin}, {0.02, 0, -s->speed_m_per_s}});
  s->other = s->world.world_body();
  s->look = VerticesOverFloor({{.05, .04, -.02}, {.05, -.04, -.02}});
}

// Two free balls that turn, off centre by a third of the radius.
void TwoBalls(Rebound* s, double mass, double spin) {
  constexpr double kA = 0.03;
  constexpr double kB = 0.05;
  const auto ball = [](double m, double r) {
    MassProperties p;
    p.mass_kg = m;
    p.I_Cm_O_kg_m2 = glm::dmat3(0.4 * m * r * r);
    return p;
  };
  s->other = test::AddDynamic(&s->world, {}, ball(3.0 * mass, kB), {{0, -0.5 * spin, 0.1}, {}});
  s->body = test::AddDynamic(&s->world, {{1, 0, 0, 0}, {0.01, 0, kA + kB + 0.0013}}, ball(mass, kA),
                             {{0, spin, 0}, {0, 0.01, -s->speed_m_per_s}});
  s->look = BallOverBall({}, kA, kB);
}

// A vertex of a box on a free ball as the field.
void VertexOnBall(Rebound* s, double mass, double spin) {
  MassProperties m;
  m.mass_kg = 2.0 * mass;
  m.I_Cm_O_kg_m2 = glm::dmat3(0.4 * m.mass_kg * 0.05 * 0.05);
  s->other = test::AddDynamic(&s->world, {}, m, {{0, 0.5 * spin, 0}, {}});
  s->body = test::AddDynamic(&s->world, {{1, 0, 0, 0}, {0.01, 0, 0.05 + 0.05 + 0.0013}},
                             BoxMass(mass, {0.06, 0.06, 0.1}), {{spin, spin, 0}, {0, 0, -s->speed_m_per_s}});
  s->look = BallOverBall({0.01, 0.005, -0.05}, 0.0, 0.05);
}

using Build = void (*)(Rebound*, double, double);

double Ratio(Build build, double mass, double spin, int delay) {
  Rebound scene;
  build(&scene, mass, spin);
  scene.pair = scene.world.AddContactPair(scene.body, scene.other).value();
  scene.delay_ticks = delay;
  return scene.Run();
}

struct Case {
  const char* name;
  Build build;
};
const Case kCases[] = {
    {"flat", FlatPlate}, {"edge", Edge}, {"ball", BallOnFloor}, {"balls", TwoBalls}, {"vertex", VertexOnBall}};

constexpr double kMasses_kg[] = {0.2, 2.0, 20.0};
constexpr int kDelays[] = {0, 1, 3, 7};  // ms

TEST(Rebound, KeepsEnergyWithoutDelayHoweverTheBodiesTurn) {
  for (const Case& c : kCases) {
    for (const double mass : kMasses_kg) {
      for (const double spin : {0.0, 2.0, 10.0}) {
        EXPECT_NEAR(Ratio(c.build, mass, spin, 0), 1.0, 1e-3) << c.name << ", " << mass << " kg, " << spin << " rad/s";
      }
    }
  }
}

TEST(Rebound, StaysWithinTwoPercentUnderDelayOfThePlanes) {
  for (const Case& c : kCases) {
    double least = 1e9;
    double most = 0.0;
    for (const double mass : kMasses_kg) {
      for (const int delay : kDelays) {
        for (const double spin : {0.0, 2.0}) {  // rad/s
          const double ratio = Ratio(c.build, mass, spin, delay);
          least = std::min(least, ratio);
          most = std::max(most, ratio);
          EXPECT_NEAR(ratio, 1.0, 0.02) << c.name << ", " << mass << " kg, " << delay << " ms, " << spin << " rad/s";
        }
      }
    }
    RecordProperty(c.name, std::to_string(least) + " to " + std::to_string(most));
  }
}

}  // namespace
}  // namespace physics

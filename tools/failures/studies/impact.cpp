// F9: fast impact. What is shown of the tool's depth when the device goes on into the wall, and what comes back.
#include <algorithm>
#include <cmath>

#include "tools/failures/for_all.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/oracle/body_distance.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kSpeed_m_per_s = 1.0;

struct Target {
  const char* name;
  vps::TriangleMesh mesh;
  vps::TriangleMesh tool;
  core::Pose X_WE;         // of the target
  glm::dvec3 from_W{0.0};  // of the device
  glm::dvec3 way_W{0.0};   // unit
  bool is_concave = false;
};

std::vector<Target> Targets() {
  const glm::dquat turned = core::QuaternionFromRotationVector({0.0, 0.785398, 0.0});
  return {
      {"wall",
       vps::MakeBox({0.2, 0.2, 0.04}),
       vps::MakeSphere(kBall_m, 32),
       {{1, 0, 0, 0}, {0, 0, -0.02}},
       {0.013, 0.007, 0.1},
       glm::normalize(glm::dvec3(0.2, 0.1, -1.0))},
      {"edge",
       vps::MakeBox({0.06, 0.1, 0.06}),
       vps::MakeSphere(kBall_m, 32),
       {turned, {0, 0, -0.0424264}},
       {0.001, 0.003, 0.1},
       {0, 0, -1}},
      {"slot",
       vps::MakeBlockWithHole(0.06, 0.04, 0.0105, 64),
       vps::MakeCylinder(0.01, 0.05, 64),
       {},
       {0.003, 0.0, 0.09},
       {0, 0, -1},
       true},
  };
}

// Largest depth of the shown tool in the target, exact. `loop`: of this project's nodes, or of a peer.
template <class AnyLoop, class IsInContact>
double DeepestShown_m(const Target& target, AnyLoop& loop, const IsInContact& is_in_contact) {
  const vps::oracle::MeshDistance exact_E(target.mesh);
  const vps::oracle::MeshDistance exact_T(target.tool);
  core::Pose X_WD;
  double deepest = 0.0;
  constexpr int kImpact_cycles = 10;
  int touching = 0;
  constexpr double kWay_m = 0.12;
  const int num_steps = static_cast<int>(std::ceil(kWay_m / (1e-3 * kSpeed_m_per_s)));
  for (int i = 0; i < num_steps; ++i) {
    const double way = 1e-3 * kSpeed_m_per_s * i;
    X_WD.translation = target.from_W + way * target.way_W;
    loop.Tick(X_WD);
    // The exact distance takes milliseconds: each cycle of the impact, then every tenth.
    if (!is_in_contact() || (++touching > kImpact_cycles && touching % 10 != 0)) continue;
    const double distance =
        vps::oracle::SignedBodyDistance(exact_E, exact_T, target.X_WE.inverse() * loop.X_WC()).signed_distance_m;
    deepest = std::max(deepest, -distance);
  }
  return deepest;
}

double ShownDepth_m(const Variant& variant, const Target& target) {
  SceneKit kit(variant);
  const auto field = kit.AddFixed(target.mesh, target.X_WE, 5e-4);
  const auto tool = kit.AddHand(target.tool, {{1, 0, 0, 0}, target.from_W}, kToolPoints);
  kit.AddPair(tool, field);
  Loop loop(kit.scenario);
  return DeepestShown_m(target, loop, [&loop] { return loop.haptic().is_in_contact; });
}

double ShownByPeer_m(const Peer& peer, const Target& target) {
  const auto loop = peer.make_loop(0.0);
  loop->AddFixed(target.mesh, target.X_WE);
  loop->AddTool(target.tool, {{1, 0, 0, 0}, target.from_W});
  return DeepestShown_m(target, *loop, [&loop] { return loop->is_in_contact(); });
}

// Kinetic energy after over before an impact of the arm, that the operator throws at the wall.
double ReboundEnergy(const Variant& variant) {
  SceneKit kit = BallOverPlate(variant, 0.25);
  kit.device().mass_kg = 1.0;
  kit.scenario.coupling.stiffness_N_per_m = 2500.0;
  LoopOptions options;
  options.script = "wait 1.2\npush 0 0 -1 by 0.4 speed 1.0\nwait 600";
  Loop loop(kit.scenario, options);
  double incoming = 0.0;
  double outgoing = 0.0;
  bool has_touched = false;
  while (loop.now_s() < 4.0) {
    loop.Tick();
    const double v = loop.device().V_WD.linear_m_per_s.z;
    has_touched = has_touched || loop.haptic().is_in_contact;
    (has_touched && v > 0.0 ? outgoing : incoming) =
        std::max(has_touched && v > 0.0 ? outgoing : incoming, std::abs(v));
  }
  return has_touched ? outgoing * outgoing / (incoming * incoming) : 1e9;
}

}  // namespace

void StudyImpact(const Peers& peers, Report* report) {
  for (const Target& target : Targets()) {
    Row row{"F9",
            "fast impact",
            std::string("tool at 1 m/s into a ") + target.name + ", voxels of 0.5 mm",
            "depth shown, exact",
            "<= 0.1 mm",
            {},
            "the proxy rests half a voxel inside what it touches, and one linearised step a cycle follows a fast tool"};
    const auto depths_m = OfVariants([&target](const Variant& variant) { return ShownDepth_m(variant, target); });
    for (std::size_t i = 0; i < depths_m.size(); ++i)
      row.readings.push_back({Variants()[i].name, Short(1e3 * depths_m[i]) + " mm", depths_m[i] <= 1e-4});
    for (const Peer& peer : peers) {
      if (target.is_concave && !peer.takes_concave) continue;
      const double depth_m = ShownByPeer_m(peer, target);
      row.readings.push_back({peer.name, Short(1e3 * depth_m) + " mm", depth_m <= 1e-4});
    }
    AddRow(report, row);
  }
  Row row{"F9",
          "fast impact",
          "arm of 1 kg thrown at the wall with up to 1 m/s by the operator's arm",
          "energy after over before",
          "<= 1",
          {},
          "the coupling gives back more than it was given"};
  const std::vector<double> ratios = OfVariants(ReboundEnergy);
  for (std::size_t i = 0; i < ratios.size(); ++i)
    row.readings.push_back({Variants()[i].name, Short(ratios[i]), ratios[i] <= 1.0});
  AddRow(report, row);
}

}  // namespace failures

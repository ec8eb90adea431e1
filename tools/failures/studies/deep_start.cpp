// F17: a body that starts deep inside a plate.
#include <algorithm>
#include <cmath>

#include "tools/failures/for_all.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kHalf_m = 0.02;

struct Exit {
  double speed_m_per_s = 0.0;
  double energy_J = 0.0;  // largest kinetic energy, over what the contact's spring held at the start
  bool is_right = false;  // left on the side that it came in
};

constexpr double kMass_kg = 0.5;
constexpr glm::dvec3 kPlateSize_m{0.2, 0.2, 0.08};
const core::Pose X_WP{{1, 0, 0, 0}, {0, 0, -0.5 * kPlateSize_m.z}};
vps::TriangleMesh Cube() {
  return vps::MakeBox(glm::dvec3(2.0 * kHalf_m));
}
core::Pose Inside(double depth_m) {
  return {{1, 0, 0, 0}, {0, 0, kHalf_m - depth_m}};
}

Exit Leave(const Variant& variant, double depth_m) {
  SceneKit kit(variant);
  const auto plate = kit.AddFixed(vps::MakeBox(kPlateSize_m), X_WP, kVoxel_m);
  const auto body = kit.AddBody(Cube(), Inside(depth_m), kMass_kg, 0.0, kToolPoints);
  kit.AddIdleHand();
  scene::Pair& pair = kit.AddPair(body, plate);
  const double stored_J = 0.5 * pair.stiffness_N_per_m * depth_m * depth_m;
  Loop loop(kit.scenario);
  Exit exit;
  for (int i = 0; i < 2000; ++i) {
    loop.Tick();
    exit.speed_m_per_s = std::max(exit.speed_m_per_s, glm::length(loop.body(body).V_WO.linear_m_per_s));
  }
  exit.energy_J = 0.5 * kMass_kg * exit.speed_m_per_s * exit.speed_m_per_s / stored_J;
  exit.is_right = loop.body(body).X_WO.translation.z > kHalf_m - 1e-3;
  return exit;
}

// The peers' contacts hold no energy: speed and side alone are judged.
Exit LeaveInPeer(const Peer& peer, double depth_m) {
  const auto loop = peer.make_loop(0.0);
  loop->AddFixed(vps::MakeBox(kPlateSize_m), X_WP);
  loop->AddBody(Cube(), Inside(depth_m), kMass_kg);
  Exit exit;
  for (int i = 0; i < 2000; ++i) {
    loop->Tick();
    exit.speed_m_per_s = std::max(exit.speed_m_per_s, loop->speed_m_per_s());
  }
  exit.is_right = loop->X_WC().translation.z > kHalf_m - 1e-3;
  return exit;
}

std::string SideOf(const Exit& exit) {
  return exit.is_right ? "right" : "wrong";
}

}  // namespace

void StudyDeepStart(const Peers& peers, Report* report) {
  for (const double depth_m : {0.005, 0.02}) {
    Row row{"F17",
            "deep start",
            "cube of 40 mm and 0.5 kg, " + Short(1e3 * depth_m) + " mm inside a plate of 80 mm, 20 kN/m",
            "fastest speed; energy over the spring's; side",
            "<= 0.5 m/s; <= 1; right",
            {},
            "`paper`: the pair's spring lets go of all that it holds, though no work has put it in"};
    const auto exits = OfVariants([depth_m](const Variant& variant) { return Leave(variant, depth_m); });
    for (std::size_t i = 0; i < exits.size(); ++i) {
      const Variant& variant = Variants()[i];
      const Exit& exit = exits[i];
      row.readings.push_back({variant.name,
                              Short(exit.speed_m_per_s) + " m/s; " + Short(exit.energy_J) + "; " + SideOf(exit),
                              exit.speed_m_per_s <= 0.5 && exit.energy_J <= 1.0 && exit.is_right});
    }
    for (const Peer& peer : peers) {
      const Exit exit = LeaveInPeer(peer, depth_m);
      row.readings.push_back({peer.name, Short(exit.speed_m_per_s) + " m/s; -; " + SideOf(exit),
                              exit.speed_m_per_s <= 0.5 && exit.is_right});
    }
    AddRow(report, row);
  }
}

}  // namespace failures

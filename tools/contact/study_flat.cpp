#include <cstdio>

#include "tools/contact/studies.hpp"
#include "vps/testing/shapes.hpp"

namespace contact {
namespace {

// Not derived: length of a run against scatter of the medians.
constexpr int kPasses = 5;
constexpr double kSecondsEach = 1.0;
constexpr double kVoxel_m = 1e-3;
constexpr double kStep_m = 1e-6;  // 1 mm/s at 1 kHz
constexpr int kSteps = 100;       // from 0.1 mm to 1 um
constexpr double kWanted_us = 30.0;

struct Entrant {
  const char* method;
  const char* setting;
  double accuracy;
};
constexpr Entrant kEntrants[] = {{"fast", "10 %", 0.1}, {"fast", "2 %", kAccuracy}, {"paper", "", 0.0}};

struct Plates {
  const char* name;
  glm::dquat R;  // of both
};

// B's lower face comes down on A's upper one, both askew to the voxels or along them.
std::vector<core::Pose> ComingTogether(const Plates& plates) {
  std::vector<core::Pose> poses;
  for (int i = 0; i < kSteps; ++i) {
    const double gap_m = kStep_m * (kSteps - i);
    poses.push_back({{1, 0, 0, 0}, plates.R * glm::dvec3(0.01, 0.005, 0.02 + gap_m)});
  }
  return poses;
}

vps::TriangleMesh Turned(vps::TriangleMesh mesh, const glm::dquat& q) {
  for (glm::dvec3& v : mesh.vertices) v = q * v;
  return mesh;
}

}  // namespace

void StudyFlat(Report* report) {
  Table table{"flat", {"plates", "method", "setting", "p50_us", "p99_us", "max_us", "contacts"}, {}};
  for (const Plates& plates : {Plates{"along the voxels", {1, 0, 0, 0}},
                               Plates{"askew", core::QuaternionFromRotationVector({0.3, 0.5, 0.2})}}) {
    const Parts parts{plates.name, Turned(vps::MakeBox({0.1, 0.1, 0.02}), plates.R),
                      Turned(vps::MakeBox({0.06, 0.05, 0.02}), plates.R), kVoxel_m};
    Structures structures(parts);
    std::vector<std::unique_ptr<Method>> methods;
    std::vector<Racer> racers;
    for (const Entrant& e : kEntrants) {
      const vps::Method kind = e.accuracy > 0.0 ? vps::Method::kFast : vps::Method::kPaper;
      const auto A = structures.Get({false, kind, kVoxel_m, 0});
      const auto B = structures.Get({true, kind, 0.0, kMiddlePoints});
      if (!A || !B) return;
      methods.push_back(e.accuracy > 0.0 ? MakeFastMethod(*A, *B, AsInScenarios(e.accuracy))
                                         : MakePaperMethod(*A, *B, vps::SurfaceArea_m2(parts.B), true));
      racers.push_back({methods.back().get(), ComingTogether(plates), true, {}});
    }
    Race(racers, kPasses, kSecondsEach);
    for (std::size_t i = 0; i < racers.size(); ++i) {
      const Entrant& e = kEntrants[i];
      const Times& t = racers[i].times;
      int contacts = 0;
      for (const core::Pose& X : racers[i].poses) contacts += methods[i]->Query(X).contacts > 0 ? 1 : 0;
      table.Add(
          {plates.name, e.method, e.setting, Cell(t.p50_us), Cell(t.p99_us), Cell(t.max_us), std::to_string(contacts)});
      std::printf("flat faces, %s, %s %s: %s us median, %s us 99th percentile, %d of %d poses report contact\n",
                  plates.name, e.method, e.setting, Short(t.p50_us).c_str(), Short(t.p99_us).c_str(), contacts, kSteps);
      if (e.accuracy == 0.0) continue;
      report->AddGoal(std::string("flat faces before they touch (") + plates.name + "), 64 k points, " + e.setting,
                      "<= 30 us",
                      Short(t.p50_us) + " us median, " + Short(t.p99_us) + " us 99th percentile (paper " +
                          Short(racers.back().times.p50_us) + " us)",
                      t.p99_us <= kWanted_us);
    }
  }
  report->tables.push_back(table);
}

}  // namespace contact

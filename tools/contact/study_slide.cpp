#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/contact/studies.hpp"
#include "vps/oracle/closed_form.hpp"
#include "vps/testing/shapes.hpp"

namespace contact {
namespace {

// The goals are set at these figures.
constexpr double kVoxel_m = 1e-3;
constexpr double kStep_m = 1e-4;  // 0.1 m/s at 1 kHz
constexpr int kSteps = 200;
constexpr double kDepth_m = 5e-4;
constexpr double kBall_m = 0.02;
constexpr double kCylinder_m = 0.025;  // 25 voxels

struct Slide {
  const char* name;
  Parts parts;
  std::vector<core::Pose> poses;
};

vps::TriangleMesh Turned(vps::TriangleMesh mesh, const glm::dquat& q) {
  for (glm::dvec3& v : mesh.vertices) v = q * v;
  return mesh;
}

// A plate that is not aligned with its voxels.
Slide Plane() {
  const glm::dquat q = core::QuaternionFromRotationVector({0.3, 0.5, 0.2});
  Slide slide{
      "plane", {"plane", Turned(vps::MakeBox({0.1, 0.1, 0.02}), q), vps::MakeSphere(kBall_m, 128), kVoxel_m}, {}};
  for (int i = 0; i < kSteps; ++i) {
    const glm::dvec3 p(kStep_m * (i - kSteps / 2), 0.3 * kStep_m * i, 0.01 + kBall_m - kDepth_m);
    slide.poses.push_back({{1, 0, 0, 0}, q * p});
  }
  return slide;
}

// Around a cylinder's axis; the ball turns with its position, so that it always touches with the same samples.
Slide Curved() {
  Slide slide{"cylinder, R = 25 s",
              {"cylinder", vps::MakeCylinder(kCylinder_m, 0.06, 1024), vps::MakeSphere(0.01, 128), kVoxel_m},
              {}};
  for (int i = 0; i < kSteps; ++i) {
    const double angle = 0.2 + kStep_m / kCylinder_m * i;
    const double r = kCylinder_m + 0.01 - kDepth_m;
    slide.poses.push_back(
        {core::QuaternionFromRotationVector({0, 0, angle}), {r * std::cos(angle), r * std::sin(angle), 2e-3}});
  }
  return slide;
}

std::vector<double> Forces(Method* method, const std::vector<core::Pose>& poses) {
  std::vector<double> forces;
  for (const core::Pose& pose : poses) forces.push_back(glm::length(method->Query(pose).force_A));
  return forces;
}

}  // namespace

void StudySlide(Report* report) {
  Table table{"slide", {"surface", "method", "step", "force_m3", "over_mean"}, {}};
  Chart chart{"Force of a ball that slides at constant depth",
              "0.1 m/s at 1 kHz, 0.5 mm deep, s = 1 mm, 64k points; a steady hand should feel a steady force",
              {}};
  for (const Slide& slide : {Plane(), Curved()}) {
    Structures structures(slide.parts);
    Panel panel;
    panel.title = slide.name;
    panel.x_title = "distance slid [mm]";
    panel.y_title = "force over its mean";
    panel.x_log = panel.y_log = false;
    double ripple[2] = {0.0, 0.0};
    for (const vps::Method kind : {vps::Method::kPaper, vps::Method::kFast}) {
      const bool is_fast = kind == vps::Method::kFast;
      const auto A = structures.Get({false, kind, kVoxel_m, 0});
      const auto B = structures.Get({true, kind, 0.0, kMiddlePoints});
      if (!A || !B) continue;
      const auto method = is_fast ? MakeFastMethod(*A, *B, AsInScenarios(kAccuracy))
                                  : MakePaperMethod(*A, *B, vps::SurfaceArea_m2(slide.parts.B), true);
      const std::vector<double> forces = Forces(method.get(), slide.poses);
      double mean = 0.0;
      for (const double f : forces) mean += f / static_cast<double>(forces.size());
      panel.series.push_back({is_fast ? "fast" : "paper", {}, true});
      for (std::size_t i = 0; i < forces.size(); ++i) {
        ripple[is_fast] = std::max(ripple[is_fast], std::abs(forces[i] / mean - 1.0));
        table.Add({slide.name, is_fast ? "fast" : "paper", std::to_string(i), Cell(forces[i]), Cell(forces[i] / mean)});
        if (i % 2 == 0)
          panel.series.back().points.push_back({1e3 * kStep_m * static_cast<double>(i), forces[i] / mean, ""});
      }
      if (!is_fast || slide.parts.name != "plane") continue;
      // From 20 to 200 um deep by 1 um a step: |F(h) - F(h - 1 um)| over the change of the cap's volume,
      // V(h) = pi h^2 (R - h / 3) (SphereOnHalfSpaceForce).
      double worst = 0.0;
      double before = 0.0;
      const glm::dvec3 normal = core::QuaternionFromRotationVector({0.3, 0.5, 0.2}) * glm::dvec3(0, 0, 1);
      for (int um = 20; um <= 200; ++um) {
        const double force = glm::length(method->Query({{1, 0, 0, 0}, (0.01 + kBall_m - 1e-6 * um) * normal}).force_A);
        const double smooth = vps::oracle::SphereOnHalfSpaceForce(kBall_m, 1e-6 * um) -
                              vps::oracle::SphereOnHalfSpaceForce(kBall_m, 1e-6 * (um - 1));
        if (um > 20) worst = std::max(worst, std::abs(force - before) / smooth);
        before = force;
      }
      report->AddGoal("force step at 1 um of approach, ball on plane, over the smooth change", "<= 2 x",
                      Short(worst) + " x at worst", worst <= 2.0);
    }
    chart.panels.push_back(panel);
    const double wanted = slide.parts.name == "plane" ? 0.005 : 0.02;
    std::printf("slide on %s: ripple %s %% (paper %s %%)\n", slide.name, Short(100.0 * ripple[1]).c_str(),
                Short(100.0 * ripple[0]).c_str());
    report->AddGoal(std::string("ripple of a slide at constant depth, ") + slide.name,
                    "<= " + Short(100.0 * wanted) + " %",
                    Short(100.0 * ripple[1]) + " % (paper " + Short(100.0 * ripple[0]) + " %)", ripple[1] <= wanted);
  }
  report->tables.push_back(table);
  report->charts.emplace_back("slide", chart);
}

}  // namespace contact

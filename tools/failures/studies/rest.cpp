// F19: a handle that is held still, pressed into the corner of a slot.
#include <cmath>

#include "tools/failures/for_all.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

struct Jitter {
  double pose_m = 0.0;  // rms about the mean, of the proxy
  double force = 0.0;   // the same of the force, over its mean
};

Jitter Hold(const Variant& variant) {
  SceneKit kit(variant);
  const vps::TriangleMesh wall = vps::MakeBox({0.08, 0.02, 0.06});
  const auto floor = kit.AddFixed(vps::MakeBox({0.1, 0.1, 0.02}), {{1, 0, 0, 0}, {0, 0, -0.01}}, 5e-4);
  const auto left = kit.AddFixed(wall, {{1, 0, 0, 0}, {0, -0.0201, 0.03}}, 5e-4);
  const auto right = kit.AddFixed(wall, {{1, 0, 0, 0}, {0, 0.0201, 0.03}}, 5e-4);
  const auto handle = kit.AddHand(vps::MakeBox({0.06, 0.02, 0.04}), {{1, 0, 0, 0}, {0, 0, 0.0205}}, kToolPoints);
  for (const auto field : {floor, left, right}) kit.AddPair(handle, field);
  LoopOptions options;
  options.script = "wait 1.2\npush 0 0.5 -0.8660254 by 0.012 speed 0.02\nwait 600";
  Loop loop(kit.scenario, options);
  loop.Run(6.0);
  std::vector<glm::dvec3> places;
  std::vector<glm::dvec3> forces;
  for (int i = 0; i < 10000; ++i) {
    loop.Tick();
    places.push_back(loop.X_WC().translation);
    forces.push_back(loop.exerted().force_N);
  }
  const auto spread = [](const std::vector<glm::dvec3>& values, double* mean_length) {
    glm::dvec3 mean(0.0);
    for (const glm::dvec3& v : values) mean += v / static_cast<double>(values.size());
    double sum = 0.0;
    for (const glm::dvec3& v : values) sum += glm::dot(v - mean, v - mean);
    *mean_length = glm::length(mean);
    return std::sqrt(sum / static_cast<double>(values.size()));
  };
  Jitter jitter;
  double mean = 0.0;
  jitter.pose_m = spread(places, &mean);
  jitter.force = spread(forces, &mean) / mean;
  return jitter;
}

}  // namespace

void StudyRest(Report* report) {
  Row row{"F19",
          "jitter at rest",
          "handle 60 x 20 x 40 mm in a slot 0.2 mm wider, pressed into its corner for 10 s, without tremor",
          "rms of the proxy; of the force",
          "<= 1 um; <= 0.5 %",
          {},
          "layers of voxels take turns in carrying the proxy"};
  const std::vector<Jitter> jitters = OfVariants(Hold);
  for (std::size_t i = 0; i < jitters.size(); ++i) {
    const Variant& variant = Variants()[i];
    const Jitter& jitter = jitters[i];
    row.readings.push_back({variant.name, Short(1e6 * jitter.pose_m) + " um; " + Short(100.0 * jitter.force) + " %",
                            jitter.pose_m <= 1e-6 && jitter.force <= 0.005});
  }
  AddRow(report, row);
}

}  // namespace failures

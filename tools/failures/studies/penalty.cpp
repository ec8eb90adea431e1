// F12: a free body that bounces between two plates, with contacts that reach the dynamics late.
#include <algorithm>
#include <cmath>

#include "physics/testing/trials/rebound.hpp"
#include "tools/failures/for_all.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kMass_kg = 0.5;
constexpr double kStiffness_N_per_m = 1e4;
constexpr double kSpeed_m_per_s = 0.1;
constexpr double kPlay_m = 0.004;
constexpr double kHalf_m = 0.02;  // of the body

// Largest kinetic energy within a second over that at the start.
double EnergyRatio(const Variant& variant, int delay_ticks) {
  SceneKit kit(variant);
  kit.scenario.contact_input = scene::ContactInput::kPlanes;
  const vps::TriangleMesh plate = vps::MakeBox({0.1, 0.1, 0.02});
  const auto below = kit.AddFixed(plate, {{1, 0, 0, 0}, {0, 0, -0.01}}, kVoxel_m);
  const auto above = kit.AddFixed(plate, {{1, 0, 0, 0}, {0, 0, 2.0 * kHalf_m + kPlay_m + 0.01}}, kVoxel_m);
  const auto body = kit.AddBody(vps::MakeBox(glm::dvec3(2.0 * kHalf_m)),
                                {{1, 0, 0, 0}, {0, 0, kHalf_m + 0.5 * kPlay_m}}, kMass_kg, 0.0, kToolPoints);
  kit.scenario.objects[body].V_WO.linear_m_per_s = {0, 0, -kSpeed_m_per_s};
  kit.AddIdleHand();
  for (const auto field : {below, above}) {
    scene::Pair& pair = kit.AddPair(body, field);
    pair.stiffness_N_per_m = kStiffness_N_per_m;
    pair.damping_N_s_per_m = 0.0;
    pair.friction = 0.0;
  }
  LoopOptions options;
  options.physics_delay_ticks = delay_ticks;
  Loop loop(kit.scenario, options);
  double fastest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    loop.Tick();
    fastest = std::max(fastest, glm::length(loop.body(body).V_WO.linear_m_per_s));
  }
  return fastest * fastest / (kSpeed_m_per_s * kSpeed_m_per_s);
}

}  // namespace

void StudyPenalty(Report* report) {
  for (const int delay : {0, 1, 2}) {
    Row row{"F12",
            "explicit penalty",
            "0.5 kg bounces between plates of 10 kN/m for 1 s, contacts " + std::to_string(delay) +
                " ms late (and 1 ms on the way), no damping, input `planes`",
            "largest kinetic energy over that at the start",
            "<= 1.001",
            {},
            "`paper`: the place of the surface is a voxel's and steps as the contact moves"};
    const auto ratios = OfVariants([delay](const Variant& variant) { return EnergyRatio(variant, delay); });
    for (std::size_t i = 0; i < ratios.size(); ++i)
      row.readings.push_back({Variants()[i].name, bench::Cell(ratios[i]), ratios[i] <= 1.001});
    AddRow(report, row);
  }
}

}  // namespace failures

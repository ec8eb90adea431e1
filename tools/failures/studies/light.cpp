// F11: a part of ten grams between a hand that presses and a plate.
#include <algorithm>
#include <cmath>

#include "tools/failures/for_all.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kMass_kg = 0.01;
constexpr glm::dvec3 kPart_m{0.02, 0.02, 0.01};  // of aluminium
constexpr double kCoupling_N_per_m = 1e4;
constexpr double kPress_N = 50.0;
constexpr double kSeconds = 60.0;
constexpr double kBegin_s = 8.0;  // the press is on
constexpr double kFastest_m_per_s = 0.1;
constexpr double kStill_m_per_s = 1e-3;

struct Pressed {
  double fastest_m_per_s = 0.0;
  double growth = 0.0;  // mean kinetic energy of the last third over that of the first
  double force_N = 0.0;
};

Pressed Press(const Variant& variant) {
  SceneKit kit(variant);
  kit.scenario.coupling.stiffness_N_per_m = kCoupling_N_per_m;
  kit.scenario.force_cap_N = 2.0 * kPress_N;
  const auto plate = kit.AddFixed(vps::MakeBox({0.1, 0.1, 0.02}), {{1, 0, 0, 0}, {0, 0, -0.01}}, kVoxel_m);
  const auto part =
      kit.AddBody(vps::MakeBox(kPart_m), {{1, 0, 0, 0}, {0, 0, 0.5 * kPart_m.z}}, kMass_kg, 5e-4, kToolPoints);
  const auto ball =
      kit.AddHand(vps::MakeSphere(kBall_m, 64), {{1, 0, 0, 0}, {0, 0, kPart_m.z + kBall_m + 0.002}}, kToolPoints);
  kit.device().max_force_N = 2.0 * kPress_N;
  kit.AddPair(ball, part);
  kit.AddPair(part, plate);
  const double lean_m = kPress_N / kit.device().hand_stiffness_N_per_m + kPress_N / kCoupling_N_per_m + 0.002;
  LoopOptions options;
  options.script = "wait 1.2\npush 0 0 -1 by " + std::to_string(lean_m) + " speed 0.03\nwait 600";
  Loop loop(kit.scenario, options);
  loop.Run(kBegin_s);
  Pressed pressed;
  double first = 0.0;
  double last = 0.0;
  const int num_ticks = static_cast<int>(1000.0 * kSeconds);
  for (int i = 0; i < num_ticks; ++i) {
    loop.Tick();
    const double speed = glm::length(loop.body(part).V_WO.linear_m_per_s);
    pressed.fastest_m_per_s = std::max(pressed.fastest_m_per_s, speed);
    if (i < num_ticks / 3) first += speed * speed;
    if (i >= num_ticks - num_ticks / 3) last += speed * speed;
  }
  const double still = kStill_m_per_s * kStill_m_per_s * (num_ticks / 3);
  pressed.growth = last < still ? 0.0 : last / std::max(first, still);
  pressed.force_N = glm::length(loop.exerted().force_N);
  return pressed;
}

}  // namespace

void StudyLightBodies(Report* report) {
  Row row{"F11",
          "light bodies",
          "box of 20 x 20 x 10 mm and 10 g between a ball that presses with 50 N through 10 kN/m, and a plate, 60 s",
          "fastest; kinetic energy of the last 20 s over the first 20 s (0: below 1 mm/s); force",
          "<= 0.1 m/s; <= 1; >= 45 N",
          {},
          "coupling `paper` has no friction at the hand, but physics_node drags the part by friction of its own, so "
          "that it tips and is shot out"};
  const std::vector<Pressed> pressed = OfVariants(Press);
  for (std::size_t i = 0; i < pressed.size(); ++i) {
    const Pressed& one = pressed[i];
    row.readings.push_back(
        {Variants()[i].name,
         Short(one.fastest_m_per_s) + " m/s; " + Short(one.growth) + "; " + Short(one.force_N) + " N",
         one.fastest_m_per_s <= kFastest_m_per_s && one.growth <= 1.0 && one.force_N >= 0.9 * kPress_N});
  }
  AddRow(report, row);
}

}  // namespace failures

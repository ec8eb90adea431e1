// Rotation: a free triaxial body tumbles for a minute.
#include <cmath>
#include <cstdio>

#include "physics/testing/closed_form/free_rotation.hpp"
#include "tools/dynamics/studies.hpp"
#include "tools/dynamics/turns.hpp"

namespace dynamics {
namespace {

constexpr double kSeconds = 60.0;

struct Errors {
  double energy = 0.0;    // largest relative error during the run
  double momentum = 0.0;  // the same, of the vector of angular momentum
  int flips = 0;
  double flip_s = 0.0;  // largest error of a flip's time, over the flips that both have
};

// A missing or an extra flip turns the axis to the other side, so that later times are far off as well.
Errors Follow(const SpinnerMaker& maker, const SpinnerParams& params) {
  const auto spinner = maker.make(params);
  const glm::dvec3& I = params.moments_kg_m2;
  const auto energy_J = [&](const glm::dvec3& w_B) { return 0.5 * glm::dot(w_B, I * w_B); };
  const double start_J = energy_J(params.w_B_rad_per_s);
  const glm::dvec3 L_W = I * params.w_B_rad_per_s;
  const physics::closed_form::FreeRotation exact(I, params.w_B_rad_per_s);
  Errors errors;
  double previous = params.w_B_rad_per_s.y;
  const int steps = static_cast<int>(std::lround(kSeconds / params.dt_s));
  for (int i = 1; i <= steps; ++i) {
    spinner->Step();
    const glm::dvec3 w_B = spinner->w_B_rad_per_s();
    errors.energy = std::max(errors.energy, std::abs(energy_J(w_B) / start_J - 1.0));
    const glm::dvec3 now_W = spinner->R_WB() * (I * w_B);
    errors.momentum = std::max(errors.momentum, glm::length(now_W - L_W) / glm::length(L_W));
    if (w_B.y * previous < 0.0) {
      const double at_s = (i - w_B.y / (w_B.y - previous)) * params.dt_s;
      errors.flip_s = std::max(errors.flip_s, std::abs(at_s - exact.flip_s(errors.flips++)));
    }
    previous = w_B.y;
  }
  return errors;
}

std::vector<double> StepTimes_us(const std::vector<SpinnerMaker>& makers, const SpinnerParams& params) {
  std::vector<std::shared_ptr<Spinner>> spinners;
  std::vector<std::function<void()>> pieces;
  for (const SpinnerMaker& maker : makers) {
    spinners.push_back(maker.make(params));
    pieces.emplace_back([spinner = spinners.back()] { spinner->Step(); });
  }
  return TakeTurns(pieces, 2000 / params.num_bodies, 41);
}

}  // namespace

void StudyRotation(const Peers& peers, Report* report) {
  std::vector<SpinnerMaker> makers = OwnSpinners();
  makers.insert(makers.end(), peers.spinners.begin(), peers.spinners.end());
  const std::vector<double> us = StepTimes_us(makers, {});
  SpinnerParams twenty;
  twenty.num_bodies = 20;
  const std::vector<double> us_of_twenty = StepTimes_us(makers, twenty);

  Table table{
      "rotation",
      {"contender", "step_ms", "us_per_step", "us_per_step_of_20_bodies", "time_against_bullet_default",
       "time_against_bullet_default_20_bodies", "energy_error", "momentum_error", "flips", "worst_flip_error_ms"},
      {}};
  Panel energy{"energy", "us for a millisecond of motion", "largest relative error in 60 s", {}, true, true, {}};
  Panel momentum{
      "angular momentum", "us for a millisecond of motion", "largest relative error in 60 s", {}, true, true, {}};
  energy.bands = {{1e-6, 1e9, "more than 1e-6"}};
  momentum.bands = {{1e-10, 1e9, "more than 1e-10"}};
  Errors ours;
  for (std::size_t i = 0; i < makers.size(); ++i) {
    Series of_energy{makers[i].name, {}, true};
    Series of_momentum{makers[i].name, {}, true};
    for (const double step_ms : {4.0, 1.0, 0.25}) {
      SpinnerParams params;
      params.dt_s = 1e-3 * step_ms;
      const Errors errors = Follow(makers[i], params);
      if (i == 0 && step_ms == 1.0) ours = errors;
      table.Add({makers[i].name, Cell(step_ms), Cell(us[i]), Cell(us_of_twenty[i]), Cell(us[i] / us[1]),
                 Cell(us_of_twenty[i] / us_of_twenty[1]), Cell(errors.energy), Cell(errors.momentum),
                 Cell(errors.flips), Cell(1e3 * errors.flip_s)});
      const std::string mark = i < 2 ? Short(step_ms) + " ms" : "";
      of_energy.points.push_back({us[i] / step_ms, errors.energy, mark});
      of_momentum.points.push_back({us[i] / step_ms, errors.momentum, mark});
      std::printf("%-24s %5.2f ms  %6.3f us  energy %.2g  momentum %.2g  flips %d  off by %.3g ms\n",
                  makers[i].name.c_str(), step_ms, us[i], errors.energy, errors.momentum, errors.flips,
                  1e3 * errors.flip_s);
    }
    energy.series.push_back(of_energy);
    momentum.series.push_back(of_momentum);
  }
  report->tables.push_back(table);
  report->charts.emplace_back("rotation",
                              Chart{"Rotation: a free triaxial body tumbles for a minute",
                                    "moments 1, 2, 3 kg m2, started about the middle axis; steps of 4, 1 and 0.25 ms",
                                    {energy, momentum}});
  report->AddGoal("free tumbling, 60 s: energy", "<= 1e-6", Short(ours.energy), ours.energy <= 1e-6);
  report->AddGoal("free tumbling, 60 s: angular momentum", "<= 1e-10", Short(ours.momentum), ours.momentum <= 1e-10);
  report->AddGoal("free tumbling, 60 s: flips beside the exact solution", "<= 1 ms",
                  Short(1e3 * ours.flip_s) + " ms, " + std::to_string(ours.flips) + " flips",
                  ours.flip_s <= 1e-3 && ours.flips == 5);
  const double worst = std::max(us[0] / us[1], us_of_twenty[0] / us_of_twenty[1]);
  report->AddGoal("free tumbling: step time against Bullet's default", "<= 1.3",
                  Short(us[0] / us[1]) + " (one body), " + Short(us_of_twenty[0] / us_of_twenty[1]) + " (twenty)",
                  worst <= 1.3);
}

}  // namespace dynamics

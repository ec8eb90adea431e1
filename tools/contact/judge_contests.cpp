#include <algorithm>
#include <cmath>

#include "tools/contact/studies.hpp"

namespace contact {
namespace {

class Judge {
 public:
  Judge(const std::vector<Measurement>& all, Report* report) : all_(all), report_(report) {}

  [[nodiscard]] const Measurement* Find(const std::string& workload, const std::string& method,
                                        const std::string& setting) const {
    for (const Measurement& m : all_) {
      if (m.workload == workload && m.method == method && (setting.empty() || m.setting == setting)) return &m;
    }
    return nullptr;
  }

  // Adds the goal that `fast` is `wanted` times faster than method `than` at the middle resolution.
  void Faster(const std::string& what, const std::string& workload, const std::string& than, double wanted,
              const char* setting = kMiddle) {
    const Measurement* fast = Find(workload, "fast", setting);
    const Measurement* other = Find(workload, than, than == "paper" || than == "OpenVDB" ? kMiddle : "");
    if (fast == nullptr) return;
    Goal goal{what + " (" + workload + "): faster than " + than, (wanted > 1.0 ? ">= " : "> ") + Short(wanted) + " x",
              "not here: ./dev bench has it", Verdict::kNotMeasured};
    if (other != nullptr) {
      const double consecutive = other->consecutive.p50_us / fast->consecutive.p50_us;
      const double independent = other->independent.p50_us / fast->independent.p50_us;
      goal.measured = Short(consecutive) + " x consecutive, " + Short(independent) + " x independent (" +
                      Short(fast->consecutive.p50_us) + " us)";
      const int met = (consecutive >= wanted) + (independent >= wanted);
      goal.verdict = met == 2 ? Verdict::kMet : met == 1 ? Verdict::kPartly : Verdict::kMissed;
    }
    report_->goals.push_back(std::move(goal));
  }

  void Accuracy(const std::string& workload) {
    const Measurement* fast = Find(workload, "fast", kMiddle);
    if (fast == nullptr) return;
    report_->AddGoal(
        "whole wrench against the exact one (" + workload + "), 64 k points: magnitude", "<= 2 %",
        Short(100.0 * fast->magnitude.p50) + " % median, " + Short(100.0 * fast->magnitude.max) + " % worst",
        fast->magnitude.max <= 0.02);
    report_->AddGoal("whole wrench against the exact one (" + workload + "), 64 k points: direction", "<= 1 / 2.5 deg",
                     Short(fast->direction_deg.p50) + " / " + Short(fast->direction_deg.p95) + " deg, median / p95",
                     fast->direction_deg.p50 <= 1.0 && fast->direction_deg.p95 <= 2.5);
    Spread(workload);
  }

  // Adds the goal for max F / min F - 1 over 4k, 16k and 64k points, at poses where 200 points or more touch at 4k.
  void Spread(const std::string& workload) {
    const Measurement* few = Find(workload, "fast", "s; 4096 points");
    const Measurement* some = Find(workload, "fast", "s; 16384 points");
    const Measurement* many = Find(workload, "fast", kMiddle);
    if (few == nullptr || some == nullptr || many == nullptr) return;
    double worst = -1.0;
    for (std::size_t i = 0; i < few->forces.size(); ++i) {
      if (few->contacts[i] < 200) continue;
      const auto [low, high] = std::minmax({few->forces[i], some->forces[i], many->forces[i]});
      worst = std::max(worst, high / low - 1.0);
    }
    if (worst < 0.0) return;  // no pose touches with so many
    report_->AddGoal("spread of the force from 4 k to 64 k points (" + workload + ")", "<= 5 %",
                     Short(100.0 * worst) + " % at worst", worst <= 0.05);
  }

  void Idle() {
    const Measurement* fast = Find("bunny_apart", "fast", kMiddle);
    if (fast == nullptr) return;
    report_->AddGoal("idle pair queried alone (bunny_apart)", "<= 30 ns", Short(1e3 * fast->consecutive.p50_us) + " ns",
                     fast->consecutive.p50_us <= 0.03);
  }

 private:
  const std::vector<Measurement>& all_;
  Report* report_;
};

}  // namespace

void JudgeContests(const std::vector<Measurement>& all, Report* report) {
  Judge judge(all, report);
  for (const char* workload : {"peg_pressed", "nut_pressed"}) {
    const std::string what = "conforming contact, 64 k points, s = 0.25 mm";
    const double wanted = std::string(workload) == "peg_pressed" ? 12.0 : 3.0;
    judge.Faster(what, workload, "paper", wanted);
    judge.Faster(what + ", 10 %", workload, "paper", wanted, kMiddleAtTen);
    judge.Faster(what, workload, "FCL", 150.0);
    judge.Faster(what, workload, "GImpact", 300.0);
  }
  const std::string light = "light contact, 64 k points, s = 0.8 mm";
  judge.Faster(light, "bunny_light", "paper", 0.25);
  judge.Faster(light, "bunny_light", "FCL", 20.0);
  judge.Faster(light, "bunny_light", "GJK/EPA", 1.0);
  judge.Faster("near, not touching", "bunny_near", "paper", 5.0);
  judge.Idle();
  for (const char* workload : {"peg_pressed", "nut_pressed", "gear_on_pin", "bunny_light", "bunny_deep",
                               "fandisk_on_bunny", "module_on_bracket", "ring_on_ring", "ball_on_box"}) {
    judge.Accuracy(workload);
  }
}

}  // namespace contact

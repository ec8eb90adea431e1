// F15: haptic_node with more and more parts. All parts that can move circle on the spot, so that no pair is kept
// because nothing has moved; the first ones slide on a fixed pad each.
#include <algorithm>
#include <cmath>

#include "core/clock.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kSide_m = 0.04;
constexpr double kApart_m = 0.02;
constexpr double kCircle_m = 0.001;
constexpr double kSpeed_m_per_s = 0.1;
constexpr double kOverlap_m = 2e-4;
constexpr int kMostMoving = static_cast<int>(core::kMaxBodies);

// Drives haptic_node alone: the state of physics is made here.
class Parts {
 public:
  Parts(const Variant& variant, int num_parts, int num_touching) : kit_(variant) {
    const SetUpLock lock;
    const vps::TriangleMesh cube = vps::MakeBox(glm::dvec3(kSide_m));
    std::vector<std::uint16_t> parts;
    const int num_moving = std::min(num_parts, kMostMoving);
    for (int i = 0; i < num_parts; ++i) {
      const core::Pose X_WO{{1, 0, 0, 0}, (kSide_m + kApart_m) * glm::dvec3(i % 10, i / 10 % 10, 2 * (i / 100))};
      parts.push_back(i < num_moving ? kit_.AddBody(cube, X_WO, 1.0, 2e-3, 256) : kit_.AddFixed(cube, X_WO, 2e-3, 256));
    }
    for (int i = 0; i < num_moving; ++i) {
      for (int j = i + 1; j < num_parts; ++j)
        kit_.AddPair(parts[static_cast<std::size_t>(i)], parts[static_cast<std::size_t>(j)]);
    }
    for (int i = 0; i < num_touching; ++i) {
      const auto part = parts[static_cast<std::size_t>(i)];
      core::Pose X_WO = kit_.scenario.objects[part].X_WO;
      X_WO.translation.z -= kSide_m - kOverlap_m;
      kit_.AddPair(part, kit_.AddFixed(cube, X_WO, 2e-3));
    }
    kit_.AddIdleHand();
    haptic_node::Options options;
    options.collision.cache = WorkFolder() / "cache";
    node_ = Must(haptic_node::HapticNode::Create(kit_.scenario, serial_, options));
    node_->PrepareOutputs(&out_);
    for (int i = 0; i < num_moving; ++i) {
      core::BodyState body;
      body.object = parts[static_cast<std::size_t>(i)];
      state_.bodies.push_back(body);
    }
  }

  // Processor time of a step.
  double Step_us() {
    ++tick_;
    const double angle = kSpeed_m_per_s / kCircle_m * 1e-3 * static_cast<double>(tick_);
    for (core::BodyState& body : state_.bodies) {
      body.X_WO = kit_.scenario.objects[body.object].X_WO;
      const double own = angle + body.object;  // each elsewhere on its circle
      body.X_WO.translation += kCircle_m * glm::dvec3(std::cos(own), std::sin(own), 0.0);
    }
    state_.header.sequence = tick_;
    state_.header.publish_ns = static_cast<std::int64_t>(tick_) * core::kTick_ns;
    haptic_node::Inputs inputs;
    inputs.now_ns = state_.header.publish_ns;
    inputs.physics = &state_;
    const std::int64_t begin_ns = core::ThreadCpuNow_ns();
    node_->Step(inputs, &out_);
    return 1e-3 * static_cast<double>(core::ThreadCpuNow_ns() - begin_ns);
  }
  [[nodiscard]] std::size_t num_pairs() const { return kit_.scenario.pairs.size(); }
  [[nodiscard]] std::uint32_t num_touching() const { return out_.counters.pairs_in_contact; }

 private:
  SceneKit kit_;
  core::SerialFor serial_;
  std::unique_ptr<haptic_node::HapticNode> node_;
  haptic_node::Outputs out_;
  core::PhysicsState state_;
  std::uint64_t tick_ = 0;
};

// Median of a step, which leaves out what the machine does besides.
double Median_us(Parts* parts, int steps) {
  std::vector<double> times;
  for (int i = 0; i < 100; ++i) parts->Step_us();
  for (int i = 0; i < steps; ++i) times.push_back(parts->Step_us());
  std::nth_element(times.begin(), times.begin() + steps / 2, times.end());
  return times[static_cast<std::size_t>(steps / 2)];
}

double Slowest_us(Parts* parts, int steps) {  // but for one in ten thousand
  std::vector<double> times;
  for (int i = 0; i < steps; ++i) times.push_back(parts->Step_us());
  const auto at = times.end() - 1 - steps / 10000;
  std::nth_element(times.begin(), at, times.end());
  return *at;
}

}  // namespace

void StudyPairs(Report* report) {
  Table table{"pairs", {"contender", "parts", "touching", "pairs", "step_us"}, {}};
  Panel panel;
  panel.title = "1 part touching";
  panel.x_title = "pairs";
  panel.y_title = "step of haptic_node [us]";
  Row idle{"F15",
           "many pairs",
           "10 to 300 parts of which up to 64 move at 0.1 m/s, 1 touching",
           "time for a further idle pair, of the steps with 10 and with 300 parts",
           "<= 50 ns",
           {},
           "a pair that is apart is compared at each step, and with the paper's method by its points"};
  Row active = idle;
  active.set_up = "30 parts, of which 1 to 10 touch";
  active.observable = "power of the number of touching pairs that the time for them grows with";
  active.bound = "<= 1.1";
  active.why = "caches overflow";
  Row slowest = idle;
  slowest.set_up = "100 parts, 10 touching, 30,000 steps";
  slowest.observable = "p99.99 of the step, processor time";
  slowest.bound = "< 1 ms";
  slowest.why = "time that the machine takes away counts as well";
  for (const Variant& variant : Variants()) {
    Series series{variant.name, {}, true};
    const auto measure = [&](int num_parts, int num_touching) {
      Parts parts(variant, num_parts, num_touching);
      const double step_us = Median_us(&parts, 1000);
      table.Add({variant.name, std::to_string(num_parts), std::to_string(parts.num_touching()),
                 std::to_string(parts.num_pairs()), bench::Cell(step_us)});
      if (num_touching == 1) series.points.push_back({static_cast<double>(parts.num_pairs()), step_us, ""});
      return std::pair(static_cast<double>(parts.num_pairs()), step_us);
    };
    const auto [few_pairs, few_us] = measure(10, 1);
    for (const int n : {30, 100}) measure(n, 1);
    const auto [many_pairs, many_us] = measure(300, 1);
    panel.series.push_back(series);
    const double idle_ns = 1e3 * (many_us - few_us) / (many_pairs - few_pairs);
    idle.readings.push_back({variant.name, Short(idle_ns) + " ns", idle_ns <= 50.0});
    const double none_us = measure(30, 0).second;
    const double one_us = measure(30, 1).second - none_us;
    const double ten_us = measure(30, 10).second - none_us;
    const double power = std::log10(ten_us / one_us);
    active.readings.push_back({variant.name, Short(power), power <= 1.1});
    Parts parts(variant, 100, 10);
    const double most_us = Slowest_us(&parts, 30000);
    slowest.readings.push_back({variant.name, Short(1e-3 * most_us) + " ms", most_us < 1000.0});
  }
  report->tables.push_back(table);
  report->charts.emplace_back("pairs", Chart{"F15: many pairs", "one thread", {panel}});
  for (const Row& row : {idle, active, slowest}) AddRow(report, row);
}

}  // namespace failures

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bus/rt/worker_pool.hpp"
#include "core/clock.hpp"
#include "tools/contact/studies.hpp"
#include "vps/multibody/collision_world.hpp"
#include "vps/testing/many_objects.hpp"
#include "vps/testing/shapes.hpp"

namespace contact {
namespace {

constexpr std::uint32_t kPoints = 65536;  // of each of the ten parts, as the goal says
constexpr double kVoxel_m = 5e-4;
constexpr int kCycles = 200;  // of a round: a fifth of a second of motion; not derived
constexpr double kPi = 3.14159265358979323846;

std::shared_ptr<const vps::CookedObject> CookShared(const vps::TriangleMesh& mesh, vps::Method method) {
  return std::make_shared<const vps::CookedObject>(*vps::Cook(mesh, {kVoxel_m, kPoints, method}));
}

// Ten objects, 45 pairs: a peg pressed in a block's hole is the pair with most contact, two balls touch the peg, six
// parts circle beside them. A step is 1 ms.
class TenParts {
 public:
  explicit TenParts(vps::Method method) {
    const auto block = CookShared(vps::MakeBlockWithHole(0.06, 0.04, 0.01005, 128), method);
    const auto peg = CookShared(vps::MakeCylinder(0.01, 0.06, 128), method);
    const auto ball = CookShared(vps::MakeSphere(0.005, 64), method);
    const auto ring = CookShared(vps::MakeTorus(0.03, 0.01, 96, 48), method);
    const auto box = CookShared(vps::MakeBox({0.05, 0.04, 0.03}), method);
    vps::WorldDescription description;
    description.method = method;
    description.objects = {{block, {}}, {peg, {}}, {ball, {}}, {ball, {}}};
    for (int i = 4; i < 10; ++i) description.objects.push_back({i % 2 == 0 ? ring : box, {}});
    for (std::size_t i = 0; i < 10; ++i) description.objects[i].X_WO = PoseAt(i, 0);
    for (std::uint16_t i = 0; i < 10; ++i) {
      for (std::uint16_t j = 0; j < i; ++j) description.pairs.push_back({.sampled = i, .field = j});
    }
    world_ = *vps::CollisionWorld::Create(description);
  }
  [[nodiscard]] vps::CollisionWorld& world() { return *world_; }
  void MoveTo(int step) {
    for (std::size_t i = 1; i < 10; ++i) world_->SetPose(i, PoseAt(i, step));
  }

 private:
  static core::Pose PoseAt(std::size_t i, int step) {
    if (i == 0) return {};
    const double t = 1e-3 * step;
    const core::Pose X_WPeg{core::QuaternionFromRotationVector({5e-4 * std::sin(9.0 * t), 0.0, 0.3 * std::sin(t)}),
                            {1.2e-4 * std::cos(7.0 * t), 1.2e-4 * std::sin(7.0 * t), 0.02 + 2e-3 * std::sin(5.0 * t)}};
    if (i == 1) return X_WPeg;
    if (i < 4) {
      const double side = i == 2 ? 1.0 : -1.0;
      return X_WPeg * core::Pose{{1, 0, 0, 0}, {side * (0.015 - 3e-4 - 1e-4 * std::sin(11.0 * t)), 0.0, 0.02}};
    }
    const double place = static_cast<double>(i - 4) * kPi / 3.0;
    return {core::QuaternionFromRotationVector({std::sin(t + place), 0.5 * std::cos(t), 0.0}),
            {0.3 * std::cos(place) + 0.05 * std::cos(t), 0.3 * std::sin(place), 0.05 * std::sin(t)}};
  }
  std::unique_ptr<vps::CollisionWorld> world_;
};

template <typename Scene>
std::vector<double> CycleTimes_us(Scene* scene, core::ParallelFor* workers, int first, int count, int stride) {
  std::vector<double> times;
  for (int k = 0; k < count; ++k) {
    scene->MoveTo(first + k * stride);
    const std::int64_t start_ns = core::MonotonicNow_ns();
    scene->world().Step(workers);
    times.push_back(1e-3 * static_cast<double>(core::MonotonicNow_ns() - start_ns));
  }
  return times;
}

void Append(std::vector<double>* all, const std::vector<double>& more) {
  all->insert(all->end(), more.begin(), more.end());
}

void StudyTen(Table* table, Report* report) {
  TenParts paper(vps::Method::kPaper);
  TenParts fast(vps::Method::kFast);
  core::SerialFor serial;
  bus::WorkerPool two(2, "scene");
  std::vector<double> of_paper, of_fast, of_two;
  {
    const OneCore pinned;
    for (int round = 0; round < 6; ++round) {
      Append(&of_paper, CycleTimes_us(&paper, &serial, round * kCycles, kCycles, 1));
      Append(&of_fast, CycleTimes_us(&fast, &serial, round * kCycles, kCycles, 1));
    }
  }
  std::vector<double> of_one;
  for (int round = 0; round < 6; ++round) {
    Append(&of_one, CycleTimes_us(&fast, &serial, round * kCycles, kCycles, 1));
    Append(&of_two, CycleTimes_us(&fast, &two, round * kCycles, kCycles, 1));
  }
  const auto add = [&](const char* method, int workers, const std::vector<double>& times) {
    table->Add({"10 objects, 3 touching", method, "10", std::to_string(workers), Cell(Quantile(times, 0.5)),
                Cell(Quantile(times, 0.99))});
    return Quantile(times, 0.5);
  };
  const double paper_us = add("paper", 1, of_paper);
  const double fast_us = add("fast", 1, of_fast);
  const double one_us = Quantile(of_one, 0.5);
  const double two_us = add("fast", 2, of_two);
  std::printf("10 objects: paper %s us, fast %s us; one worker %s, two %s us\n", Short(paper_us).c_str(),
              Short(fast_us).c_str(), Short(one_us).c_str(), Short(two_us).c_str());
  report->AddGoal("scene of 10 objects, 45 pairs, 3 touching, 64 k points: cycle against paper", "<= 1/4",
                  "1/" + Short(paper_us / fast_us) + " (" + Short(fast_us) + " us)", fast_us <= 0.25 * paper_us);
  report->AddGoal("the same: a second thread (a heavy pair dominates)", ">= 1.6 x", Short(one_us / two_us) + " x",
                  one_us / two_us >= 1.6);
}

// 100 objects that all move, far from each other: time of a step divided by its pairs.
void StudyIdle(Report* report) {
  constexpr std::uint16_t kObjects = 100;
  constexpr double kPairs = 0.5 * kObjects * (kObjects - 1);
  const auto part = CookShared(vps::MakeTorus(0.05, 0.02, 48, 24), vps::Method::kFast);
  vps::WorldDescription description;
  description.method = vps::Method::kFast;
  const auto pose_at = [](int i, double phase) {
    return core::Pose{{1, 0, 0, 0}, {0.5 * (i % 10) + 0.1 * std::sin(phase + i), 0.5 * (i / 10), 0.0}};
  };
  for (std::uint16_t i = 0; i < kObjects; ++i) {
    description.objects.push_back({part, pose_at(i, 0.0)});
    for (std::uint16_t j = 0; j < i; ++j) description.pairs.push_back({.sampled = i, .field = j});
  }
  const auto world = *vps::CollisionWorld::Create(description);
  core::SerialFor serial;
  const OneCore pinned;
  std::vector<double> times_ns;
  for (int step = 1; step <= 2000; ++step) {
    for (std::uint16_t i = 0; i < kObjects; ++i) world->SetPose(i, pose_at(i, 0.002 * step));
    const std::int64_t start_ns = core::MonotonicNow_ns();
    world->Step(&serial);
    times_ns.push_back(static_cast<double>(core::MonotonicNow_ns() - start_ns) / kPairs);
  }
  const double pair_ns = Quantile(times_ns, 0.5);
  report->AddGoal("idle pair in a scene of 100 moving objects: cycle by its 4,950 pairs", "<= 30 ns",
                  Short(pair_ns) + " ns", pair_ns <= 30.0);
}

void StudyMany(Table* table, Chart* chart, Report* report) {
  using vps::test::ManyObjects;
  Panel panel;
  panel.title = "20 to 100 objects, ten couples touching";
  panel.x_title = "pairs";
  panel.y_title = "cycle, median [us]";
  for (const vps::Method method : {vps::Method::kPaper, vps::Method::kFast}) {
    const bool is_fast = method == vps::Method::kFast;
    panel.series.push_back({is_fast ? "fast" : "paper", {}, true});
    const ManyObjects::Parts parts = ManyObjects::CookParts(method, kPoints / 4, 1e-3);
    core::SerialFor serial;
    for (const std::size_t count : {20, 40, 60, 80, 100}) {
      ManyObjects scene(method, parts, count, 0);
      const OneCore pinned;
      CycleTimes_us(&scene, &serial, 0, 20, 5);
      // A pose's time is the smallest of five passes, which leaves out interrupts of the operating system.
      std::vector<double> best(ManyObjects::kPeriod / 10, 1e30);
      for (int pass = 0; pass < 5; ++pass) {
        const auto times = CycleTimes_us(&scene, &serial, 0, static_cast<int>(best.size()), 10);
        for (std::size_t i = 0; i < best.size(); ++i) best[i] = std::min(best[i], times[i]);
      }
      const double pairs = 0.5 * static_cast<double>(count * (count - 1));
      panel.series.back().points.push_back({pairs, Quantile(best, 0.5), ""});
      table->Add({std::to_string(count) + " objects, 10 touching", is_fast ? "fast" : "paper", std::to_string(count),
                  "1", Cell(Quantile(best, 0.5)), Cell(Quantile(best, 1.0))});
      if (is_fast && count == 100) {
        std::printf("100 objects: median %s us, worst pose %s us\n", Short(Quantile(best, 0.5)).c_str(),
                    Short(Quantile(best, 1.0)).c_str());
        report->AddGoal("100 objects, 4,950 pairs, 10 touching, 16 k points: cycle at every pose, best of 5 passes",
                        "<= 500 us", Short(Quantile(best, 1.0)) + " us at the worst pose",
                        Quantile(best, 1.0) <= 500.0);
      }
    }
  }
  chart->panels.push_back(panel);
}

}  // namespace

void StudyScene(Report* report) {
  Table table{"scene", {"scene", "method", "objects", "workers", "p50_us", "p99_or_worst_us"}, {}};
  Chart chart{"Cycle of a world of many pairs",
              "one core, 16k points each, s = 1 mm; median over poses of the best of five passes",
              {}};
  StudyTen(&table, report);
  StudyMany(&table, &chart, report);
  StudyIdle(report);
  Panel ten;
  ten.title = "10 objects, 45 pairs, 3 touching, 64k points, s = 0.5 mm";
  ten.x_title = "cycle, median [us]";
  for (const auto& row : table.rows) {
    if (row[2] != "10") continue;
    const std::string label = row[1] + (row[3] == "2" ? ", 2 threads" : "");
    const double us = std::atof(row[4].c_str());
    ten.bars.push_back({label, us, Short(us), row[1]});
  }
  ten.x_log = false;
  chart.panels.push_back(ten);
  report->tables.push_back(table);
  report->charts.emplace_back("scene", chart);
}

}  // namespace contact

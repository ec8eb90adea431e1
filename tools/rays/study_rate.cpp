#include <sched.h>

#include <array>
#include <cmath>
#include <string>

#include "bus/membership/registry.hpp"
#include "core/clock.hpp"
#include "nodes/rt_visual_node/exchange.hpp"
#include "scene/load_scenario.hpp"
#include "tiles/frame.hpp"
#include "tools/process/group.hpp"
#include "tools/rays/studies.hpp"
#include "view/projection.hpp"
#include "view/scene_mirror.hpp"

namespace rays {
namespace {

constexpr int kWidth = 1280, kHeight = 720;
constexpr std::uint64_t kSession = 12;
constexpr double kWarm_s = 1.0, kMeasured_s = 4.0, kPatience_s = 20.0;
constexpr int kRounds = 2;  // all rows in turn, so that a busy moment hits all alike

struct Setup {
  const char* name;
  std::size_t workers;
  tiles::Mirrors mirrors;
  double frames_per_s = 0.0, cores_ms = 0.0;
};

process::Command WorkerOf(const scene::Scenario& scenario, const std::filesystem::path& programs,
                          const std::string& registry, std::size_t seat) {
  process::Command worker;
  worker.name = tiles::WorkerName("visual_node", seat);
  worker.program = programs / "rt_worker";
  worker.arguments = {"--name",     worker.name, "--scenario",     scenario.file.string(),
                      "--registry", registry,    "--session",      std::to_string(kSession),
                      "--out",      "/tmp",      "--no_encryption"};
  worker.log = "/dev/null";
  return worker;
}

// The scene as the views of a procedure show it one after the other, with everything in motion.
rt_visual_node::Wish NextWish(view::Scene scene, double time_s, tiles::Mirrors mirrors) {
  for (view::Instance& instance : scene.instances) {
    if (!instance.is_scenery) instance.X_WM.translation.z += 5e-3 * std::sin(6.0 * time_s);
  }
  const auto& cameras = scene.assets->cameras;
  const std::size_t camera =
      static_cast<std::size_t>(std::max(time_s, 0.0) / kMeasured_s * static_cast<double>(cameras.size())) %
      cameras.size();
  const scene::Camera placed = view::PlaceCamera(cameras[camera], scene);
  rt_visual_node::Wish wish{.frame = tiles::EncodeFrame(scene, view::LightOf(scene.space), placed, kWidth, kHeight),
                            .scene = scene,
                            .camera = placed};
  wish.frame.mirrors = static_cast<std::uint8_t>(mirrors);
  return wish;
}

// False: the workers did not come.
bool Measure(const scene::Scenario& scenario, const std::filesystem::path& programs, Setup* setup) {
  auto registry = bus::Registry::Create({.endpoint = "tcp://127.0.0.1:0", .session = kSession, .is_encrypted = false});
  if (!registry) return false;
  bus::NodeOptions options;
  options.name = "visual_node";
  options.registry = (*registry)->endpoint();
  options.session = kSession;
  options.is_encrypted = false;
  rt_visual_node::Exchange exchange(options);
  if (!exchange.Start()) return false;
  process::Group group;
  for (std::size_t seat = 1; seat <= setup->workers; ++seat) {
    if (!group.Spawn(WorkerOf(scenario, programs, options.registry, seat))) return false;
  }
  const view::SceneMirror mirror(scenario);
  const auto seconds_since = [](std::int64_t since_ns) {
    return 1e-9 * static_cast<double>(core::MonotonicNow_ns() - since_ns);
  };
  const std::int64_t start_ns = core::MonotonicNow_ns();
  std::int64_t begin_ns = 0;
  std::uint64_t frames = 0;
  double cost_s = 0.0;
  for (double time_s = -kWarm_s; time_s < kMeasured_s;) {
    exchange.Want(NextWish(mirror.scene(), time_s, setup->mirrors));
    const auto drawn = exchange.Take(core::MonotonicNow_ns() + 5'000'000);
    if (begin_ns == 0 && exchange.figures().workers == setup->workers) begin_ns = core::MonotonicNow_ns();
    if (begin_ns == 0 && seconds_since(start_ns) > kPatience_s) return false;
    if (begin_ns != 0) time_s = seconds_since(begin_ns) - kWarm_s;
    if (drawn == nullptr || time_s <= 0.0) continue;
    ++frames;
    cost_s += drawn->cost_s;
  }
  setup->frames_per_s += static_cast<double>(frames) / kMeasured_s / kRounds;
  setup->cores_ms += 1e3 * cost_s / static_cast<double>(std::max<std::uint64_t>(frames, 1)) / kRounds;
  return true;
}

}  // namespace

void StudyRate(const std::filesystem::path& programs, const std::filesystem::path& scenarios, bench::Report* report) {
  const auto scenario = scene::LoadScenario(scenarios / "module_replacement");
  if (!scenario) {
    report->skipped.push_back("rate: " + scene::Format(scenario.error().front()));
    return;
  }
  std::array<Setup, 4> setups = {{{"1 worker, half mirrors", 1, tiles::Mirrors::kHalf},
                                  {"2 workers, half mirrors", 2, tiles::Mirrors::kHalf},
                                  {"2 workers, no mirrors", 2, tiles::Mirrors::kNone},
                                  {"2 workers, all mirrors", 2, tiles::Mirrors::kAll}}};
  for (int round = 0; round < kRounds; ++round) {
    for (Setup& setup : setups) {
      if (Measure(*scenario, programs, &setup)) continue;
      report->skipped.push_back(std::string("rate: ") + setup.name + ": rt_worker is not beside this program");
      return;
    }
  }
  bench::Table table{"rate", {"setup", "workers", "frames_per_s", "cores_ms"}, {}};
  bench::Panel panel;
  panel.y_title = "frames per second";
  panel.x_log = panel.y_log = false;
  for (const Setup& setup : setups) {
    table.Add({setup.name, bench::Cell(static_cast<double>(setup.workers)), bench::Cell(setup.frames_per_s),
               bench::Cell(setup.cores_ms)});
    panel.bars.push_back({setup.name, setup.frames_per_s, bench::Short(setup.frames_per_s),
                          setup.workers == 1 ? "1 worker" : "2 workers"});
  }
  report->tables.push_back(std::move(table));
  report->charts.emplace_back(
      "rate", bench::Chart{"Frames of 1280x720", "one sample, hard shadows; nothing is drawn over them", {panel}});
  const double one = setups[0].frames_per_s, two = setups[1].frames_per_s, plain = setups[2].frames_per_s;
  report->AddGoal("1280x720, hard shadow, 2 workers, frames per second", ">= 7", bench::Short(plain), plain >= 7.0);
  report->AddGoal("the same with half-resolution mirror images", ">= 12", bench::Short(two), two >= 12.0);
  report->AddGoal("2 workers against 1", ">= 1.7", bench::Short(two / one), two >= 1.7 * one);
}

}  // namespace rays

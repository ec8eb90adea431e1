#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <vector>

#include "nodes/device_bridge/device_bridge.hpp"

namespace device_bridge {
namespace {

// The bridge's share of t1: a tick of a bridge with the two arms of a simulated HUG, and what it does for the two
// commands that come between ticks. With --benchmark_min_time=20 its p99 is that of 20,000 ticks or more.
void BM_TwoArms(benchmark::State& state) {
  scene::Scenario scenario;
  scenario.name = "bench";
  for (const char* role : {"right", "left"}) {
    scene::Device device;
    device.role = role;
    device.type = "hug";
    device.X_WD_start.translation = {role[0] == 'r' ? 0.25 : -0.25, 0.05, 0.25};
    for (const auto& [name, value] : {std::pair{"hug_x_m", "0"}, {"hug_y_m", "-0.53"}, {"hug_z_m", "0.05"}}) {
      device.options.emplace_back(name, value);
    }
    scenario.devices.push_back(device);
  }
  scenario.operator_script = std::filesystem::temp_directory_path() / "two_arms_bench.txt";
  std::ofstream(scenario.operator_script) << "";
  Options options;
  options.num_echoes = 1'000'000;
  auto made = DeviceBridge::Create(scenario, 1, options);
  if (!made) {
    state.SkipWithError(made.error().detail.c_str());
    return;
  }
  DeviceBridge& bridge = **made;
  Inputs inputs;
  Outputs outputs;
  core::DeviceCommand command;
  std::int64_t now_ns = 1'000'000'000;
  const auto tick = [&] {
    inputs.now_ns = now_ns;
    bridge.Step(inputs, &outputs);
    for (std::size_t role = 0; role < 2; ++role) {
      command.header.sequence = static_cast<std::uint64_t>(now_ns);
      command.header.direct = outputs.states[role].header.direct;
      command.role_index = static_cast<std::uint8_t>(role);
      command.F_Do_W.force_N = {1.0, 2.0, 3.0};
      bridge.AcceptCommand(role, command, now_ns, now_ns);
    }
    now_ns += 1'000'000;
  };
  for (int i = 0; i < 3000; ++i) tick();  // until both arms give force
  std::vector<double> us;
  us.reserve(1 << 22);
  for (auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    tick();
    us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
  }
  std::sort(us.begin(), us.end());
  state.counters["p50_us"] = us[us.size() / 2];
  state.counters["p99_us"] = us[us.size() * 99 / 100];
  state.counters["max_us"] = us.back();
}
BENCHMARK(BM_TwoArms)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace device_bridge

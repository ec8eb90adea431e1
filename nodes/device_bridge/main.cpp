// device_bridge --scenario FILE --registry ENDPOINT --session N --out DIR [--seed N] [--rt try|off|enforce]
//   --keys DIR | --no_encryption  keys of the run, bus/keys.hpp
//   [--bind ADDRESS]  of this machine, where the others reach it

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "bus/log/node_recording.hpp"
#include "bus/node_arguments.hpp"
#include "bus/rt/thread_setup.hpp"
#include "core/clock.hpp"
#include "nodes/device_bridge/device_bridge.hpp"
#include "nodes/device_bridge/node_loop.hpp"
#include "scene/load_scenario.hpp"

namespace {

// Above the haptic node: a sample or a write takes some microseconds and starts or closes the loop.
constexpr int kPriority = 85;

std::atomic<bool> stop{false};
void OnSignal(int) {
  stop.store(true);
}

int Complain(const std::string& what, int status) {
  std::fprintf(stderr, "device_bridge: %s\n", what.c_str());
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  const bus::NodeArguments defaults = {{"--rt", "try"}};
  auto parsed = bus::ParseNodeArguments(argc, argv, defaults);
  if (!parsed) return Complain(parsed.error().detail, 2);
  bus::NodeArguments& options = *parsed;
  bus::RealTimeMode mode{};
  if (!bus::ParseRealTimeMode(options["--rt"], &mode)) return Complain("--rt is off, try or enforce", 2);
  std::signal(SIGTERM, OnSignal);
  std::signal(SIGINT, OnSignal);

  const auto scenario = scene::LoadScenario(options["--scenario"]);
  if (!scenario) {
    for (const scene::Diagnostic& diagnostic : scenario.error()) Complain(scene::Format(diagnostic), 2);
    return 2;
  }
  const std::uint64_t seed =
      options.count("--seed") != 0 ? std::strtoull(options["--seed"].c_str(), nullptr, 10) : scenario->seed;
  device_bridge::Options bridge_options;
  bridge_options.clock = core::MonotonicNow_ns;
  auto bridge = device_bridge::DeviceBridge::Create(*scenario, seed, bridge_options);
  if (!bridge) return Complain(bridge.error().detail, 2);

  const bus::NodeOptions node_options = bus::MakeNodeOptions("device_bridge", options);
  auto recording = bus::log::StartRecording(node_options.name, options);
  if (!recording) return Complain(recording.error().detail, 1);
  auto node = bus::Node::Create(bus::log::WithTap(node_options, recording->get()));
  if (!node) return Complain(node.error().detail, 1);
  device_bridge::NodeLoop loop(*scenario, bridge->get(), node->get());
  loop.Declare();
  if (const auto started = (*node)->Start(); !started) return Complain(started.error().detail, 1);

  bus::ThreadSetup setup;
  setup.name = "device-rt";
  setup.mode = mode;
  setup.fifo_priority = kPriority;
  const bus::ThreadReport thread = bus::SetUpThread(setup);
  std::printf("%s\n", thread.text.c_str());
  for (std::size_t role = 0; role < scenario->devices.size(); ++role) {
    std::printf("role %s: %s\n", scenario->devices[role].role.c_str(), (*bridge)->device(role).description());
  }
  std::printf("seed %llu\nready\n", static_cast<unsigned long long>(seed));
  std::fflush(stdout);
  if (!thread.is_ok) return 1;
  (*node)->Emit({core::MonotonicNow_ns(), "device_bridge", "ready", "devices are simulated"});
  loop.Run(stop);
  if (const auto stopped = bus::log::StopRecording(recording->get()); !stopped)
    return Complain(stopped.error().detail, 1);
  if (const auto written = loop.WriteReport(options["--out"], thread.is_fifo); !written) {
    return Complain(written.error().detail, 1);
  }
  return 0;
}

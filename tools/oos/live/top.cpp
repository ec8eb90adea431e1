#include <unistd.h>

#include <cstdio>
#include <map>

#include "bus/wire/codec.hpp"
#include "core/clock.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/live/verbs.hpp"

namespace oos {
namespace {

constexpr std::int64_t kRefresh_ns = core::kNanosecondsPerSecond;
constexpr const char* kWatched[] = {"device_bridge", "haptic_node", "physics_node", "logic_node", "visual_node"};

using Devices = std::map<std::string, core::DeviceHealth>;  // by their topics

// Takes what has come since the last call: which roles there are, only the session knows.
void Update(bus::Node* node, Devices* devices) {
  bus::Observation seen;
  while (node->PollObservation(&seen)) {
    core::DeviceHealth health;
    if (bus::DecodeState(seen.payload, &health)) (*devices)[seen.topic] = health;
  }
}

void Show(const core::DeviceHealth& device, const std::string& topic) {
  std::printf("%s: %s%s%s  %s%s  link %s  %.0f Hz  jitter %.2f ms  lost %.2f %%  round trip %.2f ms", topic.c_str(),
              device.name.empty() ? "none" : device.name.c_str(), device.serial.empty() ? "" : " ",
              device.serial.c_str(), device.status.c_str(), device.is_engaged ? ", held" : "", device.quality.c_str(),
              device.rate_hz, 1e3 * device.jitter_s, 1e2 * device.loss, 1e3 * device.round_trip_s);
  if (device.is_calibrated) std::printf("  calibrated to %.2f mm", 1e3 * device.residual_m);
  if (!device.why.empty()) std::printf("  %s", device.why.c_str());
  std::printf("\n");
}

void Show(const bus::Node& node, const bus::StateReader<core::LogicStatus>& status,
          const std::vector<bus::StateReader<bus::Figures>*>& figures, const Devices& devices) {
  if (status.has_value()) {
    std::printf("%.1f s  step %s  %s\n", static_cast<double>(status.value().time_ns) * 1e-9,
                status.value().step.c_str(), status.value().hint.c_str());
  }
  std::printf("%-16s %8s %8s %10s %12s %12s %9s %9s\n", "node", "state", "age ms", "pid", "sent", "received", "dropped",
              "refused");
  for (const bus::PeerStatus& peer : node.Peers()) {
    if (peer.is_observer) continue;
    std::printf(
        "%-16s %8s %8.0f %10u %12llu %12llu %9llu %9llu\n", peer.name.c_str(),
        !peer.is_alive    ? "LOST"
        : peer.is_stalled ? "STALLED"
                          : "alive",
        static_cast<double>(peer.age_ns) * 1e-6, peer.process_id, static_cast<unsigned long long>(peer.counters.sent),
        static_cast<unsigned long long>(peer.counters.received), static_cast<unsigned long long>(peer.counters.dropped),
        static_cast<unsigned long long>(peer.counters.refused));
    if (peer.clock_bound_ns == INT64_MAX) {
      std::printf("%-16s clock not compared yet\n", "");
    } else if (peer.clock_bound_ns > 0) {
      std::printf("%-16s clock %+.6f s +- %.1f us, drift %+.1f ppm\n", "",
                  static_cast<double>(peer.clock_offset_ns) * 1e-9, static_cast<double>(peer.clock_bound_ns) * 1e-3,
                  peer.clock_drift_ppm);
    }
  }
  // Peers report only the sum of their refusals; those of this node are known by reason.
  const bus::Counters own = node.counters();
  if (own.refused > 0) {
    std::printf("refused by %s:", node.name().c_str());
    for (const bus::RefusalCount& refusal : own.refusals) {
      std::printf("  %s %llu", refusal.reason.c_str(), static_cast<unsigned long long>(refusal.count));
    }
    std::printf("\n");
  }
  for (const auto& [topic, device] : devices) Show(device, topic);
  for (std::size_t i = 0; i < figures.size(); ++i) {
    if (!figures[i]->has_value()) continue;
    std::printf("%s:", kWatched[i]);
    for (const bus::Figure& figure : figures[i]->value().items)
      std::printf("  %s %.4g", figure.name.c_str(), figure.value);
    std::printf("\n");
  }
  std::fflush(stdout);
}

int RunTop(const Arguments& arguments) {
  const auto count = arguments.number("--count");
  if (!count) return Complain("top", count.error().detail, kBadUsage);
  auto node = Attach(arguments, "top");
  if (!node) return Complain("top", node.error().detail, kDoesNotHold);
  auto& status = (*node)->ReadState<core::LogicStatus>(bus::kLogicStatusTopic);
  std::vector<bus::StateReader<bus::Figures>*> figures;
  for (const char* name : kWatched) figures.push_back(&(*node)->ReadState<bus::Figures>(bus::FiguresTopic(name)));
  (*node)->Observe("device/*/health");
  Devices devices;
  if (const auto started = (*node)->Start(5'000'000'000); !started) {
    return Complain("top", started.error().detail, kDoesNotHold);
  }
  const std::atomic<int>& interrupted = CatchInterrupt();
  const bool is_terminal = isatty(STDOUT_FILENO) != 0;
  const double num_screens = count->value_or(1e18);
  for (double screen = 0; interrupted.load() == 0 && screen < num_screens; ++screen) {
    const std::int64_t until_ns = core::MonotonicNow_ns() + kRefresh_ns;
    while (interrupted.load() == 0 && core::MonotonicNow_ns() < until_ns) {
      (*node)->Wait(until_ns);
      Update(node->get(), &devices);
    }
    if (is_terminal) std::printf("\033[H\033[J");
    Show(**node, status, figures, devices);
  }
  return kHolds;
}

}  // namespace

Verb TopVerb() {
  std::vector<Option> options = AttachOptions();
  options.push_back({"--count", "N", "stop after N screens, one a second"});
  return {"top", "shows the nodes of the running session: liveness, devices, message counts, drops, figures",
          "",    0,
          0,     options,
          RunTop};
}

}  // namespace oos

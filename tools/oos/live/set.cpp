#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "core/names.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/live/verbs.hpp"

namespace oos {
namespace {

constexpr std::int64_t kPatience_ns = 2'000'000'000;

void PrintChange(const core::ParameterChange& change, const bus::ParameterAck& ack) {
  const auto tick = static_cast<unsigned long long>(ack.tick);
  if (!ack.is_pending) {
    std::printf("%s = %g, applied at tick %llu of %s", change.name.c_str(), change.value, tick, ack.owner.c_str());
    if (ack.injected_J != 0.0) std::printf(", injected %.6g J", ack.injected_J);
    std::printf("\n");
  } else if (change.manner == core::ChangeManner::kRamped) {
    std::printf("%s goes to %g in %g s from tick %llu of %s\n", change.name.c_str(), change.value, change.ramp_s, tick,
                ack.owner.c_str());
  } else {
    std::printf("%s = %g is held at tick %llu of %s until it adds no energy; the event parameter_settled follows\n",
                change.name.c_str(), change.value, tick, ack.owner.c_str());
  }
  std::fflush(stdout);
}

int AwaitEnd(bus::Node* node, const core::ParameterChange& change) {
  const std::int64_t deadline_ns =
      core::MonotonicNow_ns() + static_cast<std::int64_t>(change.ramp_s * 1e9) + kPatience_ns;
  core::Event event;
  while (core::MonotonicNow_ns() < deadline_ns) {
    node->Wait(core::MonotonicNow_ns() + 10'000'000);
    while (node->PollEvent(&event)) {
      if (event.name != "parameter_settled" || !event.detail.starts_with(change.name + " ")) continue;
      std::printf("%s\n", event.detail.c_str());
      return kHolds;
    }
  }
  return Complain("set", change.name + ": no event parameter_settled has arrived", kDoesNotHold);
}

int RunSet(const Arguments& arguments) {
  const std::string& path = arguments.positional()[0];
  const std::string& text = arguments.positional()[1];
  const std::size_t dot = path.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == path.size()) {
    return Complain("set", "name NODE.PARAM, e.g. haptic_node.force_cap_N", kBadUsage);
  }
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0') return Complain("set", "'" + text + "' is not a number", kBadUsage);

  core::ParameterChange change{path.substr(dot + 1), value};
  const auto over_s = arguments.number("--over_s");
  if (!over_s || (*over_s && !(**over_s > 0.0)) || (*over_s && arguments.has("--when_separated"))) {
    return Complain("set", "--over_s needs a time above 0 in seconds, and excludes --when_separated", kBadUsage);
  }
  if (*over_s) {
    change.manner = core::ChangeManner::kRamped;
    change.ramp_s = **over_s;
  }
  if (arguments.has("--when_separated")) change.manner = core::ChangeManner::kWhenSeparated;

  auto node = Attach(arguments, "set");
  if (!node) return Complain("set", node.error().detail, kDoesNotHold);
  (*node)->ReadEvents();
  if (const auto started = (*node)->Start(5'000'000'000); !started) {
    return Complain("set", started.error().detail, kDoesNotHold);
  }
  const std::string owner = path.substr(0, dot);
  // The registry has named every node by now; observers like this one have no parameters.
  std::vector<std::string> nodes;
  for (const bus::PeerStatus& peer : (*node)->Peers()) {
    if (!peer.is_observer) nodes.push_back(peer.name);
  }
  if (std::find(nodes.begin(), nodes.end(), owner) == nodes.end()) {
    return Complain("set", "no node is called '" + owner + "'; " + core::SuggestName(owner, nodes), kDoesNotHold);
  }
  if (const auto alive = (*node)->WaitForPeers({owner}, 2'000'000'000); !alive) {
    return Complain("set", alive.error().detail, kDoesNotHold);
  }
  const auto ack = (*node)->SetParameter(owner, change, 2'000'000'000);
  if (!ack) return Complain("set", ack.error().detail, kDoesNotHold);
  PrintChange(change, *ack);
  if (ack->is_pending && change.manner == core::ChangeManner::kRamped) return AwaitEnd(node->get(), change);
  return kHolds;
}

std::vector<Option> Options() {
  std::vector<Option> options = AttachOptions();
  options.push_back(
      {"--over_s", "S", "change linearly within this time, and wait for its end; for parameters of mechanisms"});
  options.push_back({"--when_separated", "", "hold the change until it adds no energy; for parameters of mechanisms"});
  return options;
}

}  // namespace

Verb SetVerb() {
  return {"set",
          "changes a parameter of a running node; prints the tick at which it was applied",
          "NODE.PARAM VALUE",
          2,
          2,
          Options(),
          RunSet};
}

}  // namespace oos

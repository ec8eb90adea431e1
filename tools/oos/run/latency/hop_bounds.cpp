#include "tools/oos/run/latency/hop_bounds.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

namespace oos {
namespace {

constexpr const char* kStampingNodes[] = {"device_bridge", "haptic_node", "physics_node", "visual_node"};

std::string NodeOf(core::Stage stage) {
  switch (stage) {
    case core::Stage::kDeviceSample:
    case core::Stage::kDeviceSend:
    case core::Stage::kDeviceReceive:
    case core::Stage::kDeviceWrite:
      return "device_bridge";
    case core::Stage::kHapticReceive:
    case core::Stage::kHapticStart:
    case core::Stage::kHapticSend:
      return "haptic_node";
    case core::Stage::kPhysicsReceive:
    case core::Stage::kPhysicsStart:
    case core::Stage::kPhysicsSend:
      return "physics_node";
    case core::Stage::kVisualReceive:
    case core::Stage::kVisualApply:
    case core::Stage::kFrameStart:
    case core::Stage::kFrameDone:
      return "visual_node";
  }
  return {};
}

}  // namespace

HopBounds HopBounds::Read(const std::filesystem::path& folder) {
  HopBounds bounds;
  bounds.is_one_machine_ = !std::filesystem::exists(folder / "clocks.csv");
  for (const char* node : kStampingNodes) {
    std::ifstream file(folder / (std::string(node) + ".json"));
    const nlohmann::json report = nlohmann::json::parse(file, nullptr, false);
    if (!report.is_object() || !report.contains("clock_bounds_ns")) continue;
    bounds.bounds_[node] = report["clock_bounds_ns"].get<std::map<std::string, std::int64_t>>();
  }
  return bounds;
}

std::optional<std::int64_t> HopBounds::Between(core::Stage from, core::Stage to) const {
  const std::string sender = NodeOf(from), receiver = NodeOf(to);
  if (is_one_machine_ || sender == receiver) return 0;
  const auto node = bounds_.find(receiver);
  if (node == bounds_.end()) return std::nullopt;
  const auto bound = node->second.find(sender);
  if (bound == node->second.end()) return std::nullopt;
  return bound->second;
}

std::optional<std::int64_t> HopBounds::Along(const core::Trace& trace) const {
  std::int64_t sum_ns = 0;
  for (std::size_t i = 0; i + 1 < trace.stamps.size(); ++i) {
    const auto hop_ns = Between(trace.stamps[i].stage, trace.stamps[i + 1].stage);
    if (!hop_ns) return std::nullopt;
    sum_ns += *hop_ns;
  }
  return sum_ns;
}

}  // namespace oos

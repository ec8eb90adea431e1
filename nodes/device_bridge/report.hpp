#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "core/result.hpp"
#include "nodes/device_bridge/device_bridge.hpp"

namespace device_bridge {

// The bridge's part of a run's report: forces, filter, echo log, lines of the operator. Without bus and timing figures.
nlohmann::json MakeReport(const DeviceBridge& bridge);

// CSV with one row per stamped trace that returned: chain (direct or t1), trace id, origin, this log's latency, then
// stage number and offset from the origin [ns] of each stamp. Error: kIo.
core::Result<void> WriteLatencyTable(const EchoLog& log, const std::filesystem::path& file);

// Names of the bits that are set, e.g. {"degraded", "dead_man"}.
std::vector<std::string> StatusNames(std::uint32_t status);

}  // namespace device_bridge

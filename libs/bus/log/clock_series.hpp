#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bus/log/mcap_records.hpp"
#include "core/result.hpp"

namespace bus::log {

// How machines' clocks compare, from the clock samples of recordings: what one node measured of another at times of its
// own clock. The true offset is within the bound.
class ClockSeries {
 public:
  struct Sample {
    std::int64_t time_ns = 0;    // of the machine that measured
    std::int64_t offset_ns = 0;  // measured machine's clock minus its own
    std::int64_t bound_ns = 0;
  };

  // `node` runs on `machine`.
  void AddNode(const std::string& node, const std::string& machine);
  void Add(const std::string& node, const std::string& peer, const Sample& sample);

  // Chooses the machine whose clock counts. Errors: kInvalidInput, naming a machine of which no node has measured the
  // way to it.
  core::Result<void> SetReference(const std::string& machine);

  // A time of this node's (or machine's) clock as the reference's.
  [[nodiscard]] std::int64_t ToReference(const std::string& machine, std::int64_t time_ns) const;
  [[nodiscard]] std::optional<std::string> MachineOf(const std::string& node) const;
  // Largest bound of the samples that lead from the machine to the reference; 0 for one machine.
  [[nodiscard]] std::int64_t BoundOf(const std::string& machine) const;

 private:
  struct Link {  // from a machine to one that is nearer to the reference
    std::string next;
    std::vector<Sample> samples;  // by time of `from`; next's clock = from's + offset
  };
  std::map<std::string, std::string> machines_;                                  // by node
  std::map<std::pair<std::string, std::string>, std::vector<Sample>> measured_;  // by node, peer
  std::map<std::string, Link> ways_;                                             // by machine
};

}  // namespace bus::log

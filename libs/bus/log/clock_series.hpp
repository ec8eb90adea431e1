#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bus/log/mcap_records.hpp"
#include "core/result.hpp"

namespace bus::log {

// Offsets between machines' clocks over time, from the clock samples of recordings: each is measured by one node of a
// peer, at a time of its own clock. The true offset is within the bound.
class ClockSeries {
 public:
  struct Sample {
    std::int64_t time_ns = 0;    // of the machine that measured
    std::int64_t offset_ns = 0;  // measured machine's clock minus its own
    std::int64_t bound_ns = 0;
  };

  // Declares that `node` runs on `machine`.
  void AddNode(const std::string& node, const std::string& machine);
  void Add(const std::string& node, const std::string& peer, const Sample& sample);

  // Chooses the machine whose clock is the reference. Errors: kInvalidInput, naming a machine that no chain of
  // measurements connects to it.
  core::Result<void> SetReference(const std::string& machine);

  // Converts a time of the machine's clock to the reference's [ns].
  [[nodiscard]] std::int64_t ToReference(const std::string& machine, std::int64_t time_ns) const;
  [[nodiscard]] std::optional<std::string> MachineOf(const std::string& node) const;
  // Largest bound of the samples that connect the machine to the reference [ns]; 0 for the reference itself.
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

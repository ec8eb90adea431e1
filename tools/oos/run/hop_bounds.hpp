#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/messages/trace.hpp"

namespace oos {

// Within how much the times of the nodes of a run can be compared, by what each node wrote of its peers' clocks. A
// stamp arrives on the receiver's clock (libs/bus), so a hop between two nodes is wrong by no more than the receiver's
// bound of the sender, and a hop within a node is exact.
class HopBounds {
 public:
  // Of a run's folder. A run of one machine has one clock; one of several (it has clocks.csv) only what is written.
  static HopBounds Read(const std::filesystem::path& folder);

  // [ns]; none: the two clocks were not compared, and nothing can be said of the hop.
  [[nodiscard]] std::optional<std::int64_t> Between(core::Stage from, core::Stage to) const;
  // Of a whole trace: the sum of its hops' bounds.
  [[nodiscard]] std::optional<std::int64_t> Along(const core::Trace& trace) const;
  [[nodiscard]] bool is_one_machine() const { return is_one_machine_; }

 private:
  std::map<std::string, std::map<std::string, std::int64_t>> bounds_;  // by node, then peer
  bool is_one_machine_ = true;
};

}  // namespace oos

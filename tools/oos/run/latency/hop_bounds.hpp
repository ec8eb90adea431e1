#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/messages/trace.hpp"

namespace oos {

// Error bounds of latencies between a run's nodes, from what each node recorded of its peers' clocks. The bus converts
// a stamp to the receiver's clock, so a hop between two nodes is wrong by at most the receiver's bound for the sender's
// clock; a hop within a node is exact.
class HopBounds {
 public:
  // Reads a run's folder. A run on one machine has one clock; one on several (it has clocks.csv) has the recorded
  // bounds.
  static HopBounds Read(const std::filesystem::path& folder);

  // Bound of a hop [ns]; none if the two clocks were not compared.
  [[nodiscard]] std::optional<std::int64_t> Between(core::Stage from, core::Stage to) const;
  // Bound of a whole trace [ns]: the sum of its hops' bounds.
  [[nodiscard]] std::optional<std::int64_t> Along(const core::Trace& trace) const;
  [[nodiscard]] bool is_one_machine() const { return is_one_machine_; }

 private:
  std::map<std::string, std::map<std::string, std::int64_t>> bounds_;  // by node, then peer
  bool is_one_machine_ = true;
};

}  // namespace oos

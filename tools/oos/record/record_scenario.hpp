#pragma once

#include <cstdint>
#include <future>
#include <string>
#include <vector>

#include "bus/bulk/bulk.hpp"
#include "bus/log/mcap_records.hpp"
#include "bus/node.hpp"

namespace oos {

// Fetches the text files of the session's scenario from the node that offers them (BULK), on a thread of its own.
class SessionScenario {
 public:
  static constexpr const char* kOwner = "logic_node";
  static constexpr const char* kFile = "scenario.xml";

  // `node` is not started yet and outlives this; `options` are its own.
  SessionScenario(bus::Node* node, bus::NodeOptions options);

  // Makes progress without waiting. Returns the texts once, when all have arrived; otherwise nothing.
  std::vector<bus::log::Attachment> Take(std::int64_t now_ns);

 private:
  // Fetches the texts on offer. Empty if there are none, or if they cannot be fetched now.
  using Texts = std::vector<bus::log::Attachment>;
  static Texts Fetch(const std::vector<bus::BulkOffer>& offers, const bus::NodeOptions& options);

  const bus::StateReader<bus::BulkOffer>& offers_;
  bus::NodeOptions options_;
  std::future<Texts> fetched_;
  std::int64_t next_ns_ = 0;  // not before
  bool is_offered_ = false, is_done_ = false;
};

}  // namespace oos

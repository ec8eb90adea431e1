#pragma once

#include <cstdint>
#include <future>
#include <string>
#include <vector>

#include "bus/bulk.hpp"
#include "bus/log/mcap_records.hpp"
#include "bus/node.hpp"

namespace oos {

// The texts of the session's scenario, from the node that offers them (BULK), while something else goes on. The blocks
// are fetched by a thread of its own.
class SessionScenario {
 public:
  static constexpr const char* kOwner = "logic_node";
  static constexpr const char* kFile = "scenario.xml";

  // `node` is not started yet and outlives this; `options` are its own.
  SessionScenario(bus::Node* node, bus::NodeOptions options);

  // Goes on, without waiting. The texts, once: when all are here.
  std::vector<bus::log::Attachment> Take(std::int64_t now_ns);

 private:
  // Those that can be had. None: not one, or not now.
  using Texts = std::vector<bus::log::Attachment>;
  static Texts Fetch(const std::vector<bus::BulkOffer>& offers, const bus::NodeOptions& options);

  const bus::StateReader<bus::BulkOffer>& offers_;
  bus::NodeOptions options_;
  std::future<Texts> fetched_;
  std::int64_t next_ns_ = 0;  // not before
  bool is_offered_ = false, is_done_ = false;
};

}  // namespace oos

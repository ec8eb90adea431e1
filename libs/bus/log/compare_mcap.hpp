#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace bus::log {

// One topic of one node (and key) in two recordings.
struct ChannelComparison {
  std::string topic;
  std::string node;  // the writer
  std::string key;
  std::uint64_t num_a = 0, num_b = 0;
  std::uint64_t num_only_a = 0, num_only_b = 0;  // sequence numbers that the other does not have
  std::uint64_t num_different = 0;               // of those that both have
  [[nodiscard]] bool is_same() const { return num_only_a + num_only_b + num_different == 0; }
};

// A message that differs.
struct MessageDifference {
  std::string topic;
  std::string node;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0;  // in the first file
  std::string what;               // fields and their values, one a line; or which file lacks it
};

struct McapComparison {
  std::vector<ChannelComparison> channels;
  std::optional<MessageDifference> first;  // earliest by log time in the first file (by the second's where it lacks it)
  [[nodiscard]] bool is_same() const { return !first; }
};

// Compares payloads (without envelopes) by topic, writer and sequence number; times do not matter. Channels "taken/",
// steps and clocks are left out. Errors: kIo, kDamaged.
core::Result<McapComparison> CompareMcap(const std::filesystem::path& a, const std::filesystem::path& b,
                                         std::string_view pattern = "*");

}  // namespace bus::log

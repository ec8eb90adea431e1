#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace bus::log {

struct McapMerge {
  std::uint64_t num_messages = 0;
  std::size_t num_machines = 1;
  std::int64_t bound_ns = 0;            // the largest bound of the clock offsets that were used
  std::vector<std::string> incomplete;  // files whose writer died
};

// Joins recordings of one run into `to`, which must not exist. Times become those of the first file's machine, by the
// clock samples that the recordings hold; files of one machine need none. Order: by time; equal times
// in the order of the given files, and of the messages in them. Identical metadata and attachments are kept once.
// Errors: kIo, kDamaged; kInvalidInput when clocks cannot be compared.
core::Result<McapMerge> MergeMcap(const std::vector<std::filesystem::path>& from, const std::filesystem::path& to);

}  // namespace bus::log

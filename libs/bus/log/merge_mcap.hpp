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
  std::int64_t bound_ns = 0;            // of the worst clock offset that was used
  std::vector<std::string> incomplete;  // files whose writer died
};

// Joins recordings of one run into `to`, which must not exist. Times become those of the first file's machine, by the
// clock samples that the recordings hold; files of one machine need none. Order: by time; of one time as the files are
// given, and as they stand in their file. Metadata and attachments that say the same are kept once. Errors: kIo,
// kDamaged; kInvalidInput when clocks cannot be compared.
core::Result<McapMerge> MergeMcap(const std::vector<std::filesystem::path>& from, const std::filesystem::path& to);

}  // namespace bus::log

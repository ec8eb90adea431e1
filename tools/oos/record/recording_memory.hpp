#pragma once

#include <cstdint>
#include <filesystem>
#include <new>
#include <string>

#include "tools/oos/verb/verb.hpp"

namespace oos {

// Runs a verb that reads recordings, its positional arguments. If memory runs out, it fails with the size and a remedy.
inline int WithinMemory(const char* verb, const Arguments& arguments, int (*run)(const Arguments&)) {
  try {
    return run(arguments);
  } catch (const std::bad_alloc&) {
    std::string largest;
    std::uintmax_t most = 0;
    for (const std::string& file : arguments.positional()) {
      std::error_code error;
      const std::uintmax_t size = std::filesystem::file_size(file, error);
      if (error || size < most) continue;
      most = size;
      largest = file;
    }
    return Complain(verb,
                    largest + ": there is not enough memory for it (" + std::to_string(most / 1'000'000) +
                        " MB); record in parts, with --split_MB, and read one part at a time",
                    kBadUsage);
  }
}

}  // namespace oos

#pragma once

#include <filesystem>

#include "core/result.hpp"

namespace vps {

// Corners that are no finite numbers in an OBJ, OFF, STL or PLY file that is text, by line: readers skip such a corner
// without a word, and every face after it names another one. Binary files pass.
core::Result<void> CheckTextNumbers(const std::filesystem::path& file);

}  // namespace vps

#pragma once

#include <filesystem>

#include "core/result.hpp"

namespace vps {

// Refuses corners that are not finite numbers in a text OBJ, OFF, STL or PLY file. The error names the line. Readers
// skip such a corner silently, so that every later face refers to the wrong corner. Binary files pass.
core::Result<void> CheckTextNumbers(const std::filesystem::path& file);

}  // namespace vps

#pragma once

#include <filesystem>
#include <string_view>

#include "core/result.hpp"

namespace core {

// Writes the whole content, and the folders that lead to it. Under a name of this write alone first, so that no reader
// sees half a file and several writers do not meet. Error: kIo, with the file's name.
Result<void> WriteFile(const std::filesystem::path& file, std::string_view bytes);

}  // namespace core

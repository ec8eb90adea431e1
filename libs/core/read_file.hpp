#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/result.hpp"

namespace core {

// The whole content. Errors: kNotFound; kIo (also for a folder). The detail gives the reason without the path.
Result<std::vector<std::uint8_t>> ReadFile(const std::filesystem::path& file);

}  // namespace core

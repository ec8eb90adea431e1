#pragma once

#include <filesystem>
#include <string>

#include "core/result.hpp"
#include "space/atmosphere/tables.hpp"

namespace space {

// The tables' file in the folder of caches: "OOSAIR01", a key of what they were made from, a checksum, the numbers. It
// is addressed by that key, and a damaged one is an error, never trusted.
std::string AirFileName(const Air& air, const AirTableSizes& sizes);

core::Result<void> WriteAirTables(const std::filesystem::path& file, const AirTables<float>& tables);
// Errors: kNotFound, kIo, kDamaged.
core::Result<AirTables<float>> ReadAirTables(const std::filesystem::path& file, const Air& air,
                                             const AirTableSizes& sizes);

}  // namespace space

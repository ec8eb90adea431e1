#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "core/result.hpp"
#include "physics/checkpoint.hpp"

namespace physics {

// Grows with every change of what is in a part.
constexpr std::uint32_t kCheckpointFormat = 1;

// The parts of a checkpoint on disk. Appears whole or not at all: it is written beside `file` and renamed, so whoever
// reads finds the old one or the new one, also when the writer is killed. `content` says what it is of.
core::Result<void> WriteCheckpointFile(const std::filesystem::path& file, std::uint64_t content, std::uint64_t tick,
                                       std::span<const Checkpoint* const> parts);

// Fills the parts, of which the file must have as many, and returns the tick. Refused: a file that is none, one of
// another format or content, one with a wrong checksum.
core::Result<std::uint64_t> ReadCheckpointFile(const std::filesystem::path& file, std::uint64_t content,
                                               std::span<Checkpoint* const> parts);

}  // namespace physics

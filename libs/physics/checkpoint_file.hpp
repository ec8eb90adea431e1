#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "core/result.hpp"
#include "physics/checkpoint.hpp"

namespace physics {

// Incremented with every change of a part's content.
constexpr std::uint32_t kCheckpointFormat = 1;

// Writes the parts of a checkpoint to a file, atomically: it is written under another name and renamed, so a reader
// finds the old or the new file even if the writer is killed. `content`: digest of what the checkpoint belongs to.
// Error: kIo.
core::Result<void> WriteCheckpointFile(const std::filesystem::path& file, std::uint64_t content, std::uint64_t tick,
                                       std::span<const Checkpoint* const> parts);

// Fills the parts and returns the tick. Errors: kNotFound; kInvalidInput for a file that is not a checkpoint, or has
// another format, content or number of parts; kDamaged for a wrong checksum.
core::Result<std::uint64_t> ReadCheckpointFile(const std::filesystem::path& file, std::uint64_t content,
                                               std::span<Checkpoint* const> parts);

}  // namespace physics

#pragma once

#include <cstdint>
#include <string>

#include "core/result.hpp"

namespace scene_stream {

// What goes to the bridge on standard output: the length of what follows (u32, little-endian), a letter, the bytes.
enum class RecordKind : char {
  kAssets = 'A',  // SceneAssets
  kFrame = 'F',   // SceneFrame
  kSheets = 'S',  // SceneSheets
  kBlock = 'B',   // a number (u32), then floats
};

// Waits until all of it is written. Error: kIo.
core::Result<void> WriteRecord(int file, RecordKind kind, const std::string& bytes);

// Whether something can be written without waiting.
bool IsWritable(int file);

}  // namespace scene_stream

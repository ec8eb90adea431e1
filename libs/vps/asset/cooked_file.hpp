#pragma once

#include <cstdint>
#include <filesystem>

#include "core/result.hpp"
#include "vps/asset/cooked_object.hpp"

namespace vps {

// The cache file of a cooked object. Format version: raise it whenever the layout below, or what any builder makes of
// the same input, changes; older files are then rebuilt.
//
//   offset  bytes  field (little endian)
//   0       8      magic "VROOSVPS"
//   8       4      format version
//   12      4      reserved, 0
//   16      8      key: what it was built from (bytes of the mesh, parameters, format version)
//   24      8      payload size in bytes
//   32      8      xxHash3 of the payload
//   40      ...    payload: flags, bounding sphere, then what the flags name: voxelmap, point tree, distance
//                  field with its bends, sample tree, the coarser ones, the surface; arrays as u64 count + elements
constexpr std::uint32_t kCookedFormatVersion = 34;

// Key of a cache entry: the content address.
std::uint64_t CookedKey(const void* mesh_bytes, std::size_t num_bytes, const CookParameters& parameters);

// Writes beside the target and renames, so that a reader never sees half a file.
core::Result<void> WriteCookedFile(const std::filesystem::path& file, std::uint64_t key, const CookedObject& object);

// Error kNotFound when there is none; kDamaged when magic, version, key, sizes or checksum are not as they must be, or
// an index in the tree points outside. Nothing of a damaged file is returned.
core::Result<CookedObject> ReadCookedFile(const std::filesystem::path& file, std::uint64_t key);

}  // namespace vps

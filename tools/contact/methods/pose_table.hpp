#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "core/pose.hpp"
#include "core/result.hpp"

namespace contact {

// Rows px,py,pz,qw,qx,qy,qz: pose of B in A's frame, metres, unit quaternion. Empty lines, lines that begin with # and
// one heading line before the first row are skipped. Errors name file and line: not seven numbers, a number that is not
// finite, a quaternion whose length is more than 1e-3 off 1, no rows at all.
core::Result<std::vector<core::Pose>> ReadPoseTable(const std::filesystem::path& file);

// The same from text; errors name `name` instead of a file.
core::Result<std::vector<core::Pose>> ParsePoseTable(std::string_view text, std::string_view name);

}  // namespace contact

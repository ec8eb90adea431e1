#pragma once

#include <filesystem>
#include <string>

#include "core/result.hpp"

namespace oos {

// What a picture shows.
struct PictureSource {
  std::filesystem::path scenario;   // its file
  std::filesystem::path recording;  // empty: the scenario as it begins
};

// `given`: a scenario as every verb finds it, or a recording; then `scenario` names another than the recording does.
// Errors: kInvalidInput, with the diagnostics of a broken scenario; kNotFound.
core::Result<PictureSource> FindPictureSource(const std::string& given, const std::string& scenario);

// The file of the scenario that a recording names: as it was named, or relative to the recording; empty: it names none.
core::Result<std::filesystem::path> RecordedScenarioFile(const std::filesystem::path& recording);

}  // namespace oos

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace oos {

// Where the scenario lies that the command line names: a path; else a folder among the installed scenarios
// (share/vr-oos/scenarios beside the folder of the programs) or those of the source tree above a build folder. What is
// found nowhere is returned as it was given.
std::filesystem::path FindScenario(const std::string& given, const std::filesystem::path& program_folder);
// The names that it knows, in order.
std::vector<std::string> KnownScenarios(const std::filesystem::path& program_folder);
// For the running program.
std::filesystem::path FindScenario(const std::string& given);
std::vector<std::string> KnownScenarios();

}  // namespace oos

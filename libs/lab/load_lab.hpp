#pragma once

#include <filesystem>
#include <tl/expected.hpp>
#include <vector>

#include "lab/lab.hpp"
#include "scene/diagnostic.hpp"

namespace lab {

// Reads and checks a lab file: either a valid Lab, or all its errors in order of lines. Does not contact the hosts.
// Paths in the file are relative to its folder.
tl::expected<Lab, std::vector<scene::Diagnostic>> LoadLab(const std::filesystem::path& file);

// What does not match this scenario: nodes without a placement (those in `without` are left out on purpose), and
// devices whose role the scenario does not have.
std::vector<scene::Diagnostic> CheckAgainst(const Lab& lab, const scene::Scenario& scenario,
                                            const std::vector<std::string>& without);

}  // namespace lab

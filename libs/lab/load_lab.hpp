#pragma once

#include <filesystem>
#include <tl/expected.hpp>
#include <vector>

#include "lab/lab.hpp"
#include "scene/diagnostic.hpp"

namespace lab {

// Reads and checks a lab file: either a Lab that can be relied on, or all that is wrong with it, in order of lines.
// Nothing is asked of the hosts. Paths in it are relative to its folder.
tl::expected<Lab, std::vector<scene::Diagnostic>> LoadLab(const std::filesystem::path& file);

// What the lab lacks for this scenario: nodes that are nowhere (`without` are left out on purpose), roles that it does
// not have.
std::vector<scene::Diagnostic> CheckAgainst(const Lab& lab, const scene::Scenario& scenario,
                                            const std::vector<std::string>& without);

}  // namespace lab

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "view/scene.hpp"

namespace visual_node {

// Views that a person has kept in a window, for the next one: a file for each scenario, whose lines fit into a scenario
// file. In $VR_OOS_VIEWS, else $XDG_CONFIG_HOME/vr_oos/views, else ~/.config/vr_oos/views.
std::filesystem::path ViewsFile(const std::string& scenario);

core::Result<void> WriteViews(const std::filesystem::path& file, const std::vector<scene::Camera>& views,
                              const view::Assets& assets);
// None when there is no file. Errors: kDamaged: it is no such file; kInvalidInput: a view is carried by an object that
// the scenario no longer has.
core::Result<std::vector<scene::Camera>> ReadViews(const std::filesystem::path& file, const view::Assets& assets);

}  // namespace visual_node

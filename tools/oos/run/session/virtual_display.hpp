#pragma once

#include <string>
#include <vector>

#include "core/result.hpp"
#include "tools/process/group.hpp"

namespace oos {

// Starts an X server without a screen (Xvfb) in the group; returns its DISPLAY, e.g. ":7". The server picks a free
// number itself and reports it when it accepts clients, so there is no race and nothing to wait for. `options`: further
// ones of the server.
core::Result<std::string> StartVirtualDisplay(process::Group* group, const std::filesystem::path& log,
                                              const std::vector<std::string>& options = {});

}  // namespace oos

#pragma once

#include <string>
#include <vector>

namespace oos {

// Where a device may be on this machine, as TYPE:ADDRESS: serial lines, plug-ins in `plugin_folder`, and the UDP port
// of the how-to.
std::vector<std::string> FindCandidates(const std::string& serial_folder, const std::string& plugin_folder);

}  // namespace oos

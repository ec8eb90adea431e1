#pragma once

#include <filesystem>

namespace oos {

// Where the running session leaves its registry's endpoint for `topic`, `top` and `set`:
// $XDG_RUNTIME_DIR/vr_oos, else /tmp/vr_oos-<uid>.
std::filesystem::path SessionFolder();
std::filesystem::path SessionFile();

// The folder of the running executable: the nodes' executables stand beside it. Overridden by $VR_OOS_BIN_DIR.
std::filesystem::path ProgramFolder();

}  // namespace oos

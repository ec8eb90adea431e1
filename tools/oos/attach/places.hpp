#pragma once

#include <filesystem>
#include <string>

#include "core/result.hpp"

namespace oos {

// Where the running session leaves its registry's endpoint for `topic`, `top` and `set`:
// $XDG_RUNTIME_DIR/vr_oos, else /tmp/vr_oos-<uid>.
std::filesystem::path SessionFolder();
std::filesystem::path SessionFile();

// All three refuse a folder that is not this user's alone: whoever else can write there decides whom the tools obey,
// and where the note ends up.
core::Result<void> MakeSessionFolder();
core::Result<void> WriteSessionNote(const std::string& json);
core::Result<std::string> ReadSessionNote();

// The folder of the running executable: the nodes' executables stand beside it. Overridden by $VR_OOS_BIN_DIR.
std::filesystem::path ProgramFolder();

}  // namespace oos

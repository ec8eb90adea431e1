#pragma once

#include <filesystem>
#include <string>

#include "core/result.hpp"

namespace oos {

// Where `oos run` notes the running session for the verbs that join it:
// $XDG_RUNTIME_DIR/vr_oos, else /tmp/vr_oos-<uid>.
std::filesystem::path SessionFolder();
std::filesystem::path SessionFile();

// All three refuse a folder that other users can write to: they could direct the tools to a session of their own.
core::Result<void> MakeSessionFolder();
core::Result<void> WriteSessionNote(const std::string& json);
core::Result<std::string> ReadSessionNote();

// The folder of the running executable: the nodes' executables stand beside it. Overridden by $VR_OOS_BIN_DIR.
std::filesystem::path ProgramFolder();

}  // namespace oos

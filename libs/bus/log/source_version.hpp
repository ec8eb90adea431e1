#pragma once

#include <string>

namespace bus::log {

// The git description of the sources, which the build writes beside the executables; else "unknown".
std::string SourceVersion();

}  // namespace bus::log

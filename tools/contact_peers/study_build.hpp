#pragma once

#include "tools/contact/bench.hpp"

namespace contact_peers {

// Time and memory of building the field beside OpenVDB's (CompareBuilds): adds a table, a chart and three goals.
void StudyBuild(const contact::Places& places, contact::Report* report);

}  // namespace contact_peers

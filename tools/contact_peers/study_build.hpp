#pragma once

#include "tools/contact/bench.hpp"

namespace contact_peers {

// Time and memory of building the field, beside OpenVDB's (CompareBuilds), as table, chart and goals.
void StudyBuild(const contact::Places& places, contact::Report* report);

}  // namespace contact_peers

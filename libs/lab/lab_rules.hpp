#pragma once

#include <vector>

#include "scene/schema.hpp"

namespace lab {

// The form of a lab file: elements, attributes and their kinds; the first is the root.
const std::vector<scene::ElementRule>& LabRules();

}  // namespace lab

#pragma once

#include <vector>

#include "scene/schema.hpp"

namespace lab {

// Schema of a lab file: elements, attributes and their kinds. The first rule is the root element's.
const std::vector<scene::ElementRule>& LabRules();

}  // namespace lab

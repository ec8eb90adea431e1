#pragma once

#include <string>

#include "scene/scenario.hpp"

namespace scene {

// One error in a file, for the person who edits it.
struct Diagnostic {
  Location where;
  std::string what;  // the error, e.g. "object 'block': mass_kg is -1"
  std::string why;   // the rule that it violates
  std::string fix;   // what to write instead
};

// "file:line: what: why. Fix: fix."
std::string Format(const Diagnostic& diagnostic);

}  // namespace scene

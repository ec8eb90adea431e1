#include "scene/diagnostic.hpp"

namespace scene {

std::string Format(const Diagnostic& diagnostic) {
  return diagnostic.where.file.string() + ":" + std::to_string(diagnostic.where.line) + ": " + diagnostic.what + ": " +
         diagnostic.why + ". Fix: " + diagnostic.fix + ".";
}

}  // namespace scene

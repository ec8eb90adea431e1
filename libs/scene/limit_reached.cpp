#include "scene/limit_reached.hpp"

#include <cstdio>

namespace scene {

std::string LimitReached(double limit_s, const std::string& step) {
  char seconds[32];
  std::snprintf(seconds, sizeof seconds, "%.10g", limit_s);
  return "limit of " + std::string(seconds) + " s reached in step '" + step + "'";
}

}  // namespace scene

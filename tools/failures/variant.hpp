#pragma once

#include <string>
#include <vector>

namespace failures {

// A way of computing contact that every row is measured with.
struct Variant {
  std::string name;      // heading of its column
  std::string method;    // scene::Scenario::method
  std::string coupling;  // of the hand
};

// The last one is the default of the scenarios: it decides whether a row's bound is met.
const std::vector<Variant>& Variants();

}  // namespace failures

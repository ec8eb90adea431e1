#include "tools/failures/variant.hpp"

namespace failures {

const std::vector<Variant>& Variants() {
  static const std::vector<Variant> variants{
      {"paper", "paper", "paper"}, {"fast", "fast", "paper"}, {"fast, god object", "fast", "god_object"}};
  return variants;
}

}  // namespace failures

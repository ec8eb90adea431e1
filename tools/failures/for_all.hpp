#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "tools/failures/variant.hpp"

namespace failures {

// Runs body(i) for i in [0, count), on as many threads as there are processors, in any order. A body writes only to
// data of its own index. The first exception is thrown again when all have ended.
void ForAll(std::size_t count, const std::function<void(std::size_t)>& body);

// f(variant) of every variant, in their order.
template <class F>
auto OfVariants(F&& f) {
  std::vector<decltype(f(Variants().front()))> results(Variants().size());
  ForAll(results.size(), [&](std::size_t i) { results[i] = f(Variants()[i]); });
  return results;
}

}  // namespace failures

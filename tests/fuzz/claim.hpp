#pragma once

#include <cstdio>
#include <cstdlib>

namespace fuzz {

// Checks a property of a parser's result. Aborts if it does not hold, so that the engine keeps the input.
inline void Claim(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "claim broken: %s\n", what);
  std::abort();
}

}  // namespace fuzz

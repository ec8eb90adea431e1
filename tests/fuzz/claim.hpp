#pragma once

#include <cstdio>
#include <cstdlib>

namespace fuzz {

// What a target says of a parser's answer. Aborts, so that the engine keeps the input.
inline void Claim(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "claim broken: %s\n", what);
  std::abort();
}

}  // namespace fuzz

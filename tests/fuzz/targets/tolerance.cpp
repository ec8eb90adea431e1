#include "replay/difference.hpp"
#include "tests/fuzz/reader.hpp"

namespace fuzz {

void FuzzTolerance(Input input) {
  const auto tolerance = replay::Tolerance::Parse(TextOf(input), "tolerance.txt");
  if (!tolerance) return;
  const replay::Leaf expected{"state.bodies[3].X_WO.translation.x", replay::Leaf::Kind::kReal, 1.0, 1, {}};
  replay::Leaf got = expected;
  got.number = 1.001;
  got.bits = 2;
  (void)tolerance->IsWithin(expected.path, expected, got);
  (void)tolerance->Ignores(expected.path);
}

}  // namespace fuzz

#include "tools/failures/tool_on_plate.hpp"

#include "vps/testing/shapes.hpp"

namespace failures {

SceneKit BallOverPlate(const Variant& variant, double gap_m) {
  SceneKit kit(variant);
  const auto plate =
      kit.AddFixed(vps::MakeBox({0.2, 0.2, kPlate_m}), {{1, 0, 0, 0}, {0, 0, -0.5 * kPlate_m}}, kVoxel_m);
  const auto ball = kit.AddHand(vps::MakeSphere(kBall_m, 64), {{1, 0, 0, 0}, {0, 0, kBall_m + gap_m}}, kToolPoints);
  kit.AddPair(ball, plate);
  return kit;
}

}  // namespace failures

#include <gtest/gtest.h>

#include "vps/multibody/collision_world.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

// A box that comes down onto a plate.
struct Approach {
  std::unique_ptr<CollisionWorld> world;

  explicit Approach(Method method) {
    const auto cook = [method](const TriangleMesh& mesh, double voxel_size_m, std::uint32_t num_points) {
      return std::make_shared<const CookedObject>(*Cook(mesh, {voxel_size_m, num_points, method}));
    };
    WorldDescription description;
    description.method = method;
    description.objects = {{cook(MakeBox({0.04, 0.04, 0.04}), 0.0005, 0), {}},
                           {cook(MakeBox({0.02, 0.02, 0.02}), 0, 2000), {}}};
    description.pairs = {{.sampled = 1, .field = 0, .look_ahead_m = 0.001}};
    world = *CollisionWorld::Create(description);
  }

  // Gap at which there are planes for the first time, when it comes by `pace_m` a cycle.
  double FirstGap_m(double pace_m) {
    core::SerialFor serial;
    for (double gap_m = 0.02; gap_m > -0.001; gap_m -= pace_m) {
      world->SetPose(1, {{1, 0, 0, 0}, {0, 0, 0.03 + gap_m}});
      static_cast<void>(world->Step(&serial));
      if (!world->result(0).planes.empty()) return gap_m;
    }
    return -1.0;
  }
};

TEST(LookAhead, CoversTheMotionDuringTheDelay) {
  Approach approach(Method::kPaper);
  EXPECT_LT(approach.FirstGap_m(0.0003), 0.0015) << "no delay was set";
  approach.world->SetDelay(7.0);
  EXPECT_LT(approach.FirstGap_m(0.0001), 0.0015) << "slow";
  EXPECT_GT(approach.FirstGap_m(0.0003), 0.0003 * 9.0) << "the motion of nine cycles";
  approach.world->SetDelay(50.0);
  EXPECT_LT(approach.FirstGap_m(0.0005), 0.0045) << "four times at most";
}

TEST(LookAhead, StaysWithinTheExactBandOfTheFastField) {
  Approach approach(Method::kFast);
  approach.world->SetDelay(50.0);
  EXPECT_LT(approach.FirstGap_m(0.0003), 0.0015);
}

}  // namespace
}  // namespace vps

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "vps/multibody/collision_world.hpp"
#include "vps/testing/cooked.hpp"
#include "vps/testing/pose_at.hpp"
#include "vps/testing/shapes.hpp"

// The whole chain of one hand: voxelmap, pointshell, tree walk, reduction, virtual coupling.
namespace vps {
namespace {

struct Statistics {
  double mean = 0.0;
  double deviation = 0.0;
};
Statistics Of(const std::vector<double>& values) {
  Statistics s;
  for (const double v : values) s.mean += v / static_cast<double>(values.size());
  for (const double v : values) s.deviation += (v - s.mean) * (v - s.mean) / static_cast<double>(values.size());
  s.deviation = std::sqrt(s.deviation);
  return s;
}

// A hand that is object 1, sampled, against object 0, the field.
class Hand {
 public:
  Hand(std::shared_ptr<const CookedObject> field, std::shared_ptr<const CookedObject> hand, const core::Pose& X_WD) {
    WorldDescription description;
    description.objects = {{field, {}}, {hand, X_WD}};
    description.pairs = {{.sampled = 1, .field = 0}};
    world = *CollisionWorld::Create(description);
    CouplingParameters parameters;
    parameters.bounding_radius_m = glm::length(hand->bounding_centre_m) + hand->bounding_radius_m;
    coupling = VirtualCoupling(parameters);
    coupling.Reset(X_WD);
  }
  core::Wrench Step(const core::Pose& X_WD) {
    world->SetPose(1, coupling.X_WC());
    world->Step(&serial);
    world->HandContact(is_hand_part, coupling.X_WC(), &contact);
    return coupling.Step(X_WD, contact);
  }

  std::vector<std::uint8_t> is_hand_part{0, 1};
  std::unique_ptr<CollisionWorld> world;
  VirtualCoupling coupling;
  CouplingContact contact;
  core::SerialFor serial;
};

constexpr double kPlateVoxel_m = 0.0005;

TEST(HandOnVoxmap, BallPressed5MmIntoAPlateFeelsStiffnessTimesDepth) {
  // Plate with its upper face at z = 0.01; the ball touches at z = 0.02.
  Hand hand(Cooked(MakeBox({0.1, 0.1, 0.02}), kPlateVoxel_m, 0), Cooked(MakeSphere(0.01, 48), 0, 4096), At(0, 0, 0.03));
  double z = 0.03;
  core::Wrench F;
  for (int i = 0; i < 400; ++i) {
    z = std::max(z - 1e-4, 0.015);
    F = hand.Step(At(0, 0, z));
  }
  std::vector<double> force;
  for (int i = 0; i < 500; ++i) force.push_back(hand.Step(At(0, 0, z)).force_N.z);
  const Statistics rest = Of(force);
  EXPECT_NEAR(rest.mean, 2500.0 * (0.005 - hand.world->RestPenetration_m(0)), 2500.0 * kPlateVoxel_m);
  EXPECT_LT(rest.deviation, 0.02 * rest.mean);
  // Sliding at 0.1 m/s: the proxy follows, the force stays within the steps of integer layers.
  std::vector<double> slide, lag;
  for (int i = 0; i < 300; ++i) {
    F = hand.Step(At(1e-4 * i, 0, z));
    slide.push_back(F.force_N.z);
    lag.push_back(std::abs(F.force_N.x));
  }
  const Statistics sliding = Of(slide);
  std::printf("ball on plate: %.3f N at rest (deviation %.4f), sliding %.3f N (deviation %.3f), drag %.3f N\n",
              rest.mean, rest.deviation, sliding.mean, sliding.deviation, Of(lag).mean);
  EXPECT_NEAR(sliding.mean, rest.mean, 2500.0 * kPlateVoxel_m);
  EXPECT_LT(sliding.deviation, 0.05 * rest.mean);
  EXPECT_LT(Of(lag).mean, 0.05 * rest.mean);
  // Letting go.
  for (int i = 0; i < 300; ++i) F = hand.Step(At(0.03, 0, 0.0301));
  EXPECT_EQ(glm::length(F.force_N) + glm::length(F.torque_Nm), 0.0);
}

TEST(HandOnVoxmap, BallPressedIntoACornerComesToRest) {
  // The inside corner of a block with a square pocket would need another mesh: two crossed plates do.
  Hand hand(Cooked(MakeBox({0.1, 0.1, 0.02}), kPlateVoxel_m, 0), Cooked(MakeSphere(0.01, 48), 0, 4096),
            At(-0.03, 0, 0.03));
  WorldDescription description;
  auto plate = Cooked(MakeBox({0.1, 0.1, 0.02}), kPlateVoxel_m, 0);
  auto ball = Cooked(MakeSphere(0.01, 48), 0, 4096);
  description.objects = {
      {plate, {}}, {ball, At(-0.03, 0, 0.03)}, {plate, At(0.01, 0, 0.05, {0, 1.5707963267948966, 0})}};
  description.pairs = {{.sampled = 1, .field = 0}, {.sampled = 1, .field = 2}};
  hand.world = *CollisionWorld::Create(description);
  hand.is_hand_part = {0, 1, 0};
  // Wall's face at x = 0, floor's at z = 0.01: the ball rests at (-0.01, 0, 0.02); D is 5 mm beyond both.
  for (int i = 0; i < 600; ++i) hand.Step(At(std::min(-0.03 + 1e-4 * i, -0.005), 0, std::max(0.03 - 1e-4 * i, 0.015)));
  std::vector<double> x, z;
  for (int i = 0; i < 500; ++i) {
    const core::Wrench F = hand.Step(At(-0.005, 0, 0.015));
    x.push_back(F.force_N.x);
    z.push_back(F.force_N.z);
  }
  std::printf("ball in corner: x %.3f N (deviation %.4f), z %.3f N (deviation %.4f)\n", Of(x).mean, Of(x).deviation,
              Of(z).mean, Of(z).deviation);
  EXPECT_NEAR(Of(x).mean, -2500.0 * 0.005, 2500.0 * 2.0 * kPlateVoxel_m);
  EXPECT_NEAR(Of(z).mean, 2500.0 * 0.005, 2500.0 * 2.0 * kPlateVoxel_m);
  EXPECT_LT(Of(x).deviation, 0.02 * 12.5);
  EXPECT_LT(Of(z).deviation, 0.02 * 12.5);
}

// A ball on a plate of 0.5 mm voxels, alone and with a block of 6 mm voxels 2 m away.
TEST(HandOnVoxmap, AFarCoarsePartChangesNoBit) {
  const auto plate = Cooked(MakeBox({0.1, 0.1, 0.02}), kPlateVoxel_m, 0);
  const auto ball = Cooked(MakeSphere(0.01, 48), 0, 4096);
  Hand alone(plate, ball, At(0, 0, 0.03));
  Hand beside(plate, ball, At(0, 0, 0.03));
  WorldDescription description;
  description.objects = {
      {plate, {}}, {ball, At(0, 0, 0.03)}, {Cooked(MakeBox(glm::dvec3(0.2)), 0.006, 0), At(2, 0, 0)}};
  description.pairs = {{.sampled = 1, .field = 0}, {.sampled = 1, .field = 2}};
  beside.world = *CollisionWorld::Create(description);
  beside.is_hand_part = {0, 1, 0};
  bool is_touching = false;
  for (int i = 0; i < 400; ++i) {  // down to 5 mm below touch, aside, and off again
    const core::Pose X_WD = At(2e-5 * i, 0, 0.015 + std::max(0.015 - 1e-4 * i, 0.0) + std::max(1e-4 * (i - 300), 0.0));
    const core::Wrench F = alone.Step(X_WD);
    const core::Wrench F_beside = beside.Step(X_WD);
    is_touching = is_touching || F.force_N.z > 10.0;
    ASSERT_EQ(F.force_N, F_beside.force_N) << i;
    ASSERT_EQ(F.torque_Nm, F_beside.torque_Nm) << i;
    ASSERT_EQ(alone.coupling.X_WC().translation, beside.coupling.X_WC().translation) << i;
  }
  EXPECT_TRUE(is_touching);
}

TEST(HandOnVoxmap, PegInATightHoleIsNotNoisy) {
  // 20 mm peg, 0.5 mm diametral clearance, voxel a quarter of that; D presses sideways and tilts.
  Hand hand(Cooked(MakeBlockWithHole(0.04, 0.04, 0.01025, 96), 0.000125, 0),
            Cooked(MakeCylinder(0.01, 0.04, 96), 0, 16384), At(0, 0, 0.01));
  for (int i = 0; i < 300; ++i) hand.Step(At(1e-5 * i, 0, 0.01));
  std::vector<double> force, torque;
  for (int i = 0; i < 500; ++i) {
    const core::Wrench F = hand.Step(At(0.003, 0, 0.01, {0, 0.05, 0}));
    if (i < 200) continue;
    force.push_back(F.force_N.x);
    torque.push_back(F.torque_Nm.y);
  }
  const double play_m = 0.00025;
  std::printf("peg in hole: %.3f N (deviation %.4f), %.4f Nm (deviation %.5f)\n", Of(force).mean, Of(force).deviation,
              Of(torque).mean, Of(torque).deviation);
  EXPECT_NEAR(Of(force).mean, -2500.0 * (0.003 - play_m), 2500.0 * 0.0005);
  EXPECT_LT(Of(force).deviation, 0.02 * 2500.0 * 0.003);
  EXPECT_LT(Of(torque).deviation, 0.02 * 30.0 * 0.05);
  // And it slides out along the axis with little drag.
  std::vector<double> drag;
  for (int i = 0; i < 300; ++i) drag.push_back(std::abs(hand.Step(At(0.001, 0, 0.01 + 5e-5 * i)).force_N.z));
  std::printf("peg pulled out at 0.05 m/s: drag %.3f N\n", Of(drag).mean);
  EXPECT_LT(Of(drag).mean, 0.5);
}

}  // namespace
}  // namespace vps

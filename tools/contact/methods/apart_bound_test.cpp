#include "tools/contact/methods/apart_bound.hpp"

#include <gtest/gtest.h>

#include "tools/contact/methods/method.hpp"
#include "tools/contact/random.hpp"
#include "vps/oracle/body_distance.hpp"
#include "vps/testing/shapes.hpp"

namespace contact {
namespace {

// From touching to far apart, at random attitudes: never above the true distance, and within 10 mm of it.
TEST(ApartBound, IsNeverAboveTheTrueDistance) {
  const vps::TriangleMesh torus = vps::MakeTorus(0.03, 0.012, 32, 16);
  const vps::TriangleMesh box = vps::MakeBox({0.03, 0.02, 0.04});
  const vps::TriangleMesh hole = vps::MakeBlockWithHole(0.06, 0.04, 0.01, 24);
  Random random(3);
  for (const auto& [A, B] : {std::pair{&torus, &box}, {&box, &torus}, {&hole, &box}, {&hole, &torus}}) {
    const auto method = MakeFastMethod(*A, *B, {1e-3, 8192});
    ASSERT_TRUE(method);
    const vps::oracle::MeshDistance exact_A(*A);
    const vps::oracle::MeshDistance exact_B(*B);
    double widest_m = 0.0;
    int num_apart = 0;
    for (int i = 0; i < 60; ++i) {
      const core::Pose X{random.Rotation(), random.Uniform(0.03, 0.07) * random.Direction()};
      const vps::oracle::BodyDistance truth = vps::oracle::SignedBodyDistance(exact_A, exact_B, X);
      if (truth.signed_distance_m <= 0.0) continue;
      ++num_apart;
      const Answer answer = (*method)->Query(X);
      EXPECT_EQ(answer.contacts, 0U);
      ASSERT_LE(answer.signed_distance_m, truth.signed_distance_m) << i;
      ASSERT_GE(answer.signed_distance_m, 0.0);
      widest_m = std::max(widest_m, truth.signed_distance_m - answer.signed_distance_m);
    }
    EXPECT_GT(num_apart, 10);
    EXPECT_LT(widest_m, 1e-2);  // far apart; near contact it is half a voxel and a sample's support radius
  }
}

}  // namespace
}  // namespace contact

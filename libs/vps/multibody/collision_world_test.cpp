#include "vps/multibody/collision_world.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <thread>
#include <vector>

#include "vps/testing/brute_force.hpp"
#include "vps/testing/cooked.hpp"
#include "vps/testing/pose_at.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

std::shared_ptr<const CookedObject> Torus() {
  static const auto torus = Cooked(MakeTorus(0.05, 0.02, 48, 24), 0.001, 3000);
  return torus;
}

// Runs bodies on two threads, odd and even, the odd ones backwards.
class TwoThreads final : public core::ParallelFor {
 public:
  void Run(std::size_t count, Body body, void* context) override {
    std::thread odd([&] {
      for (std::size_t i = count; i-- > 0;) {
        if (i % 2 == 1) body(context, i);
      }
    });
    for (std::size_t i = 0; i < count; i += 2) body(context, i);
    odd.join();
  }
};

// Six tori that tumble among each other, all pairs.
struct Crowd {
  std::unique_ptr<CollisionWorld> world;
  static constexpr std::uint16_t kCount = 6;

  Crowd() {
    WorldDescription description;
    for (int i = 0; i < kCount; ++i) description.objects.push_back({Torus(), PoseAt(i, 0)});
    for (std::uint16_t i = 0; i < kCount; ++i) {
      for (std::uint16_t j = 0; j < i; ++j) description.pairs.push_back({.sampled = i, .field = j});
    }
    world = *CollisionWorld::Create(description);
  }
  static core::Pose PoseAt(int object, int step) {
    const double t = 0.01 * step;
    const double a = 1.0 + 0.37 * object;
    return At(0.15 * std::sin(a * t + object), 0.12 * std::cos(1.3 * a * t), 0.1 * std::sin(0.7 * a * t + 2.0 * object),
              {a * t, 0.5 * t, std::sin(t)});
  }
  void MoveTo(int step) {
    for (int i = 0; i < kCount; ++i) world->SetPose(static_cast<std::size_t>(i), PoseAt(i, step));
  }
};

TEST(CollisionWorld, CoherenceNeverSkipsAContact) {
  Crowd crowd;
  core::SerialFor serial;
  std::uint32_t num_coherent = 0;
  std::uint32_t num_in_contact = 0;
  for (int step = 0; step < 400; ++step) {
    crowd.MoveTo(step);
    const StepReport report = crowd.world->Step(&serial);
    num_coherent += report.pairs_coherent;
    num_in_contact += report.pairs_in_contact;
    for (std::size_t p = 0; p < crowd.world->num_pairs(); ++p) {
      const PairDescription& pair = crowd.world->pair(p);
      const core::Pose X_GS = Crowd::PoseAt(pair.field, step).inverse() * Crowd::PoseAt(pair.sampled, step);
      const auto hits = QueryBruteForce(*Torus()->points, *Torus()->voxmap, X_GS, 0.0);
      ASSERT_EQ(crowd.world->result(p).is_in_contact, !hits.empty()) << "step " << step << " pair " << p;
      if (hits.empty()) {
        ASSERT_GE(crowd.world->signed_distance_m(p), 0.0);
      }
    }
  }
  EXPECT_GT(num_coherent, 1000U);
  EXPECT_GT(num_in_contact, 300U);
}

TEST(CollisionWorld, ResultsDoNotDependOnTheNumberOfWorkers) {
  Crowd one;
  Crowd two;
  core::SerialFor serial;
  TwoThreads threads;
  for (int step = 0; step < 200; ++step) {
    one.MoveTo(step);
    two.MoveTo(step);
    const StepReport a = one.world->Step(&serial);
    const StepReport b = two.world->Step(&threads);
    ASSERT_EQ(a.counters.spheres_tested, b.counters.spheres_tested);
    ASSERT_EQ(a.counters.points_colliding, b.counters.points_colliding);
    for (std::size_t i = 0; i < Crowd::kCount; ++i) {
      ASSERT_EQ(one.world->ObjectWrench(i).force_N, two.world->ObjectWrench(i).force_N);
      ASSERT_EQ(one.world->ObjectWrench(i).torque_Nm, two.world->ObjectWrench(i).torque_Nm);
    }
    for (std::size_t p = 0; p < one.world->num_pairs(); ++p) {
      ASSERT_EQ(one.world->result(p).planes.size(), two.world->result(p).planes.size());
      ASSERT_EQ(one.world->result(p).signed_distance_m, two.world->result(p).signed_distance_m);
    }
  }
}

TEST(CollisionWorld, ForcesOnAllObjectsSumToZero) {
  Crowd crowd;
  core::SerialFor serial;
  for (int step = 0; step < 50; ++step) {
    crowd.MoveTo(5 * step);
    crowd.world->Step(&serial);
    glm::dvec3 force(0.0);
    glm::dvec3 torque(0.0);  // about W's origin
    double scale = 1e-9;
    for (int i = 0; i < Crowd::kCount; ++i) {
      const core::Wrench& F = crowd.world->ObjectWrench(static_cast<std::size_t>(i));
      force += F.force_N;
      torque += F.torque_Nm + glm::cross(Crowd::PoseAt(i, 5 * step).translation, F.force_N);
      scale += glm::length(F.force_N);
    }
    EXPECT_LT(glm::length(force), 1e-12 * scale);
    EXPECT_LT(glm::length(torque), 1e-12 * scale);
  }
}

TEST(PenaltyForce, OfAPlateOnAHalfSpaceIsTheClosedForm) {
  // 40 x 40 x 10 mm plate pressed d into a half-space whose surface runs through voxel centres. Colliding (V >= 0): the
  // lower face, d deep, and the strips of the four sides that are in inner or surface voxels, up to s/2 above the
  // surface; their normals cancel. (They stand on voxel centres, where n . e = 0.) With n >= rho N, lambda = 1/n:
  // F = k d A / (A + P (d + s/2)).
  WorldDescription description;
  description.objects = {{Cooked(MakeBox({0.1, 0.1, 0.04}), 0.001, 0), {}},
                         {Cooked(MakeBox({0.04, 0.04, 0.01}), 0.0, 20000), {}}};
  description.pairs = {{.sampled = 1, .field = 0, .stiffness_N_per_m = 1e4}};
  const auto world = *CollisionWorld::Create(description);
  core::SerialFor serial;
  for (const double depth : {0.0005, 0.001, 0.0022, 0.004}) {
    world->SetPose(1, At(0.001, -0.002, 0.02 + 0.005 - depth));
    world->Step(&serial);
    const double area = 0.04 * 0.04;
    const double expected = 1e4 * depth * area / (area + 4.0 * 0.04 * (depth + 0.0005));
    const core::Wrench& F = world->ObjectWrench(1);
    EXPECT_NEAR(F.force_N.z, expected, 0.02 * expected) << depth;
    EXPECT_NEAR(F.force_N.x, 0.0, 0.01 * expected);
    EXPECT_NEAR(F.torque_Nm.x, 0.0, 0.0005 * expected);
    EXPECT_NEAR(world->result(0).signed_distance_m, -depth, 1e-6);
    // The planes carry the pair's stiffness, and their gaps are the depth.
    double stiffness = 0.0;
    for (const auto& plane : world->result(0).planes) {
      if (plane.n_G.z > 0.9f) stiffness += static_cast<double>(plane.stiffness_N_per_m);
    }
    EXPECT_NEAR(stiffness, 1e4, 10.0);
  }
}

TEST(PenaltyForce, IsFrameInvariant) {
  WorldDescription description;
  description.objects = {{Torus(), {}}, {Torus(), {}}};
  description.pairs = {{.sampled = 1, .field = 0}};
  const auto world = *CollisionWorld::Create(description);
  core::SerialFor serial;
  const core::Pose X_GS = At(0.06, 0.03, 0.015, {0.4, -0.2, 0.9});
  world->SetPose(1, X_GS);
  world->Step(&serial);
  const core::Wrench F = world->ObjectWrench(1);
  ASSERT_GT(glm::length(F.force_N), 0.1);
  const core::Pose X_UW = At(3.0, -2.0, 1.0, {1.0, 0.5, -2.0});
  world->SetPose(0, X_UW);
  world->SetPose(1, X_UW * X_GS);
  world->Step(&serial);
  EXPECT_LT(glm::length(world->ObjectWrench(1).force_N - X_UW.rotate(F.force_N)), 1e-3 * glm::length(F.force_N));
  EXPECT_LT(glm::length(world->ObjectWrench(1).torque_Nm - X_UW.rotate(F.torque_Nm)),
            1e-3 * glm::length(F.force_N) * 0.05);
}

TEST(CollisionWorld, StateMatrixSwitchesAPairOffAndOn) {
  WorldDescription description;
  description.objects = {{Torus(), {}}, {Torus(), At(0.06, 0, 0)}};
  description.pairs = {{.sampled = 1, .field = 0}};
  const auto world = *CollisionWorld::Create(description);
  core::SerialFor serial;
  EXPECT_EQ(world->Step(&serial).pairs_in_contact, 1U);
  world->SetActive(0, false);
  EXPECT_EQ(world->Step(&serial).pairs_inactive, 1U);
  EXPECT_FALSE(world->result(0).is_in_contact);
  EXPECT_TRUE(world->result(0).planes.empty());
  EXPECT_EQ(glm::length(world->ObjectWrench(0).force_N), 0.0);
  world->SetActive(0, true);
  EXPECT_EQ(world->Step(&serial).pairs_in_contact, 1U);
}

TEST(CollisionWorld, KeepsTheResultOfAPairThatStandsStill) {
  WorldDescription description;
  description.objects = {{Torus(), {}}, {Torus(), At(0.06, 0, 0)}};
  description.pairs = {{.sampled = 1, .field = 0, .stiffness_N_per_m = 1000}};
  const auto world = *CollisionWorld::Create(description);
  core::SerialFor serial;
  world->Step(&serial);
  const core::Wrench F = world->ObjectWrench(1);
  const StepReport& report = world->Step(&serial);
  EXPECT_EQ(report.pairs_unchanged, 1U);
  EXPECT_EQ(report.pairs_tested, 0U);
  EXPECT_TRUE(world->is_fresh(0));
  EXPECT_EQ(world->ObjectWrench(1).force_N, F.force_N);
  world->SetStiffness(0, 2000);
  EXPECT_EQ(world->Step(&serial).pairs_tested, 1U);
  EXPECT_NEAR(glm::length(world->ObjectWrench(1).force_N), 2.0 * glm::length(F.force_N), 1e-9);
}

TEST(CollisionWorld, ShortOfTimeTheOldestResultGoesFirst) {
  // A budget that is over at once still lets one pair through a cycle: each gets its turn, ages are reported.
  Crowd crowd;
  core::SerialFor serial;
  const std::size_t num_pairs = crowd.world->num_pairs();
  for (int step = 0; step < 60; ++step) {
    crowd.MoveTo(0);
    for (int i = 0; i < Crowd::kCount; ++i) {  // all in one heap: every pair stays due
      crowd.world->SetPose(static_cast<std::size_t>(i), At(0.01 * i, 0.0, 1e-6 * step));
    }
    crowd.world->SetPose(0, At(0, 1e-6 * step, 0));
    const StepReport& report = crowd.world->Step(&serial, 1);
    EXPECT_LE(report.oldest_result_cycles, 2 * num_pairs);
    EXPECT_EQ(
        report.pairs_tested + report.pairs_late + report.pairs_unchanged + report.pairs_bounded + report.pairs_coherent,
        num_pairs);
  }
  for (std::size_t p = 0; p < num_pairs; ++p) EXPECT_GT(crowd.world->result(p).cycle, 20U);
}

TEST(CollisionWorld, RefusesPairsWithoutStructures) {
  WorldDescription description;
  description.objects = {{Cooked(MakeBox({0.1, 0.1, 0.1}), 0.005, 0), {}}, {nullptr, {}}};
  description.pairs = {{.sampled = 1, .field = 0}};
  EXPECT_FALSE(CollisionWorld::Create(description).has_value());
  description.pairs = {{.sampled = 0, .field = 1}};
  EXPECT_NE(CollisionWorld::Create(description).error().detail.find("pointshell"), std::string::npos);
  description.pairs = {{.sampled = 0, .field = 7}};
  EXPECT_FALSE(CollisionWorld::Create(description).has_value());
}

TEST(CollisionWorld, TheHandGetsTheOppositeWrenchOnTheFieldSide) {
  WorldDescription description;
  description.objects = {{Torus(), {}}, {Torus(), At(0.06, 0.01, 0)}};
  description.pairs = {{.sampled = 1, .field = 0}};
  const auto world = *CollisionWorld::Create(description);
  core::SerialFor serial;
  world->Step(&serial);
  CouplingContact as_sampled;
  CouplingContact as_field;
  world->HandContact({0, 1}, At(0.01, 0.02, 0.03), &as_sampled);
  world->HandContact({1, 0}, At(0.01, 0.02, 0.03), &as_field);
  ASSERT_TRUE(as_sampled.is_in_contact);
  EXPECT_EQ(as_sampled.f_Co_W.sum_m, -as_field.f_Co_W.sum_m);
  EXPECT_EQ(as_sampled.f_Co_W.moment_m2, -as_field.f_Co_W.moment_m2);
  ASSERT_EQ(as_sampled.planes.size(), as_field.planes.size());
  EXPECT_EQ(as_sampled.planes[0].n_W, -as_field.planes[0].n_W);
  EXPECT_EQ(as_sampled.planes[0].gap_m, as_field.planes[0].gap_m);
  world->HandContact({0, 1}, {}, &as_sampled, 0);
  EXPECT_FALSE(as_sampled.is_in_contact);
}

}  // namespace
}  // namespace vps

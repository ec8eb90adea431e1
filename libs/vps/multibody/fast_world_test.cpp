#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "vps/asset/cooked_file.hpp"
#include "vps/multibody/collision_world.hpp"
#include "vps/multibody/fast_pair_query.hpp"
#include "vps/testing/cooked.hpp"
#include "vps/testing/flat_walk.hpp"
#include "vps/testing/pose_at.hpp"
#include "vps/testing/shapes.hpp"

// The method `fast` behind the interface of CollisionWorld.
namespace vps {
namespace {

// Object 0 is a plate with its upper face at z = 0.02; object 1 is on it.
std::unique_ptr<CollisionWorld> OnPlate(const TriangleMesh& mesh, std::uint32_t num_points) {
  WorldDescription description;
  description.method = Method::kFast;
  description.objects = {{Cooked(MakeBox({0.1, 0.1, 0.04}), 0.0005, 0, Method::kFast), {}},
                         {Cooked(mesh, 0, num_points, Method::kFast), {}}};
  description.pairs = {{.sampled = 1, .field = 0}};
  return *CollisionWorld::Create(description);
}

TEST(FastWorld, ABoxPressedFlatFeelsStiffnessTimesDepth) {
  for (const std::uint32_t num_points : {500U, 4000U}) {
    const auto world = OnPlate(MakeBox({0.02, 0.02, 0.02}), num_points);
    core::SerialFor serial;
    world->SetPose(1, At(0.01, 0, 0.03 - 0.0004));
    const StepReport& report = world->Step(&serial);
    EXPECT_EQ(report.pairs_in_contact, 1U);
    const PairResult& result = world->result(0);
    EXPECT_NEAR(result.signed_distance_m, -0.0004, 2e-6);
    // The sides that are inside add 8 % of area at half the depth; their forces cancel.
    EXPECT_NEAR(result.F_So_W.force_N.z,
                2.0e4 * 0.0004 * (1.0 + 0.08 / 3.0) / ((1.0 + 0.08 / 2.0) * (1.0 + 0.08 / 2.0)),
                num_points == 500U ? 0.45 : 0.2);
    EXPECT_LT(std::hypot(result.F_So_W.force_N.x, result.F_So_W.force_N.y), 0.1);
    ASSERT_GE(result.planes.size(), 4U);
    double stiffness = 0.0;
    for (const core::ContactPlane& plane : result.planes) {
      if (plane.n_G.z < 0.9f) continue;
      EXPECT_GT(plane.n_G.z, 0.9999f);
      const glm::dvec3 p_G = At(0.01, 0, 0.03 - 0.0004) * glm::dvec3(plane.p_S);
      const double gap = glm::dot(glm::dvec3(plane.n_G), p_G - glm::dvec3(plane.q_G));
      EXPECT_GT(gap, -0.0004 - 2e-6);
      // Of the bottom; the sides that are inside lessen its depth by up to 6 %, or have planes of their own.
      if (gap < -0.0004 + 2.4e-5) stiffness += plane.stiffness_N_per_m;
    }
    EXPECT_GT(stiffness, 0.9 * 2.0e4);
  }
}

TEST(FastWorld, ForceOfABallGrowsContinuously) {
  const auto world = OnPlate(MakeSphere(0.01, 96), 4000);
  core::SerialFor serial;
  double before = 0.0;
  double largest = 0.0;
  for (int i = 0; i <= 800; ++i) {
    world->SetPose(1, At(0, 0, 0.03 + 1e-4 - 1e-6 * i));
    world->Step(&serial);
    const double force = world->result(0).F_So_W.force_N.z;
    largest = std::max(largest, std::abs(force - before));
    before = force;
  }
  // The smooth change is 2/3 k per depth; no step is more than three times that.
  EXPECT_LT(largest, 3.0 * 2.0 / 3.0 * 2.0e4 * 1e-6);
  EXPECT_GT(before, 3.0);
}

TEST(FastWorld, RestsWhileApartAndNeverLate) {
  WorldDescription description;
  description.method = Method::kFast;
  const auto torus = Cooked(MakeTorus(0.05, 0.02, 48, 24), 0.001, 3000, Method::kFast);
  description.objects = {{torus, {}}, {torus, At(0.3, 0, 0)}};
  description.pairs = {{.sampled = 1, .field = 0}};
  const auto world = *CollisionWorld::Create(description);
  core::SerialFor serial;
  std::uint32_t num_coherent = 0;
  std::uint32_t num_in_contact = 0;
  for (int i = 0; i < 600; ++i) {
    const double t = 0.01 * i;
    const core::Pose X = At(0.16 + 0.1 * std::cos(2.0 * t), 0.03 * std::sin(3.0 * t), 0, {t, 2.0 * t, 0.3});
    world->SetPose(1, X);
    const StepReport& report = world->Step(&serial);
    num_coherent += report.pairs_coherent;
    num_in_contact += report.pairs_in_contact;
    const FieldWalkResult flat = WalkFieldFlat(*torus->samples, *torus->field, X, 0.0);
    if (flat.num_colliding > 0) {
      ASSERT_EQ(report.pairs_in_contact, 1U) << i;
    }
    // Finer points touch before the samples that they belong to, by no more than these reach.
    const double reach_m = torus->samples->reach_m;
    if (report.pairs_in_contact > 0) {
      ASSERT_GT(WalkFieldFlat(*torus->samples, *torus->field, X, reach_m).num_near, 0U) << i;
    }
  }
  EXPECT_GT(num_coherent, 50U);
  EXPECT_GT(num_in_contact, 50U);
}

// What it remembers of its last contact does not count.
TEST(FastWorld, APairThatIsSwitchedOnAgainIsAsNew) {
  WorldDescription description;
  description.method = Method::kFast;
  description.objects = {{Cooked(MakeBox({0.1, 0.1, 0.04}), 0.0005, 0, Method::kFast), {}},
                         {Cooked(MakeTorus(0.03, 0.012, 48, 24), 0, 4000, Method::kFast), {}}};
  description.pairs = {{.sampled = 1, .field = 0, .accuracy = 0.001, .negligible_N = 0.0}};
  const auto used = *CollisionWorld::Create(description);
  const auto fresh = *CollisionWorld::Create(description);
  core::SerialFor serial;
  for (int i = 0; i < 60; ++i) {
    used->SetPose(1, At(1e-4 * i, 0, 0.0325 - 2e-5 * i, {0.3, 0.1, 0}));
    used->Step(&serial);
  }
  used->SetActive(0, false);
  used->Step(&serial);
  used->SetActive(0, true);
  for (const double depth_m : {1e-4, 2e-4, 1e-3}) {
    const core::Pose X = At(0, 0, 0.0399 - depth_m, {0.5, 0.2, 0});
    for (CollisionWorld* const world : {used.get(), fresh.get()}) {
      world->SetPose(1, X);
      world->Step(&serial);
    }
    ASSERT_TRUE(fresh->result(0).is_in_contact);
    EXPECT_EQ(used->result(0).F_So_W.force_N, fresh->result(0).F_So_W.force_N) << depth_m;
    EXPECT_EQ(used->result(0).force_error_N, fresh->result(0).force_error_N) << depth_m;
    EXPECT_EQ(used->result(0).counters.points_tested, fresh->result(0).counters.points_tested) << depth_m;
  }
}

// A ball rolls on a plate. Where it lay has a plane for as long as the tool keeps it, though others are nearer by then;
// else it gives its plane up.
TEST(FastWorld, APlaceThatCarriesKeepsItsPlane) {
  for (const bool is_kept : {true, false}) {
    WorldDescription description;
    description.method = Method::kFast;
    description.objects = {{Cooked(MakeBox({0.1, 0.1, 0.04}), 0.0005, 0, Method::kFast), {}},
                           {Cooked(MakeSphere(0.02, 64), 0, 4000, Method::kFast), {}}};
    description.pairs = {{.sampled = 1, .field = 0, .has_gaps = true}};
    const auto world = *CollisionWorld::Create(description);
    core::SerialFor serial;
    const auto planes_at = [&](const core::Pose& X_WS) {
      ToolContact contact;
      world->SetPose(1, X_WS);
      world->Step(&serial);
      world->HandPlanes({0, 1}, &contact);
      return contact.planes;
    };
    const core::Pose X_before = At(0, 0, 0.04 - 1e-5);
    const auto before = planes_at(X_before);
    ASSERT_FALSE(before.empty());
    const ToolPlane carrying =
        *std::min_element(before.begin(), before.end(), [](const auto& a, const auto& b) { return a.gap_m < b.gap_m; });
    const glm::dvec3 p_S = X_before.inverse() * carrying.p_W;
    bool is_there = false;
    for (int i = 0; i < 30; ++i) {
      if (is_kept) world->KeepHandPlane(carrying.id);
      const core::Pose X_WS = At(0, 0, 0.04 - 1e-5, {0, 0.25 + 1e-3 * i, 0});
      is_there = false;
      for (const ToolPlane& plane : planes_at(X_WS)) {
        is_there = is_there || (plane.id == carrying.id && glm::distance(X_WS.inverse() * plane.p_W, p_S) < 1e-3);
      }
    }
    EXPECT_EQ(is_there, is_kept);
  }
}

TEST(FastWorld, NeedsObjectsThatWereCookedForIt) {
  WorldDescription description;
  description.method = Method::kFast;
  const auto paper = std::make_shared<const CookedObject>(*Cook(MakeBox({0.1, 0.1, 0.1}), {0.002, 500}));
  description.objects = {{paper, {}}, {paper, {}}};
  description.pairs = {{.sampled = 1, .field = 0}};
  EXPECT_FALSE(CollisionWorld::Create(description));
}

TEST(FastWorld, ABudgetOfPointsCutsAHeavyPairShortAndKeepsItsDeepestPoint) {
  const auto whole = OnPlate(MakeTorus(0.03, 0.01, 96, 48), 20000);
  const auto cut = OnPlate(MakeTorus(0.03, 0.01, 96, 48), 20000);
  core::SerialFor serial;
  std::uint32_t num_cut = 0;
  for (int i = 0; i < 40; ++i) {
    const core::Pose X = At(0.01, 1e-4 * i, 0.029 - 2e-5 * i, {0.002 * i, 0.0, 0.1 * i});
    whole->SetPose(1, X);
    cut->SetPose(1, X);
    ASSERT_EQ(whole->Step(&serial).pairs_cut_short, 0U);
    const StepReport& report = cut->Step(&serial, 0, 640);
    num_cut += report.pairs_cut_short;
    ASSERT_EQ(report.pairs_cut_short == 1, cut->result(0).is_cut_short);
    // Within the difference of depth between two samples, 0.04 voxel: of more samples others are refined.
    ASSERT_NEAR(cut->result(0).signed_distance_m, whole->result(0).signed_distance_m, 2e-5);
    ASSERT_LE(cut->result(0).counters.points_tested, whole->result(0).counters.points_tested);
    cut->Step(&serial, 0, 10'000'000);
  }
  EXPECT_GT(num_cut, 10U);
}

TEST(FastWorld, TheCacheGivesBackWhatWasBuilt) {
  const CookedObject object = *Cook(MakeBlockWithHole(0.03, 0.02, 0.01, 1024), {0.001, 3000, Method::kFast});
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "fast_world_test.vps";
  ASSERT_TRUE(WriteCookedFile(file, 7, object));
  const auto read = ReadCookedFile(file, 7);
  ASSERT_TRUE(read) << read.error().detail;
  EXPECT_EQ(read->field->words, object.field->words);
  EXPECT_EQ(read->field->bricks, object.field->bricks);
  EXPECT_EQ(read->field->creases, object.field->creases);
  EXPECT_EQ(read->field->curvatures, object.field->curvatures);
  EXPECT_EQ(read->field->errors, object.field->errors);
  EXPECT_GT(object.field->facets.num_bytes(), 0U);
  EXPECT_EQ(read->field->facets.num_bytes(), object.field->facets.num_bytes());
  const core::Pose X_GS = At(0.003, 0.002, 0.018, {0.2, 0.1, 0.0});
  PairResult built, cached;
  for (const auto& [from, to] : {std::pair{&object, &built}, {&*read, &cached}}) {
    FastPairScratch scratch(*from->samples);
    QueryFastPair(FastPairOf(*from, *from), X_GS, X_GS, {.look_ahead_m = 0.001}, 0.01, &scratch, to);
  }
  EXPECT_TRUE(built.is_in_contact);
  EXPECT_EQ(built.F_So_W.force_N, cached.F_So_W.force_N);
  EXPECT_EQ(built.F_So_W.torque_Nm, cached.F_So_W.torque_Nm);
  EXPECT_EQ(built.force_error_N, cached.force_error_N);
  // A crease that points outside its table is refused even when the checksum is right.
  CookedObject wrong = object;
  wrong.field->words.back() = CreaseWord(kMaxCreases - 1);
  ASSERT_TRUE(WriteCookedFile(file, 7, wrong));
  const auto refused = ReadCookedFile(file, 7);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, core::ErrorCode::kDamaged);
  // So is a tree of facets whose levels do not fit together.
  wrong = object;
  wrong.field->facets.blocks.resize(wrong.field->facets.blocks.size() + kFacetLanes);
  ASSERT_TRUE(WriteCookedFile(file, 7, wrong));
  EXPECT_FALSE(ReadCookedFile(file, 7));
  // And errors that are not those of all bricks.
  wrong = object;
  wrong.field->errors.pop_back();
  ASSERT_TRUE(WriteCookedFile(file, 7, wrong));
  EXPECT_FALSE(ReadCookedFile(file, 7));
  std::filesystem::remove(file);
}

// Even when the checksum is right.
TEST(FastWorld, TheCacheRefusesDamagedSamples) {
  const CookedObject object = *Cook(MakeTorus(0.03, 0.01, 96, 48), {0.0, 3000, Method::kFast});
  ASSERT_GE(object.samples->num_levels, 2U);
  void (*const damages[])(SampleTree*) = {
      [](SampleTree* p) { p->points.resize(p->points.size() + kBlock); },
      [](SampleTree* p) { p->points.pop_back(); },
      [](SampleTree* p) { p->points.clear(); },
      [](SampleTree* p) { p->spheres.clear(); },
      [](SampleTree* p) { p->spheres.pop_back(); },
      [](SampleTree* p) { p->spheres.push_back(p->spheres.back()); },
      [](SampleTree* p) { p->spheres.back().x[kBlock - 1] = 0.0f; },
      [](SampleTree* p) { p->spheres.back().r[kBlock - 1] = 1.0f; },
      [](SampleTree* p) { ++p->level_begin[1]; },
      [](SampleTree* p) { p->num_levels = 0; },
      [](SampleTree* p) { p->num_levels = SphereTree::kMaxLevels + 1; },
      [](SampleTree* p) { p->spheres.resize(p->level_begin[--p->num_levels]); },
  };
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "fast_world_damaged_test.vps";
  ASSERT_TRUE(WriteCookedFile(file, 7, object));
  EXPECT_TRUE(ReadCookedFile(file, 7));
  for (std::size_t i = 0; i < std::size(damages); ++i) {
    CookedObject wrong = object;
    damages[i](&*wrong.samples);
    ASSERT_TRUE(WriteCookedFile(file, 7, wrong));
    const auto refused = ReadCookedFile(file, 7);
    ASSERT_FALSE(refused) << i;
    EXPECT_EQ(refused.error().code, core::ErrorCode::kDamaged);
  }
  std::filesystem::remove(file);
}

// Likewise the surface with its moments, and how the field bends.
TEST(FastWorld, TheCacheKeepsSurfaceAndBendsAndRefusesDamagedOnes) {
  const CookedObject object = *Cook(MakeTorus(0.03, 0.01, 48, 24), {0.001, 3000, Method::kFast});
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "fast_world_surface_test.vps";
  ASSERT_TRUE(WriteCookedFile(file, 7, object));
  const auto read = ReadCookedFile(file, 7);
  ASSERT_TRUE(read) << read.error().detail;
  ASSERT_TRUE(read->surface && read->bends);
  EXPECT_EQ(read->surface->families.size(), object.surface->families.size());
  EXPECT_EQ(read->surface->area_m2, object.surface->area_m2);
  EXPECT_EQ(read->bends->numbers, object.bends->numbers);
  EXPECT_EQ(read->bends->words, object.bends->words);
  EXPECT_EQ(read->bends->brick_errors, object.bends->brick_errors);
  void (*const damages[])(CookedObject*) = {
      [](CookedObject* o) { o->surface->families.back().below[0] = 1U << 30U; },
      [](CookedObject* o) { o->surface->families.front().below[0] = 0; },  // its own family: no walk would end
      [](CookedObject* o) { o->surface->triangles.pop_back(); },
      [](CookedObject* o) { o->surface->nodes.back().first = 1U << 30U; },
      [](CookedObject* o) { o->surface->num_roots = 5; },
      [](CookedObject* o) { o->bends->numbers.back() = 1U << 30U; },
      [](CookedObject* o) { o->bends->numbers.pop_back(); },
      [](CookedObject* o) { ++o->bends->begin.back(); },
      [](CookedObject* o) { o->bends->words.pop_back(); },
      [](CookedObject* o) { o->bends->brick_errors.pop_back(); },
      [](CookedObject* o) { o->bends->inner_errors.pop_back(); },
  };
  for (std::size_t i = 0; i < std::size(damages); ++i) {
    CookedObject wrong = object;
    damages[i](&wrong);
    ASSERT_TRUE(WriteCookedFile(file, 7, wrong));
    const auto refused = ReadCookedFile(file, 7);
    ASSERT_FALSE(refused) << i;
    EXPECT_EQ(refused.error().code, core::ErrorCode::kDamaged);
  }
  std::filesystem::remove(file);
}

TEST(FastWorld, MethodsHaveDifferentCacheKeys) {
  EXPECT_NE(CookedKey("x", 1, {0.001, 100, Method::kPaper}), CookedKey("x", 1, {0.001, 100, Method::kFast}));
}

}  // namespace
}  // namespace vps

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <sstream>

#include "vps/asset/cooked_object.hpp"
#include "vps/field/build_field.hpp"
#include "vps/mesh/check_mesh.hpp"
#include "vps/oracle/mesh_distance.hpp"
#include "vps/testing/case_random.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

float DistanceAt(const DistanceField& field, const glm::dvec3& p_m) {
  return SampleField(field, glm::vec3((p_m - field.origin_m) / field.voxel_size_m)).distance;
}

// A file goes in, a cache file comes out, or one error and nothing.
class DamagedFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("vr_oos_damaged_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path Write(const TriangleMesh& mesh) const {
    std::ofstream out(folder_ / "part.off");
    out.precision(17);
    out << "OFF\n" << mesh.vertices.size() << ' ' << mesh.triangles.size() << " 0\n";
    for (const auto& v : mesh.vertices) out << v.x << ' ' << v.y << ' ' << v.z << '\n';
    for (const auto& t : mesh.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
    return folder_ / "part.off";
  }

  // The error of both methods, which must be the same; the cache must stay empty.
  std::string Refusal(const TriangleMesh& mesh, CookParameters parameters) const {
    const fs::path file = Write(mesh);
    std::string detail;
    for (const Method method : {Method::kPaper, Method::kFast}) {
      parameters.method = method;
      const auto cooked = Cook(file, parameters, folder_ / "cache");
      EXPECT_FALSE(cooked.has_value());
      EXPECT_FALSE(fs::exists(folder_ / "cache"));
      if (cooked) continue;
      EXPECT_THAT(cooked.error().detail, HasSubstr("part.off"));
      detail = cooked.error().detail;
    }
    return detail;
  }

  fs::path folder_;
};

TEST_F(DamagedFile, WithoutTrianglesIsRefused) {
  EXPECT_NE(Refusal({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}}, {0.01, 100}), "");
}

TEST_F(DamagedFile, OfNeedlesIsRefused) {
  EXPECT_THAT(Refusal({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}}, {0.01, 100}),
              HasSubstr("no triangle with an area"));
}

TEST_F(DamagedFile, WithACornerThatIsNoNumberIsRefused) {
  auto mesh = MakeBox({0.1, 0.1, 0.1});
  mesh.vertices[3].z = std::nan("");
  EXPECT_THAT(Refusal(mesh, {0.01, 100}), HasSubstr("part.off:6: a corner is not a finite number"));
}

TEST_F(DamagedFile, InTheWrongUnitIsRefused) {
  EXPECT_THAT(Refusal(MakeBox({80, 50, 30}), {0.001, 100}), HasSubstr("80 m"));
  EXPECT_THAT(Refusal(MakeBox({8e-5, 5e-5, 3e-5}), {1e-6, 100}), HasSubstr("8e-05 m"));
}

TEST_F(DamagedFile, WithTooSmallVoxelsIsRefused) {
  EXPECT_NE(Refusal(MakeBox({10, 10, 10}), {1e-5, 0}), "");
}

TEST_F(DamagedFile, ThatIsOpenIsRefusedUnlessItIsASheetThickEnough) {
  const TriangleMesh plate{{{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0, 0.1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  EXPECT_THAT(Refusal(plate, {0.001, 100}), HasSubstr("4 open edges"));
  CookParameters thin{0.001, 100};
  thin.sheet_half_thickness_m = 0.0002;
  EXPECT_THAT(Refusal(plate, thin), HasSubstr("too thin"));
  for (const Method method : {Method::kPaper, Method::kFast}) {
    CookParameters sheet{0.001, 500, method};
    sheet.sheet_half_thickness_m = 0.002;
    const auto cooked = Cook(Write(plate), sheet, folder_ / "cache");
    ASSERT_TRUE(cooked) << cooked.error().detail;
    EXPECT_TRUE(cooked->has_field(method) && cooked->has_points(method));
  }
}

TEST_F(DamagedFile, OfTenMetresIsBuilt) {
  CookParameters parameters{0.1, 1000, Method::kFast};
  const auto cooked = Cook(Write(MakeTorus(4.0, 1.0, 64, 32)), parameters, folder_ / "cache");
  ASSERT_TRUE(cooked) << cooked.error().detail;
  // On the medial axis the field holds the mean depth over a coarse cell (decision 13).
  EXPECT_NEAR(DistanceAt(*cooked->field, {4.0, 0, 0}) * 0.1, -1.0, 0.05);
}

TEST_F(DamagedFile, FacingInwardsIsTurned) {
  auto mesh = MakeSphere(0.05, 32);
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  const auto cooked = Cook(Write(mesh), {0.002, 200, Method::kFast}, folder_ / "cache");
  ASSERT_TRUE(cooked) << cooked.error().detail;
  EXPECT_LT(DistanceAt(*cooked->field, {0, 0, 0.03}), 0.0f);
}

TEST_F(DamagedFile, InTheCacheIsBuiltAnewWithANote) {
  const fs::path mesh = Write(MakeSphere(0.05, 32));
  ASSERT_TRUE(Cook(mesh, {0.002, 200, Method::kFast}, folder_ / "cache"));
  for (const auto& entry : fs::directory_iterator(folder_ / "cache")) fs::resize_file(entry.path(), 1000);
  const auto cooked = Cook(mesh, {0.002, 200, Method::kFast}, folder_ / "cache");
  ASSERT_TRUE(cooked);
  EXPECT_THAT(cooked->cache_note, HasSubstr("wrong length; built anew"));
  EXPECT_EQ(Cook(mesh, {0.002, 200, Method::kFast}, folder_ / "cache")->cache_note, "");
}

void ExpectSignsOfTheWindingNumber(const TriangleMesh& mesh, const CheckedMesh& checked) {
  EXPECT_FALSE(checked.report.is_simple_solid);
  const auto cooked = Cook(checked.mesh, {0.0015, 0, Method::kFast});
  ASSERT_TRUE(cooked) << cooked.error().detail;
  const oracle::MeshDistance exact(mesh);
  CaseRandom random(7);
  for (int i = 0; i < 8000; ++i) {
    const glm::dvec3 p = 0.05 * random.InCube();
    if (exact.UnsignedDistance(p) < 0.0006) continue;
    ASSERT_EQ(DistanceAt(*cooked->field, p) < 0.0f, exact.IsInside(p)) << p.x << " " << p.y << " " << p.z;
  }
}

// Where solids of one mesh pass through each other, the winding number determines the inside.
TEST(FieldOfOverlappingSolids, HasTheSignsOfTheWindingNumber) {
  const TriangleMesh mesh = Joined(MakeBox({0.06, 0.04, 0.03}), MakeSphere(0.025, 32), glm::dvec3(0.021, 0.007, 0.011));
  const auto checked = CheckMesh(mesh);
  ASSERT_TRUE(checked);
  EXPECT_GT(checked->report.num_crossings, 0U);
  ExpectSignsOfTheWindingNumber(mesh, *checked);
}

// A block stands on a plate: the two faces that lie on each other bound nothing.
TEST(FieldOfOverlappingSolids, IsInsideOnBothSidesWhereOnePartStandsOnAnother) {
  const TriangleMesh mesh =
      Joined(MakeBox({0.08, 0.06, 0.02}), MakeBox({0.024, 0.018, 0.04}), glm::dvec3(0.011, 0.004, 0.03));
  const auto checked = CheckMesh(mesh);
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked->report.num_crossings, 0U);
  ExpectSignsOfTheWindingNumber(mesh, *checked);
}

// An open plate of 40 x 30 mm is a box with a thickness, in closed form.
TEST(FieldOfASheet, OfAnOpenPlateIsABoxes) {
  const TriangleMesh plate{{{-0.02, -0.015, 0}, {0.02, -0.015, 0}, {0.02, 0.015, 0}, {-0.02, 0.015, 0}},
                           {{0, 1, 2}, {0, 2, 3}}};
  for (const double half_thickness_m : {0.0007, 0.006}) {
    CookParameters parameters{0.001, 0, Method::kFast};
    parameters.sheet_half_thickness_m = half_thickness_m;
    const auto cooked = Cook(plate, parameters);
    ASSERT_TRUE(cooked) << cooked.error().detail;
    EXPECT_FALSE(cooked->field->facets.blocks.empty());  // a hand feels exact gaps
    CaseRandom random(2);
    int near_surface = 0;
    for (int i = 0; i < 20000; ++i) {
      const glm::dvec3 p = random.InCube() * glm::dvec3(0.03, 0.025, 0.01);
      const glm::dvec3 over = glm::abs(p) - glm::dvec3(0.02, 0.015, half_thickness_m);
      const double d = glm::length(glm::max(over, 0.0)) + std::min(std::max({over.x, over.y, over.z}), 0.0);
      if (std::abs(d) > 0.0015) continue;
      ++near_surface;
      ASSERT_NEAR(DistanceAt(*cooked->field, p), d * 1e3, 0.3) << p.x << " " << p.y << " " << p.z;
    }
    EXPECT_GT(near_surface, 1000);
  }
}

// A sheet's field against the oracle's two-sided distance, less the half thickness; beside its rim, which is square.
TEST(FieldOfASheet, IsTheOraclesTwoSidedDistance) {
  TriangleMesh bowl = MakeSphere(0.03, 48);
  std::erase_if(bowl.triangles, [&](const auto& t) {
    return bowl.vertices[t[0]].z + bowl.vertices[t[1]].z + bowl.vertices[t[2]].z > 0.045;
  });
  const auto checked = CheckMesh(bowl, true);
  ASSERT_TRUE(checked) << checked.error().detail;
  const oracle::MeshDistance exact(checked->mesh, oracle::MeshDistance::Sides::kSheet);
  for (const double thickness_m : {0.001, 0.004}) {
    CookParameters parameters{0.001, 0, Method::kFast};
    parameters.sheet_half_thickness_m = 0.5 * thickness_m;
    const auto cooked = Cook(checked->mesh, parameters);
    ASSERT_TRUE(cooked) << cooked.error().detail;
    CaseRandom random(3);
    double sum = 0.0;
    int count = 0;
    for (int i = 0; i < 20000; ++i) {
      const glm::dvec3 p = 0.034 * random.InCube();
      if (p.z > 0.45 * glm::length(p)) continue;  // the rim is at 0.5
      const double d = exact.SignedDistance(p) - 0.5 * thickness_m;
      if (std::abs(d) > 0.0015) continue;
      const double error = std::abs(DistanceAt(*cooked->field, p) - 1e3 * d);
      ASSERT_LT(error, 0.3) << thickness_m << ": " << p.x << " " << p.y << " " << p.z;
      sum += error;
      ++count;
    }
    EXPECT_GT(count, 500);
    EXPECT_LT(sum / count, 0.02) << thickness_m;
  }
}

// One piece of damage; where it is, or nothing when it reaches everywhere.
struct Damage {
  glm::dvec3 p_m{0.0};
  bool is_everywhere = false;
};
using Wrecker = Damage (*)(TriangleMesh*, CaseRandom*);

Damage LoseATriangle(TriangleMesh* mesh, CaseRandom* random) {
  const std::size_t t = random->Below(mesh->triangles.size());
  const Damage damage{mesh->corners(t)[0]};
  mesh->triangles.erase(mesh->triangles.begin() + static_cast<std::ptrdiff_t>(t));
  return damage;
}
Damage TurnATriangle(TriangleMesh* mesh, CaseRandom* random) {
  auto& t = mesh->triangles[random->Below(mesh->triangles.size())];
  std::swap(t[0], t[1]);
  return {mesh->vertices[t[0]]};
}
Damage TurnAll(TriangleMesh* mesh, CaseRandom*) {
  for (auto& t : mesh->triangles) std::swap(t[0], t[1]);
  return {mesh->vertices[0]};
}
Damage DoubleATriangle(TriangleMesh* mesh, CaseRandom* random) {
  mesh->triangles.push_back(mesh->triangles[random->Below(mesh->triangles.size())]);
  return {mesh->vertices[mesh->triangles.back()[0]]};
}
Damage CollapseATriangle(TriangleMesh* mesh, CaseRandom* random) {
  auto& t = mesh->triangles[random->Below(mesh->triangles.size())];
  t[1] = t[0];
  return {mesh->vertices[t[0]]};
}
Damage PushACorner(TriangleMesh* mesh, CaseRandom* random) {
  glm::dvec3& p = mesh->vertices[mesh->triangles[random->Below(mesh->triangles.size())][0]];
  p += 0.01 * random->InCube();
  return {p};
}
Damage AddALooseTriangle(TriangleMesh* mesh, CaseRandom* random) {
  const glm::dvec3 p = mesh->corners(random->Below(mesh->triangles.size()))[0];
  const auto n = static_cast<std::uint32_t>(mesh->vertices.size());
  for (int k = 0; k < 3; ++k) mesh->vertices.push_back(p + 0.008 * random->InCube());
  mesh->triangles.push_back({n, n + 1, n + 2});
  return {p};
}
Damage SplitCorners(TriangleMesh* mesh, CaseRandom* random) {
  for (auto& t : mesh->triangles) {
    if (random->Unit() < 0.5) continue;
    for (std::uint32_t& v : t) {
      mesh->vertices.push_back(mesh->vertices[v]);
      v = static_cast<std::uint32_t>(mesh->vertices.size() - 1);
    }
  }
  return {mesh->vertices[0]};
}
Damage PutANan(TriangleMesh* mesh, CaseRandom* random) {
  mesh->vertices[mesh->triangles[random->Below(mesh->triangles.size())][2]].y =
      std::numeric_limits<double>::quiet_NaN();
  return {{}, true};
}
Damage PointAstray(TriangleMesh* mesh, CaseRandom* random) {
  mesh->triangles[random->Below(mesh->triangles.size())][1] = 1'000'000;
  return {{}, true};
}
Damage LoseHalf(TriangleMesh* mesh, CaseRandom* random) {
  std::erase_if(mesh->triangles, [&](const auto&) { return random->Unit() < 0.5; });
  return {{}, true};
}

// Away from the damage the signs are those of the sound shape, or there is one error in a sentence.
TEST(DamagedMesh, IsRepairedOrRefusedWithOneError) {
  constexpr Wrecker kWreckers[] = {LoseATriangle,     TurnATriangle, TurnAll,           DoubleATriangle,
                                   CollapseATriangle, PushACorner,   AddALooseTriangle, SplitCorners,
                                   PutANan,           PointAstray,   LoseHalf};
  const TriangleMesh shapes[] = {MakeSphere(0.04, 32), MakeTorus(0.035, 0.012, 48, 24), MakeCylinder(0.03, 0.06, 48)};
  int num_built = 0, num_refused = 0;
  for (std::uint64_t seed = 0; seed < 48; ++seed) {
    CaseRandom random(seed);
    const TriangleMesh& sound = shapes[seed % 3];
    TriangleMesh mesh = sound;
    std::vector<Damage> damages;
    for (std::size_t n = 1 + random.Below(3); n > 0; --n) {
      const std::size_t kind = random.Below(std::size(kWreckers));
      const bool is_index_good = damages.empty() || !damages.back().is_everywhere;
      if (is_index_good) damages.push_back(kWreckers[kind](&mesh, &random));
    }
    const auto checked = CheckMesh(mesh);
    if (!checked) {
      ++num_refused;
      EXPECT_GT(checked.error().detail.size(), 20U) << seed;
      EXPECT_EQ(checked.error().detail.find('\n'), std::string::npos) << seed;
      continue;
    }
    const auto cooked = Cook(checked->mesh, {0.003, 0, Method::kFast});
    ASSERT_TRUE(cooked) << seed << ": " << cooked.error().detail;
    ++num_built;
    const oracle::MeshDistance exact(sound);
    for (int i = 0; i < 400; ++i) {
      const glm::dvec3 p = 0.055 * random.InCube();
      bool is_near_damage = exact.UnsignedDistance(p) < 0.0015;
      for (const Damage& damage : damages) is_near_damage |= glm::length(p - damage.p_m) < 0.025;
      if (is_near_damage) continue;
      ASSERT_EQ(DistanceAt(*cooked->field, p) < 0.0f, exact.IsInside(p))
          << "seed " << seed << ": " << testing::PrintToString(DescribeDefects(checked->report)) << " at " << p.x << " "
          << p.y << " " << p.z;
    }
  }
  EXPECT_GT(num_built, 15);
  EXPECT_GT(num_refused, 6);
}

// The public meshes, where they are.
TEST(PublicMeshes, AreRepairedIntoSolids) {
  const fs::path folder = fs::path(VR_OOS_SOURCE_DIR) / "../shared/data/meshes";
  if (!fs::exists(folder)) GTEST_SKIP() << "no " << folder;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".obj") continue;
    const auto checked = LoadCheckedMesh(entry.path());
    ASSERT_TRUE(checked) << checked.error().detail;
    EXPECT_EQ(CountOpenEdges(checked->mesh), 0U) << entry.path();
    EXPECT_GT(checked->report.volume_m3, 0.0) << entry.path();
  }
}

}  // namespace
}  // namespace vps

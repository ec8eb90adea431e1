#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "core/testing/backward_threads.hpp"
#include "vps/field/build_field.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

template <class T>
bool IsSame(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void ExpectTheSameField(const TriangleMesh& mesh, double voxel_size_m) {
  const auto everywhere = BuildField(mesh, voxel_size_m, {.signs = Signs::kWindingEverywhere});
  core::test::BackwardThreads workers(2);
  const auto settled = BuildField(mesh, voxel_size_m, {.signs = Signs::kWinding, .workers = &workers});
  ASSERT_TRUE(everywhere && settled);
  ASSERT_GT(everywhere->creases.size(), 500U);
  EXPECT_TRUE(IsSame(settled->bricks, everywhere->bricks));
  EXPECT_TRUE(IsSame(settled->words, everywhere->words));
  EXPECT_TRUE(IsSame(settled->creases, everywhere->creases));
  EXPECT_TRUE(IsSame(settled->coarse, everywhere->coarse));
}

// Solids that pass through each other, and one that stands on another: nearly no triangle's normal is trusted.
TEST(SettledSigns, GiveTheFieldOfSignsAskedEverywhere) {
  const TriangleMesh box = MakeBox({0.06, 0.04, 0.03});
  ExpectTheSameField(Joined(box, MakeSphere(0.025, 32), {0.021, 0.007, 0.011}), 0.002);
  ExpectTheSameField(Joined(box, MakeTorus(0.03, 0.005, 48, 16), {0.0, 0.0, 0.013}), 0.0013);
  ExpectTheSameField(Joined(box, MakeBox({0.024, 0.018, 0.04}), {0.011, 0.004, 0.035}), 0.002);
}

// Where a solid has a hole the winding number passes 0.5 in the open: no place settles another's sign.
TEST(SettledSigns, DoNotSpreadThroughAHole) {
  TriangleMesh mesh = Joined(MakeBox({0.06, 0.04, 0.03}), MakeSphere(0.025, 32), {0.021, 0.007, 0.011});
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 2);  // a face of the box
  ExpectTheSameField(mesh, 0.002);
}

// A brick's samples around a plane in general position: those of a side hang together, but for some so close to the
// plane that no neighbour's ball reaches theirs.
TEST(SampleSigns, AsksFewOfTheSamplesBesideAPlane) {
  const glm::dvec3 normal = glm::normalize(glm::dvec3(0.71, -0.33, 0.46));
  for (int step = 0; step < 40; ++step) {
    const double offset = glm::dot(normal, glm::dvec3(3.5)) + 0.05 * (step - 20);
    const auto height_of = [&](std::size_t k) {
      return glm::dot(normal, glm::dvec3(k & 7, k >> 3 & 7, k >> 6)) - offset;
    };
    SampleSigns signs;
    for (std::size_t k = 0; k < 512; ++k) {
      const double distance = std::abs(height_of(k));
      signs.radius[k] = distance < 3.0 ? static_cast<float>(distance) : -1.0f;
      signs.is_wanted[k] = distance < 3.0;
    }
    int num_asked = 0;
    signs.Settle(true, [&](std::size_t k) {
      ++num_asked;
      return height_of(k) < 0.0 ? -1.0f : 1.0f;
    });
    EXPECT_LE(num_asked, 512 / 20);
    for (std::size_t k = 0; k < 512; ++k) {
      if (!signs.is_wanted[k]) continue;
      ASSERT_EQ(signs.sign[k], height_of(k) < 0.0 ? -1.0f : 1.0f) << step << " " << k;
    }
  }
}

}  // namespace
}  // namespace vps

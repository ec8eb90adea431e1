#include "device/calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>
#include <vector>

namespace device {
namespace {

// Own distributions: those of the standard library differ between platforms.
double Uniform(std::mt19937_64& random) {
  return 2.0 * static_cast<double>(random() >> 11) * 0x1.0p-53 - 1.0;
}
glm::dvec3 Vector(std::mt19937_64& random) {
  return {Uniform(random), Uniform(random), Uniform(random)};
}

TEST(Calibration, FindsTheBaseExactlyFromExactPoints) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 500; ++i) {
    const core::Pose X_WB{core::QuaternionFromRotationVector(3.14 * Vector(random) / std::sqrt(3.0)), Vector(random)};
    std::vector<glm::dvec3> p_Bs, p_Ws;
    for (int k = 0; k < 3 + i % 4; ++k) {
      p_Bs.push_back(0.3 * Vector(random));
      p_Ws.push_back(X_WB * p_Bs.back());
    }
    const auto fit = FitRigid(p_Bs, p_Ws);
    ASSERT_TRUE(fit) << fit.error().detail;
    EXPECT_LT(glm::length(fit->X_WB.translation - X_WB.translation), 1e-9);
    EXPECT_LT(glm::length(core::RotationVector(fit->X_WB.rotation * glm::conjugate(X_WB.rotation))), 1e-9);
    EXPECT_LT(fit->residual_m, 1e-9);
  }
}

// A plane of points leaves a reflection that would fit as well: it must not be chosen. Errors of 1 mm are told as such.
TEST(Calibration, GivesTheResidualOfPointsThatAreOff) {
  const std::vector<glm::dvec3> p_Ws = {{0, 0, 0}, {0.2, 0, 0}, {0.2, 0.2, 0}, {0, 0.2, 0}};
  std::vector<glm::dvec3> p_Bs = p_Ws;
  // A twist of the square that no rigid motion removes.
  for (std::size_t k = 0; k < 4; ++k) p_Bs[k].z = k % 2 == 0 ? 0.001 : -0.001;
  const auto fit = FitRigid(p_Bs, p_Ws);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->residual_m, 0.001, 1e-9);
  EXPECT_NEAR(fit->largest_residual_m, 0.001, 1e-9);
  EXPECT_NEAR(fit->X_WB.rotation.w, 1.0, 1e-9);
}

TEST(Calibration, RefusesWhatDoesNotDetermineAPose) {
  const std::vector<glm::dvec3> line = {{0, 0, 0}, {0.1, 0, 0}, {0.3, 0, 0}};
  EXPECT_FALSE(FitRigid(line, line));
  const std::vector<glm::dvec3> still(3, glm::dvec3(0.1));
  const std::vector<glm::dvec3> triangle = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}};
  EXPECT_FALSE(FitRigid(still, triangle));
  EXPECT_FALSE(FitRigid({triangle.data(), 2}, {triangle.data(), 2}));
  std::vector<glm::dvec3> broken = triangle;
  broken[1].y = std::nan("");
  EXPECT_FALSE(FitRigid(broken, triangle));
}

TEST(Calibration, IsKeptForEachSpecimen) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "device_calibration";
  std::filesystem::remove_all(folder);
  Calibration calibration;
  calibration.name = "my arm/../x";
  calibration.serial = "A 1";
  calibration.X_WB = {core::QuaternionFromRotationVector({0.1, 0.2, 0.3}), {1, 2, 3}};
  calibration.residual_m = 0.0007;
  ASSERT_TRUE(Keep(calibration, folder));
  EXPECT_EQ(CalibrationFile(folder, calibration.name, calibration.serial).parent_path(), folder);
  std::string why;
  const auto found = FindCalibration(folder, calibration.name, calibration.serial, &why);
  ASSERT_TRUE(found) << why;
  EXPECT_EQ(found->X_WB.translation.z, 3.0);
  EXPECT_DOUBLE_EQ(found->X_WB.rotation.w, calibration.X_WB.rotation.w);
  EXPECT_EQ(found->residual_m, 0.0007);
  EXPECT_FALSE(FindCalibration(folder, calibration.name, "A 2", &why));
  EXPECT_EQ(why, "");
  std::ofstream(CalibrationFile(folder, "x", "1")) << "{\"X_WB\": [0, 0, 0, 0, 1, 2, 3], \"residual_m\": 0}";
  EXPECT_FALSE(FindCalibration(folder, "x", "1", &why));
  EXPECT_NE(why.find("calibrate again"), std::string::npos);
}

}  // namespace
}  // namespace device

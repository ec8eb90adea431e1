#include "tools/oos/doctor/doctor_devices.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace oos {
namespace {

TEST(CheckDeviceFiles, NamesWhatCannotBeOpenedAndTheRuleForIt) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "doctor_devices";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  EXPECT_EQ(CheckDeviceFiles(folder).grade, Grade::kOk);
  std::ofstream(folder / "ttyACM0") << "";
  std::ofstream(folder / "sda") << "";
  EXPECT_EQ(CheckDeviceFiles(folder).grade, Grade::kOk);
  // root may open everything, but not what is not there.
  std::filesystem::create_symlink(folder / "nowhere", folder / "hidraw3");
  const Finding finding = CheckDeviceFiles(folder);
  EXPECT_EQ(finding.grade, Grade::kWarn);
  EXPECT_NE(finding.what.find("hidraw3"), std::string::npos);
  EXPECT_EQ(finding.what.find("ttyACM0"), std::string::npos);
  EXPECT_NE(finding.remedy.find("70-vr-oos-devices.rules"), std::string::npos);
}

}  // namespace
}  // namespace oos

#include "tools/transport/bench.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

namespace transport {
namespace {

std::string Read(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(TransportBench, RefusesAnUnknownStudyAndNamesTheKnown) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(BenchMain({{}, {}, "hop,colour"}, {}), 2);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("no 'colour' to measure; known: hop"));
}

TEST(TransportBench, WritesChartTableAndGoalsOfTheSelectedStudies) {
  const auto folder = std::filesystem::temp_directory_path() / ("vr_oos_bus_" + std::to_string(::getpid()));
  testing::internal::CaptureStdout();
  EXPECT_EQ(BenchMain({folder / "all.json", folder, "hop"}, {}, 0.01), 0);
  testing::internal::GetCapturedStdout();
  for (const char* transport : {"raw UDP", "LATEST", "raw ZeroMQ, tcp", "raw ZeroMQ, ipc", "shared memory, futex"}) {
    EXPECT_THAT(Read(folder / "hop.svg"), testing::HasSubstr(transport));
    EXPECT_THAT(Read(folder / "hop.csv"), testing::HasSubstr(transport));
  }
  EXPECT_THAT(Read(folder / "encryption.csv"), testing::HasSubstr("LATEST: hop of 215 B,us,10,"));
  EXPECT_THAT(Read(folder / "goals.md"), testing::HasSubstr("| at most 1.5 |"));
  EXPECT_THAT(Read(folder / "all.json"), testing::HasSubstr("\"bench\": \"bus\""));
  EXPECT_FALSE(std::filesystem::exists(folder / "age.svg"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace transport

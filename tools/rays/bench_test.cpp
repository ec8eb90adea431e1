#include "tools/rays/bench.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace rays {
namespace {

TEST(RaysBench, WritesTheSameChartOfEmulatedWorkersEachTime) {
  const auto run = [](const char* name) {
    const std::filesystem::path plot = std::filesystem::path(testing::TempDir()) / name;
    EXPECT_EQ(BenchMain({.json = {}, .plot = plot, .only = "efficiency"}, "", ""), 0);
    EXPECT_TRUE(std::filesystem::exists(plot / "efficiency.svg"));
    EXPECT_TRUE(std::filesystem::exists(plot / "goals.md"));
    std::ifstream in(plot / "efficiency.csv");
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string table = run("rays_plot");
  EXPECT_NE(table.find("\n12,"), std::string::npos) << table;
  EXPECT_EQ(run("rays_plot_2"), table);
}

TEST(RaysBench, AnUnknownStudyIsRefused) {
  EXPECT_NE(BenchMain({.json = {}, .plot = {}, .only = "efficency"}, "", ""), 0);
}

}  // namespace
}  // namespace rays

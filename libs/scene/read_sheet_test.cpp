#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "scene/read_scenario.hpp"
#include "scene/xml.hpp"

namespace scene {
namespace {

using testing::HasSubstr;

class ReadSheetTest : public testing::Test {
 protected:
  Sheet Read(const std::map<std::string, std::string>& changes) {
    std::map<std::string, std::string> values{
        {"size_m", "0.3 0.2"}, {"cells", "12 8"}, {"seam_size_m", "0.05 0.04"}, {"bending_stiffness_Nm", "0.003"}};
    for (const auto& [name, value] : changes) values[name] = value;
    XmlElement element;
    element.name = "sheet";
    for (const auto& [name, value] : values) element.attributes.push_back({"", name, value, 7});
    diagnostics_.clear();
    return ReadSheet(element, object_, "scenario.xml", &diagnostics_);
  }
  void SetUp() override {
    object_.name = "cover";
    object_.owner = Owner::kPhysics;
  }

  Object object_;
  std::vector<Diagnostic> diagnostics_;
};

TEST_F(ReadSheetTest, ReadsEveryFigure) {
  const Sheet sheet = Read({{"position", "0.1 0.2 0.3"}, {"friction", "0.4"}, {"active", "false"}});
  EXPECT_TRUE(diagnostics_.empty());
  EXPECT_EQ(sheet.size_x_m, 0.3);
  EXPECT_EQ(sheet.size_y_m, 0.2);
  EXPECT_EQ(sheet.cells_x, 12);
  EXPECT_EQ(sheet.cells_y, 8);
  EXPECT_EQ(sheet.seam_x_m, 0.05);
  EXPECT_EQ(sheet.seam_y_m, 0.04);
  EXPECT_EQ(sheet.bending_stiffness_Nm, 0.003);
  EXPECT_EQ(sheet.friction, 0.4);
  EXPECT_EQ(sheet.X_OS.translation, glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_FALSE(sheet.is_active);
}

TEST_F(ReadSheetTest, ReportsInvalidValuesWithTheirLine) {
  const auto complaint = [&](const char* name, const char* value) {
    Read({{name, value}});
    EXPECT_EQ(diagnostics_.size(), 1u) << name;
    return diagnostics_.empty() ? std::string() : Format(diagnostics_.front());
  };
  EXPECT_THAT(complaint("size_m", "0.3"), HasSubstr("scenario.xml:7: "));
  EXPECT_THAT(complaint("size_m", "0.3 -0.2"), HasSubstr("size_m is not two numbers above zero"));
  EXPECT_THAT(complaint("cells", "60 40"), HasSubstr("room for 1024 nodes"));
  EXPECT_THAT(complaint("cells", "12 2"), HasSubstr("times as long as wide"));
  object_.owner = Owner::kFixed;
  EXPECT_THAT(complaint("friction", "0.1"), HasSubstr("not moved by physics"));
}

}  // namespace
}  // namespace scene

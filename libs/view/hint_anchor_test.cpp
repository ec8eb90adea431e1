#include "view/hint_anchor.hpp"

#include <gtest/gtest.h>

namespace view {
namespace {

const std::vector<std::string> kParts = {"satellite", "cover", "handle", "module_old", "module_new", "lamp_a"};

TEST(HintAnchor, FindsThePartThatAnInstructionNames) {
  EXPECT_EQ(FindNamedObject("Take the cover by its tab, pull it off", kParts), 1);
  EXPECT_EQ(FindNamedObject("Fetch the NEW module and put it on the satellite", kParts), 4);
  EXPECT_EQ(FindNamedObject("Lay the handle on the cover", kParts), 2) << "the first that is named";
}

TEST(HintAnchor, PointsAtNothingRatherThanAtTheWrongPart) {
  EXPECT_EQ(FindNamedObject("Pull the module out", kParts), -1) << "which of the two is not said";
  EXPECT_EQ(FindNamedObject("Discover the lamps", kParts), -1) << "parts of words";
  EXPECT_EQ(FindNamedObject("", kParts), -1);
}

}  // namespace
}  // namespace view

#include "core/names.hpp"

#include <gtest/gtest.h>

namespace core {
namespace {

TEST(NearestName, FindsTypingErrorsAndNothingElse) {
  EXPECT_EQ(NearestName("stifness_N_per_m", {"mass_kg", "stiffness_N_per_m"}), "stiffness_N_per_m");
  EXPECT_EQ(NearestName("lamp", {"satellite", "module"}), "");
}

TEST(SuggestName, NamesAllOfAShortListAndTheNearestOfALongOne) {
  EXPECT_EQ(SuggestName("plat", {"lamp", "plate"}), "did you mean 'plate'? Known: 'lamp' and 'plate'");
  EXPECT_EQ(SuggestName("nonsense", {"lamp", "plate"}), "use one of the known names: 'lamp' and 'plate'");
  EXPECT_EQ(SuggestName("nonsense", {}), "use one of the known names: none");
  std::vector<std::string> many;
  for (int i = 100; i < 125; ++i) many.push_back("pair." + std::to_string(i));
  many.emplace_back("force_cap_N");
  const std::string text = SuggestName("force_cp_N", many);
  EXPECT_EQ(text.find("did you mean 'force_cap_N'? Known: 'force_cap_N', 'pair.1"), 0U) << text;
  EXPECT_NE(text.find("and 6 more"), std::string::npos) << text;
}

}  // namespace
}  // namespace core

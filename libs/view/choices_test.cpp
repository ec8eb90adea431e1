#include "view/choices.hpp"

#include <gmock/gmock.h>

#include <set>

namespace view {
namespace {

using testing::HasSubstr;

const std::vector<std::string> kObjects = {"plate", "block"};

TEST(Choices, EveryOverlayHasItsOwnNameAndKey) {
  std::set<std::string> names;
  std::set<char> keys;
  for (std::size_t i = 0; i < kOverlays.size(); ++i) {
    const OverlayInfo& info = kOverlays[i];
    EXPECT_EQ(IndexOf(info.overlay), i) << info.name;
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_TRUE(keys.insert(info.key).second) << info.key;
    EXPECT_EQ(std::string("WASDQEP").find(info.key), std::string::npos) << "flies or takes a picture: " << info.key;
    EXPECT_EQ(FindOverlay(info.name), info.overlay);
    EXPECT_EQ(FindOverlayOfKey(info.key), info.overlay);
  }
  for (const PartChoice& choice : kPartChoices) EXPECT_TRUE(keys.insert(choice.key).second) << choice.name;
}

TEST(Choices, EveryNameSetsAndClearsItsChoice) {
  for (const std::string& name : ChoiceNames(kObjects)) {
    Choices choices;
    choices.overlays.reset();
    ASSERT_TRUE(SetChoice(name, true, kObjects, &choices)) << name;
    const auto count = [&] {
      std::size_t number = choices.overlays.count();
      for (const Choices::Object& object : choices.objects) {
        number +=
            std::size_t{object.is_hidden} + std::size_t{object.is_transparent} + std::size_t{object.is_highlighted};
      }
      return number + (choices.selected >= 0 ? 1 : 0) + (choices.stereo != Stereo::kNone ? 1 : 0);
    };
    EXPECT_EQ(count(), 1u) << name;
    ASSERT_TRUE(SetChoice(name, false, kObjects, &choices)) << name;
    EXPECT_EQ(count(), 0u) << name;
  }
}

TEST(Choices, AListSwitchesOnAndOff) {
  const auto choices = ReadChoices("paths, no_contacts hide.block", kObjects);
  ASSERT_TRUE(choices) << choices.error().detail;
  EXPECT_TRUE(choices->has(Overlay::kPaths));
  EXPECT_FALSE(choices->has(Overlay::kContacts));
  EXPECT_FALSE(choices->objects[0].is_hidden);
  EXPECT_TRUE(choices->objects[1].is_hidden);
}

TEST(Choices, OneObjectIsSelectedAtMost) {
  const auto choices = ReadChoices("select.plate select.block no_select.plate", kObjects);
  ASSERT_TRUE(choices) << choices.error().detail;
  EXPECT_EQ(choices->selected, 1) << "what is not selected cannot be let go";
  EXPECT_FALSE(ReadChoices("select.blok", kObjects));
}

TEST(Choices, AWrongNameIsRefusedWithTheNearest) {
  const auto choices = ReadChoices("hide.blok", kObjects);
  ASSERT_FALSE(choices);
  EXPECT_THAT(choices.error().detail, HasSubstr("did you mean 'hide.block'?"));
  EXPECT_THAT(ReadChoices("path", kObjects).error().detail, HasSubstr("did you mean 'paths'?"));
}

TEST(Choices, OneStereoModeAtMostIsChosen) {
  Choices choices;
  EXPECT_TRUE(SetChoice("stereo.anaglyph", true, {}, &choices));
  EXPECT_TRUE(SetChoice("stereo.top_bottom", true, {}, &choices));
  EXPECT_EQ(choices.stereo, Stereo::kTopBottom);
  EXPECT_TRUE(SetChoice("stereo.anaglyph", false, {}, &choices));
  EXPECT_EQ(choices.stereo, Stereo::kTopBottom);
  EXPECT_TRUE(SetChoice("stereo.top_bottom", false, {}, &choices));
  EXPECT_EQ(choices.stereo, Stereo::kNone);
  EXPECT_FALSE(SetChoice("stereo.none", true, {}, &choices));
}

}  // namespace
}  // namespace view

#include "bus/topics.hpp"

#include <google/protobuf/descriptor.pb.h>
#include <gtest/gtest.h>

#include <set>

#include "bus/wire/schema.hpp"

namespace bus {
namespace {

static_assert(MatchesPattern("device/*/state", "device/op1/arm.left/state"));
static_assert(!MatchesPattern("device/*/state", "device/right/command"));
static_assert(MatchesPattern("*", ""));
static_assert(!MatchesPattern("a", "ab"));
static_assert(MatchesPattern("a*b*c", "axbxbxc"));
static_assert(!MatchesPattern("a*b*c", "axbxbxcx"));
static_assert(MatchesPattern("**", "a") && !MatchesPattern("", "a") && MatchesPattern("a**", "a"));

TEST(Topics, EveryNameFunctionHitsItsRule) {
  EXPECT_EQ(FindTopicRule(DeviceStateTopic("op1/arm.left"))->type, MessageType::kDeviceState);
  EXPECT_EQ(FindTopicRule(DeviceCommandTopic("right"))->type, MessageType::kDeviceCommand);
  EXPECT_EQ(FindTopicRule(HapticProxyTopic("right"))->type, MessageType::kHapticProxy);
  EXPECT_EQ(FindTopicRule(ContactsTopic("haptic_node", "module/cavity"))->type, MessageType::kContactSet);
  EXPECT_EQ(FindTopicRule(kPhysicsStateTopic)->type, MessageType::kPhysicsState);
  EXPECT_EQ(FindTopicRule(CollisionsTopic("haptic_node"))->type, MessageType::kCollisionMatrix);
  EXPECT_EQ(FindTopicRule(ReactionTopic("op1/arm.left"))->type, MessageType::kReaction);
  EXPECT_EQ(FindTopicRule(SheetTopic("cover"))->type, MessageType::kSheetState);
  EXPECT_EQ(FindTopicRule(kLogicStatusTopic)->topic_class, TopicClass::kState);
  EXPECT_EQ(FindTopicRule(FiguresTopic("visual_node"))->type, MessageType::kFigures);
  EXPECT_EQ(FindTopicRule(BulkTopic("logic_node"))->type, MessageType::kBulkOffer);
  EXPECT_EQ(FindTopicRule(kEventTopic)->topic_class, TopicClass::kEvent);
  EXPECT_EQ(FindTopicRule(kParameterTopic)->topic_class, TopicClass::kService);
  EXPECT_EQ(FindTopicRule("no/such/topic"), nullptr);
}

// A matcher that backtracks over all stars would take exponential time.
TEST(Topics, MatchingAPatternOfManyStarsIsFast) {
  std::string pattern;
  for (int i = 0; i < 40; ++i) pattern += "*a";
  EXPECT_FALSE(MatchesPattern(pattern + "b", std::string(4000, 'a')));
  EXPECT_TRUE(MatchesPattern(pattern, std::string(4000, 'a')));
}

TEST(Schema, EveryMessageHasItsOwnDigest) {
  std::set<std::uint32_t> digests;
  for (int i = 1; i <= static_cast<int>(kLastMessageType); ++i) {
    const PayloadSchema& schema = SchemaOf(static_cast<MessageType>(i));
    EXPECT_FALSE(schema.canonical.empty());
    digests.insert(schema.digest);
  }
  EXPECT_EQ(digests.size(), static_cast<std::size_t>(kLastMessageType));
}

// Readers of recordings do not have proto/options.proto, and do not need it.
TEST(Schema, RecordingsCarryNoOptionsForCpp) {
  for (int i = 1; i <= static_cast<int>(kLastMessageType); ++i) {
    google::protobuf::FileDescriptorSet set;
    ASSERT_TRUE(set.ParseFromString(DescriptorSetOf(static_cast<MessageType>(i))));
    for (const auto& file : set.file()) {
      EXPECT_EQ(file.dependency_size(), 0) << file.name();
      EXPECT_EQ(file.DebugString().find("options"), std::string::npos) << file.DebugString();
    }
  }
}

TEST(Schema, AddedFieldsAreCompatibleAndChangedTypesAreNot) {
  std::string why;
  EXPECT_TRUE(AreCompatible("1:double 2:uint32", "1:double 2:uint32 3:bool", &why));
  EXPECT_TRUE(AreCompatible("1:repeated_{1:float}", "1:repeated_{1:float 2:float}", &why));
  EXPECT_FALSE(AreCompatible("1:double 2:uint32", "1:double 2:sint32", &why));
  EXPECT_EQ(why, "field 2 is uint32 in one and sint32 in the other");
  EXPECT_FALSE(AreCompatible("1:repeated_{1:float}", "1:repeated_{1:double}", &why));
  EXPECT_FALSE(AreCompatible("1:double", "1:repeated_double", &why));
}

// A hostile peer may send any nesting; unlimited recursion would overflow the stack.
TEST(Schema, EndlessNestingIsRefused) {
  std::string open, close;
  for (int i = 0; i < 2000; ++i) {
    open += "1:{";
    close += "}";
  }
  std::string why;
  EXPECT_FALSE(AreCompatible(open + "1:float" + close, open + "1:double" + close, &why));
  EXPECT_FALSE(why.empty());
  EXPECT_FALSE(AreCompatible(open + "1:float" + close, open + "1:float 2:bool" + close, &why));
}

}  // namespace
}  // namespace bus

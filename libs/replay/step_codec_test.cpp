#include "replay/step_codec.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "replay/difference.hpp"
#include "replay/field_list.hpp"
#include "replay/fields.hpp"

namespace replay {
namespace {

// A step as nodes have them, with lists that grow and shrink.
struct Step {
  core::PhysicsState state;
  std::vector<core::Event> events;
};

template <class V>
void VisitInputs(V& v, Step& step) {
  Items(v, "events", step.events);
}
template <class V>
void VisitOutputs(V& v, Step& step) {
  Field(v, "state", step.state);
}

Step MakeStep(std::uint64_t tick) {
  Step step;
  step.state.tick = tick;
  step.state.header.sequence = tick;
  const std::size_t num_bodies = tick % 4;
  for (std::size_t i = 0; i < num_bodies; ++i) {
    core::BodyState body;
    body.object = static_cast<std::uint16_t>(i);
    body.X_WO.translation = {std::sin(0.01 * static_cast<double>(tick)), -1.0 / static_cast<double>(tick + i), 0.0};
    step.state.bodies.push_back(body);
  }
  if (tick % 7 == 3) step.events.push_back({static_cast<std::int64_t>(tick), "physics_node", "grasp", "right module"});
  if (tick == 5) step.state.bodies[0].V_WO.linear_m_per_s.x = std::numeric_limits<double>::quiet_NaN();
  if (tick == 6) step.state.bodies[0].V_WO.linear_m_per_s.x = -0.0;
  return step;
}

std::vector<std::uint8_t> Encode(StepEncoder* encoder, std::uint64_t tick, Step step) {
  encoder->Begin(tick);
  VisitInputs(*encoder, step);
  VisitOutputs(*encoder, step);
  const auto bytes = encoder->Finish(17 + tick);
  return {bytes.begin(), bytes.end()};
}

bool Decode(StepDecoder* decoder, const std::vector<std::uint8_t>& bytes, Step* step) {
  if (!decoder->Begin(bytes)) return false;
  VisitInputs(*decoder, *step);
  VisitOutputs(*decoder, *step);
  return decoder->Finish();
}

std::uint64_t DigestOf(Step step) {
  Digest digest;
  VisitInputs(digest, step);
  VisitOutputs(digest, step);
  return digest.value();
}

TEST(StepCodec, TwoKindsOfStepInOneOrderAreReadApart) {
  StepEncoder usual(4096), other(4096, 1);
  StepDecoder decoders[2];
  for (std::uint64_t tick = 1; tick <= 40; ++tick) {
    for (StepEncoder* encoder : {&usual, &other}) {
      const std::uint64_t its = encoder == &usual ? tick : 1000 + tick;
      const auto bytes = Encode(encoder, its, MakeStep(its));
      ASSERT_EQ(StepKind(bytes), encoder == &usual ? kUsualStep : 1);
      Step step;
      ASSERT_TRUE(Decode(&decoders[StepKind(bytes)], bytes, &step)) << its;
      EXPECT_EQ(step.state.tick, its);
      EXPECT_EQ(step.state.bodies.size(), MakeStep(its).state.bodies.size());
    }
  }
}

TEST(StepCodec, RoundTripsEveryBitAsListsGrowAndShrink) {
  StepEncoder encoder(1000);
  StepDecoder decoder;
  std::size_t num_bytes = 0;
  for (std::uint64_t tick = 1; tick <= 1200; ++tick) {
    const std::vector<std::uint8_t> bytes = Encode(&encoder, tick, MakeStep(tick));
    num_bytes += bytes.size();
    Step got;
    ASSERT_TRUE(Decode(&decoder, bytes, &got)) << tick;
    EXPECT_EQ(decoder.tick(), tick);
    EXPECT_EQ(decoder.digest(), 17 + tick);
    ASSERT_EQ(DigestOf(got), DigestOf(MakeStep(tick))) << tick;
  }
  EXPECT_LT(num_bytes, 1200U * 200U);
}

TEST(StepCodec, AnUnchangedStepTakesItsHeadAndOneBitPerField) {
  StepEncoder encoder(1000);
  const std::size_t whole = Encode(&encoder, 3, MakeStep(3)).size();
  const std::size_t same = Encode(&encoder, 3, MakeStep(3)).size();
  EXPECT_GT(whole, 150U);
  EXPECT_LT(same, kStepHeadBytes + 12);
}

TEST(StepCodec, AfterALossTheNextStepIsCompleteInItself) {
  StepEncoder encoder(1000);
  (void)Encode(&encoder, 1, MakeStep(1));
  encoder.Forget();
  StepDecoder decoder;
  Step got;
  ASSERT_TRUE(Decode(&decoder, Encode(&encoder, 2, MakeStep(2)), &got));
  EXPECT_EQ(DigestOf(got), DigestOf(MakeStep(2)));
  StepDecoder other;
  EXPECT_FALSE(Decode(&other, Encode(&encoder, 3, MakeStep(3)), &got)) << "what precedes it is not known";
}

TEST(StepCodec, AStepWithTooManyFieldsIsRefusedAndTheNextIsComplete) {
  StepEncoder encoder(40);
  (void)Encode(&encoder, 4, MakeStep(4));
  EXPECT_TRUE(Encode(&encoder, 7, MakeStep(7)).empty());
  StepDecoder decoder;
  Step got;
  ASSERT_TRUE(Decode(&decoder, Encode(&encoder, 8, MakeStep(8)), &got));
  EXPECT_EQ(DigestOf(got), DigestOf(MakeStep(8)));
}

TEST(StepCodec, DamagedStepsAreRefused) {
  StepEncoder encoder(1000);
  const std::vector<std::uint8_t> bytes = Encode(&encoder, 3, MakeStep(3));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    StepDecoder decoder;
    Step got;
    EXPECT_FALSE(Decode(&decoder, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}, &got)) << size;
  }
  // With any bit flipped: refused, or decoded to other values, but never out of bounds (checked by sanitizers).
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::vector<std::uint8_t> flipped = bytes;
    flipped[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    StepDecoder decoder;
    Step got;
    (void)Decode(&decoder, flipped, &got);
  }
}

TEST(FieldList, NamesEveryFieldWithItsType) {
  const std::string fields = DescribeFields<Step>();
  EXPECT_NE(fields.find("events[].detail s8\n"), std::string::npos) << fields;
  EXPECT_NE(fields.find("state.bodies[].X_WO.translation.z f64\n"), std::string::npos) << fields;
  // Of outputs, what transport adds is left out.
  EXPECT_EQ(fields.find("state.header.sequence"), std::string::npos) << fields;
}

}  // namespace
}  // namespace replay

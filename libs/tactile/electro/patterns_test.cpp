#include "tactile/electro/patterns.hpp"

#include <gtest/gtest.h>

#include "core/clock.hpp"

namespace tactile {
namespace {

ElectrodePlaces Grid() {
  ElectrodePlaces places;
  for (std::size_t i = 0; i < kNumElectrodes; ++i) {
    places[i] = {i % 2 == 0 ? -0.0015 : 0.0015, -0.0045 + 0.003 * static_cast<double>(i / 2)};
  }
  return places;
}

FingerContact Pressing() {
  FingerContact contact;
  contact.depth_m = 0.001;
  contact.force_N = 2.0;
  return contact;
}

ContactKind After(double ms, const FingerContact& contact) {
  ContactClassifier classifier;
  ContactKind kind = ContactKind::kNone;
  for (std::int64_t t_ns = 1000 * core::kMillisecond_ns;
       t_ns <= (1000 + static_cast<std::int64_t>(ms)) * core::kMillisecond_ns; t_ns += core::kMillisecond_ns) {
    kind = classifier.Step(t_ns, contact);
  }
  return kind;
}

TEST(ContactClassifier, TellsTouchPressureSlipAndMovementApart) {
  FingerContact slips = Pressing(), rolls = Pressing();
  slips.slip_m_per_s = {0.0, 0.03};
  rolls.travel_m_per_s = {0.02, 0.0};
  EXPECT_EQ(After(50, {}), ContactKind::kNone);
  EXPECT_EQ(After(50, Pressing()), ContactKind::kTouch);
  EXPECT_EQ(After(50, slips), ContactKind::kTouch) << "how it begins";
  EXPECT_EQ(After(200, Pressing()), ContactKind::kPressure);
  EXPECT_EQ(After(200, slips), ContactKind::kSlip);
  EXPECT_EQ(After(200, rolls), ContactKind::kMovement);
}

TEST(ContactClassifier, AContactPointThatJumpsOnceIsNoMovement) {
  ContactClassifier classifier;
  for (int i = 0; i < 200; ++i) classifier.Step((1000 + i) * core::kMillisecond_ns, Pressing());
  FingerContact jump = Pressing();
  jump.travel_m_per_s = {0.08, 0.0};  // 0.08 mm within a millisecond, as from one point of a shell to the next
  EXPECT_EQ(classifier.Step(1200 * core::kMillisecond_ns, jump), ContactKind::kPressure);
}

TEST(Pattern, IsStrongestWhereTheFingerIsTouched) {
  const ElectrodePlaces places = Grid();
  for (std::size_t touched = 0; touched < kNumElectrodes; ++touched) {
    FingerContact contact = Pressing();
    contact.place_m = places[touched];
    const Pattern pattern = PatternOf(ContactKind::kPressure, contact, 0.8, 0.0, places);
    EXPECT_NEAR(pattern[touched].level, 0.8, 1e-9);
    for (std::size_t i = 0; i < kNumElectrodes; ++i) {
      if (i == touched) continue;
      EXPECT_LT(pattern[i].level, pattern[touched].level);
    }
  }
}

TEST(Pattern, EachKindHasARateOfItsOwn) {
  std::set<double> rates;
  for (const ContactKind kind :
       {ContactKind::kTouch, ContactKind::kPressure, ContactKind::kSlip, ContactKind::kMovement}) {
    rates.insert(PatternOf(kind, Pressing(), 1.0, 0.0, Grid())[0].rate_Hz);
  }
  EXPECT_EQ(rates.size(), 4u);
  for (const Tingle& tingle : PatternOf(ContactKind::kNone, Pressing(), 1.0, 0.0, Grid())) EXPECT_EQ(tingle.level, 0.0);
}

TEST(Pattern, TheWaveOfASlipGoesWithWhatSlips) {
  const ElectrodePlaces places = Grid();
  for (const double way : {1.0, -1.0}) {
    FingerContact contact = Pressing();
    contact.slip_m_per_s = {0.0, 0.05 * way};
    const auto middle_mm = [&](double time_s) {
      double sum = 0.0, weight = 0.0;
      const Pattern pattern = PatternOf(ContactKind::kSlip, contact, 1.0, time_s, places);
      for (std::size_t i = 0; i < kNumElectrodes; ++i) {
        sum += pattern[i].level * places[i].y * 1e3;
        weight += pattern[i].level;
      }
      return weight > 0.0 ? sum / weight : 0.0;
    };
    int forward = 0, back = 0;
    double before_mm = middle_mm(0.0);
    for (int i = 1; i < 240; ++i) {
      const double now_mm = middle_mm(1e-3 * i);
      forward += (now_mm - before_mm) * way > 0.1 ? 1 : 0;
      back += (now_mm - before_mm) * way < -0.1 ? 1 : 0;
      before_mm = now_mm;
    }
    EXPECT_GT(forward, 2 * back) << "it jumps back once a wave";
  }
}

// A plate moves under a finger at rest; a finger rolls on a plate at rest.
TEST(FingerSense, TellsSlipFromTravel) {
  core::ContactSet set;
  core::ContactPlane plane;
  plane.n_G = {-1.0f, 0.0f, 0.0f};  // the plate is at the pad's side x
  plane.p_S = {0.001f, 0.0f, 0.0f};
  plane.stiffness_N_per_m = 1000.0f;
  set.planes.push_back(plane);
  FingerSense slipping(1), rolling(1);
  FingerContact slip, roll;
  for (int i = 0; i < 3; ++i) {
    core::Pose X_WG;
    X_WG.translation = {0.0, 0.0, 0.0004 * i};  // 0.1 m/s
    slipping.Begin((1000 + 4 * i) * core::kMillisecond_ns, {});
    slipping.Add(0, set, {}, X_WG, true);
    slip = slipping.End();
    set.planes[0].p_S.y = 0.0002f * static_cast<float>(i);
    rolling.Begin((1000 + 4 * i) * core::kMillisecond_ns, {});
    rolling.Add(0, set, {}, {}, true);
    roll = rolling.End();
    set.planes[0].p_S.y = 0.0f;
  }
  EXPECT_NEAR(slip.force_N, 1.0, 1e-6);
  EXPECT_NEAR(glm::distance(slip.slip_m_per_s, {0.0, 0.1}), 0.0, 1e-9);
  EXPECT_NEAR(glm::length(slip.travel_m_per_s), 0.0, 1e-9);
  EXPECT_NEAR(glm::length(roll.slip_m_per_s), 0.0, 1e-9);
  EXPECT_NEAR(glm::distance(roll.travel_m_per_s, {0.05, 0.0}), 0.0, 1e-6);
}

}  // namespace
}  // namespace tactile

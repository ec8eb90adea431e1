#include "tactile/electro/stimulator.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "core/clock.hpp"

namespace tactile {
namespace {

class StimulatorTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto table = ReadStimulatorTable(VR_OOS_SOURCE_DIR "/scenarios/touch/fingertip.xml");
    ASSERT_TRUE(table);
    table_ = *table;
    stimulator_.emplace(table_, &skin_, *Limiter::Create({}));
    input_.is_engaged = true;
  }
  void Press(std::size_t electrode, double strength) {
    input_.contact.depth_m = 0.001;
    input_.contact.force_N = 2.0;
    input_.contact.place_m = table_.places[electrode];
    input_.strength = strength;
  }
  void Run(int ms) {
    for (int i = 0; i < ms; ++i) {
      now_ns_ += core::kMillisecond_ns;
      if (is_fed_) input_.made_ns = now_ns_;
      stimulator_->Take(input_);
      stimulator_->Turn(now_ns_);
    }
  }
  const Stimulator::State& state() const { return stimulator_->state(); }

  StimulatorTable table_;
  SimulatedSkin skin_;
  std::optional<Stimulator> stimulator_;
  Stimulator::Input input_;
  bool is_fed_ = true;
  std::int64_t now_ns_ = 1'000'000'000;
};

TEST_F(StimulatorTest, AContactIsFeltWithin20msAndNothingWithoutOne) {
  Run(500);
  EXPECT_EQ(skin_.num_pulses(), 0u);
  Press(3, 1.0);
  Run(20);
  EXPECT_GT(skin_.num_pulses(), 0u);
  EXPECT_EQ(state().kind, ContactKind::kTouch);
}

TEST_F(StimulatorTest, PressureIsBetweenThresholdAndComfortOfThatElectrode) {
  Run(300);
  for (const double strength : {0.01, 0.5, 1.0}) {
    Press(3, strength);
    Run(1500);
    ASSERT_EQ(state().kind, ContactKind::kPressure);
    while (skin_.last().electrode != 3) Run(1);
    const SkinCalibration& c = table_.calibrations[3];
    EXPECT_NEAR(skin_.last().pulse.current_A, c.threshold_A + strength * (c.comfort_A - c.threshold_A), 1e-7);
    EXPECT_LT(skin_.last().pulse.width_s, 100e-6);
  }
}

TEST_F(StimulatorTest, AnElectrodeThatComesOffStopsAllWithinOnePulseUntilTheDeadManIsReleased) {
  Press(3, 1.0);
  Run(500);
  const std::uint64_t before = skin_.num_pulses();
  skin_.SetImpedance(3, 1e6);
  Run(500);
  // Pulses of other electrodes may come before that one's, which sees it: it is the last.
  EXPECT_EQ(skin_.last().electrode, 3u);
  EXPECT_LE(skin_.num_pulses(), before + kNumElectrodes);
  EXPECT_EQ(state().stopped_by, StopCause::kOpenElectrode);
  const std::uint64_t stopped = skin_.num_pulses();
  skin_.SetImpedance(3, 10e3);
  is_fed_ = false;
  Run(100);
  is_fed_ = true;
  Run(500);
  EXPECT_EQ(skin_.num_pulses(), stopped) << "silence forgets nothing";
  input_.is_engaged = false;
  Run(10);
  input_.is_engaged = true;
  Run(500);
  EXPECT_GT(skin_.num_pulses(), stopped);
  EXPECT_EQ(state().stopped_by, StopCause::kNothing);
}

TEST_F(StimulatorTest, SilenceAndAReleasedDeadManTakeTheCurrentAway) {
  Press(3, 1.0);
  Run(500);
  is_fed_ = false;
  Run(41);
  const std::uint64_t silent = skin_.num_pulses();
  Run(500);
  EXPECT_EQ(skin_.num_pulses(), silent);
  EXPECT_EQ(state().stopped_by, StopCause::kSilence);
  is_fed_ = true;
  Run(500);
  const std::uint64_t back = skin_.num_pulses();
  EXPECT_GT(back, silent);
  input_.is_engaged = false;
  Run(500);
  EXPECT_EQ(skin_.num_pulses(), back);
}

TEST(StimulatorTable, APersonWithoutAUsableCalibrationIsRefused) {
  const auto file = std::filesystem::path(testing::TempDir()) / "stimulator.xml";
  std::ifstream good(VR_OOS_SOURCE_DIR "/scenarios/touch/fingertip.xml");
  std::string text((std::istreambuf_iterator<char>(good)), {});
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    const auto at = changed.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    std::ofstream(file) << changed.replace(at, from.size(), to);
    return ReadStimulatorTable(file).has_value();
  };
  EXPECT_TRUE(with("fingertip", "finger"));
  EXPECT_FALSE(with("pain_mA=\"1.2\"", "pain_mA=\"0.7\""));
  EXPECT_FALSE(with("threshold_mA=\"0.3\"", "threshold_mA=\"0.9\""));
  EXPECT_FALSE(with("width_us=\"80\"", "width_us=\"100\""));
  EXPECT_FALSE(
      with("<electrode across_mm=\"-1.5\" along_mm=\"-4.5\" threshold_mA=\"0.3\" comfort_mA=\"0.7\" "
           "pain_mA=\"1.2\"/>",
           ""));
}

}  // namespace
}  // namespace tactile

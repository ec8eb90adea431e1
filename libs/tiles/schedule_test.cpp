#include "tiles/schedule.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tiles/testing/emulation.hpp"

namespace tiles {
namespace {

constexpr double kMessage_s = 0.5e-3, kPerTile_s = 30e-6;

// --- Cuts

TEST(CutIntoTiles, CoversEachPixelOnce) {
  CostMap costs;
  costs.Take({64, 64, 64, 32}, 640, 360, 0.02);
  std::vector<int> covered(640 * 360);
  for (const Tile& tile : CutIntoTiles(costs, 640, 360, 1e-3)) {
    EXPECT_LE(tile.num_pixels(), kMostPixels);
    for (int y = tile.y; y < tile.y + tile.height; ++y) {
      for (int x = tile.x; x < tile.x + tile.width; ++x) ++covered[static_cast<std::size_t>(640 * y + x)];
    }
  }
  EXPECT_EQ(std::count(covered.begin(), covered.end(), 1), 640 * 360);
}

TEST(CutIntoTiles, CutsDearPlacesSmallerAndListsThemFirst) {
  CostMap costs;
  costs.Take({256, 128, 64, 64}, 640, 384, 0.05);
  const std::vector<Tile> tiles = CutIntoTiles(costs, 640, 384, 2e-3);
  EXPECT_LT(tiles.front().num_pixels(), 1024) << "where it was dear";
  EXPECT_TRUE(std::any_of(tiles.begin(), tiles.end(), [](const Tile& tile) { return tile.num_pixels() > 4096; }))
      << "elsewhere";
  for (std::size_t i = 1; i < tiles.size(); ++i) {
    EXPECT_GE(costs.Of(tiles[i - 1], 640, 384), costs.Of(tiles[i], 640, 384));
  }
}

TEST(CostMap, KnowsTheSamePlaceOfAPictureOfAnotherSize) {
  CostMap costs;
  costs.Take({0, 0, 640, 384}, 640, 384, 0.1);
  EXPECT_NEAR(costs.Of({0, 0, 320, 192}, 320, 192), 0.025, 1e-9);
  EXPECT_NEAR(costs.Of({0, 0, 320, 384}, 640, 384), 0.05, 1e-9);
}

// --- The state machine

class ScheduleTest : public testing::Test {
 protected:
  Job FirstJob(std::size_t seat) { return schedule_.jobs(seat).at(0); }
  // Every seat answers all that it has, each tile after 1 ms, until no frame is left. The numbers of complete frames.
  std::vector<std::uint64_t> AnswerAll(const std::vector<std::size_t>& seats) {
    std::vector<std::uint64_t> done;
    for (int i = 0; i < 10'000 && schedule_.num_in_flight() > 0; ++i) {
      now_s_ += 1e-3;
      schedule_.Update(now_s_);
      for (const std::size_t seat : seats) {
        if (!schedule_.jobs(seat).empty()) schedule_.Take(seat, FirstJob(seat).id, 1e-3, now_s_);
      }
      while (const auto frame = schedule_.TakeDone()) done.push_back(*frame);
    }
    return done;
  }

  Schedule schedule_{3};
  double now_s_ = 10.0;
};

TEST_F(ScheduleTest, WantsNoFrameWithoutWorkers) {
  EXPECT_FALSE(schedule_.WantsFrame());
  schedule_.Join(1, now_s_);
  EXPECT_TRUE(schedule_.WantsFrame());
}

TEST_F(ScheduleTest, GivesEachTileOnceWhileNobodyIsLate) {
  schedule_.Join(0, now_s_);
  schedule_.Join(1, now_s_);
  schedule_.BeginFrame(7, 640, 360, now_s_);
  EXPECT_EQ(AnswerAll({0, 1}), (std::vector<std::uint64_t>{7}));
  EXPECT_EQ(schedule_.num_reissued(), 0u);
  EXPECT_EQ(schedule_.num_unused(), 0u);
}

TEST_F(ScheduleTest, HasTwoFramesInFlightAndDeliversThemInOrder) {
  schedule_.Join(0, now_s_);
  schedule_.BeginFrame(1, 64, 64, now_s_);
  ASSERT_TRUE(schedule_.WantsFrame()) << "the first is given out";
  schedule_.BeginFrame(2, 64, 64, now_s_);
  EXPECT_FALSE(schedule_.WantsFrame());
  const std::vector<Job> jobs = schedule_.jobs(0);
  for (auto job = jobs.rbegin(); job != jobs.rend(); ++job) schedule_.Take(0, job->id, 1e-3, now_s_ += 1e-3);
  EXPECT_EQ(schedule_.TakeDone(), 1u);
  EXPECT_EQ(schedule_.TakeDone(), 2u);
  EXPECT_EQ(schedule_.TakeDone(), std::nullopt);
}

TEST_F(ScheduleTest, ALateTileGoesToAnotherAndTheFirstAnswerCounts) {
  schedule_.Join(0, now_s_);
  schedule_.BeginFrame(1, 64, 64, now_s_);
  const Job late = FirstJob(0);
  schedule_.Join(1, now_s_);
  schedule_.Update(now_s_ += 1.0);
  ASSERT_EQ(schedule_.jobs(1).size(), 1u);
  EXPECT_EQ(FirstJob(1).tile, late.tile);
  EXPECT_NE(FirstJob(1).id, late.id);
  const auto answer = schedule_.Take(0, late.id, 1e-3, now_s_);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->tile, late.tile);
  EXPECT_TRUE(schedule_.jobs(1).empty()) << "nobody needs to draw it any more";
  EXPECT_EQ(schedule_.TakeDone(), 1u);
}

TEST_F(ScheduleTest, WhoeverIsLateGetsNoMoreUntilItAnswers) {
  schedule_.Join(0, now_s_);
  schedule_.BeginFrame(1, 64, 64, now_s_);
  schedule_.Update(now_s_ += 1.0);
  EXPECT_FALSE(schedule_.WantsFrame());
  schedule_.Take(0, FirstJob(0).id, 1e-3, now_s_);
  schedule_.Update(now_s_);
  EXPECT_TRUE(schedule_.WantsFrame());
}

TEST_F(ScheduleTest, WhoeverIsLateWithNothingLeftToAnswerIsAskedForACopyUntilItIsBack) {
  schedule_.Join(0, now_s_);
  schedule_.BeginFrame(1, 64, 64, now_s_);
  schedule_.Join(1, now_s_);
  schedule_.Update(now_s_ += 1.0);
  schedule_.Take(1, FirstJob(1).id, 1e-3, now_s_);
  ASSERT_EQ(schedule_.TakeDone(), 1u);
  ASSERT_TRUE(schedule_.jobs(0).empty());
  schedule_.BeginFrame(2, 640, 360, now_s_);
  ASSERT_EQ(schedule_.jobs(0).size(), 1u);
  const std::vector<Job>& others = schedule_.jobs(1);
  EXPECT_TRUE(std::any_of(others.begin(), others.end(), [&](const Job& job) { return job.tile == FirstJob(0).tile; }));
  EXPECT_TRUE(schedule_.Take(0, FirstJob(0).id, 1e-3, now_s_));
  schedule_.Update(now_s_);
  EXPECT_GT(schedule_.jobs(0).size(), 1u) << "it takes part again";
  EXPECT_EQ(AnswerAll({1, 0}), (std::vector<std::uint64_t>{2}));
}

TEST_F(ScheduleTest, WhatADeadWorkerHadGoesToTheOthersAtOnce) {
  schedule_.Join(0, now_s_);
  schedule_.BeginFrame(1, 640, 360, now_s_);
  schedule_.Join(2, now_s_);
  schedule_.Leave(0);
  schedule_.Update(now_s_);
  EXPECT_TRUE(schedule_.jobs(0).empty());
  EXPECT_EQ(AnswerAll({2}), (std::vector<std::uint64_t>{1}));
}

TEST_F(ScheduleTest, AnAnswerThatNobodyAskedForChangesNothing) {
  schedule_.Join(0, now_s_);
  schedule_.BeginFrame(1, 64, 64, now_s_);
  EXPECT_FALSE(schedule_.Take(0, 12345, 1e-3, now_s_));
  EXPECT_EQ(schedule_.jobs(0).size(), 1u);
  EXPECT_EQ(schedule_.num_unused(), 1u);
}

TEST_F(ScheduleTest, AFrameWithoutAnyWorkerWaitsForOne) {
  schedule_.Join(0, now_s_);
  schedule_.BeginFrame(1, 640, 360, now_s_);
  schedule_.Leave(0);
  schedule_.Update(now_s_ += 5.0);
  schedule_.Join(1, now_s_);
  EXPECT_EQ(AnswerAll({1}), (std::vector<std::uint64_t>{1}));
}

// --- Workers with the costs of a real run: module_replacement at 1280x720, recorded with one worker.

class TwelveWorkers : public testing::Test {
 protected:
  void SetUp() override {
    costs_ = RecordedCosts::Read(std::filesystem::path(VR_OOS_SOURCE_DIR) / "libs/tiles/testing/recorded_costs.txt");
    ASSERT_GE(costs_.frames.size(), 16u);
  }
  // Frames a second once the costs are known.
  static double SteadyRate(Emulation* emulation) {
    emulation->RunFrames(20);
    const double begin_s = emulation->now_s();
    emulation->RunFrames(60);
    return 60.0 / (emulation->now_s() - begin_s);
  }

  RecordedCosts costs_;
};

TEST_F(TwelveWorkers, AreBusyNearlyAllTheTime) {
  Emulation emulation(&costs_, 12, kMessage_s, kPerTile_s);
  emulation.RunFrames(20);
  const double begin_s = emulation.now_s(), begin_work_s = emulation.work_s();
  emulation.RunFrames(100);
  // Ideal: the work of the pixels alone, spread over all without a gap.
  double pixels_s = 0.0;
  for (std::size_t frame = 21; frame <= 120; ++frame) pixels_s += costs_.Of(frame, {0, 0, costs_.width, costs_.height});
  const double took_s = emulation.now_s() - begin_s;
  const double efficiency = pixels_s / 12.0 / took_s;
  RecordProperty("efficiency", std::to_string(efficiency));
  RecordProperty("frames_per_s", std::to_string(100.0 / took_s));
  RecordProperty("busy", std::to_string((emulation.work_s() - begin_work_s) / 12.0 / took_s));
  EXPECT_GE(efficiency, 0.92);
}

TEST_F(TwelveWorkers, OneKilledInMidFrameCostsItsShareOnly) {
  Emulation emulation(&costs_, 12, kMessage_s, kPerTile_s);
  const double rate = SteadyRate(&emulation), kill_s = emulation.now_s() + 1e-3;
  emulation.RunUntil(kill_s);
  emulation.Kill(5);
  emulation.RunUntil(kill_s + 0.4);  // until the bus says so
  emulation.schedule().Leave(5);
  emulation.RunUntil(kill_s + 3.0);
  EXPECT_GE(emulation.Rate(kill_s, kill_s + 1.0), 0.85 * rate) << "11 of 12, from the beginning on";
  EXPECT_GE(emulation.Rate(kill_s + 1.0, kill_s + 3.0), 0.88 * rate);
}

TEST_F(TwelveWorkers, OneStoppedAndContinuedIsBackWithinASecond) {
  Emulation emulation(&costs_, 12, kMessage_s, kPerTile_s);
  const double rate = SteadyRate(&emulation), stop_s = emulation.now_s();
  emulation.Stop(3);
  emulation.RunUntil(stop_s + 2.0);
  EXPECT_GE(emulation.Rate(stop_s, stop_s + 2.0), 0.85 * rate);
  emulation.Continue(3);
  emulation.RunUntil(stop_s + 5.0);
  EXPECT_GE(emulation.Rate(stop_s + 3.0, stop_s + 5.0), 0.97 * rate);
}

TEST_F(TwelveWorkers, OneThatIsFiveTimesSlowerHoldsUpNobody) {
  Emulation emulation(&costs_, 12, kMessage_s, kPerTile_s);
  const double rate = SteadyRate(&emulation), slow_s = emulation.now_s();
  emulation.Slow(7, 5.0);
  emulation.RunUntil(slow_s + 3.0);
  EXPECT_GE(emulation.Rate(slow_s, slow_s + 1.0), 0.85 * rate);
  EXPECT_GE(emulation.Rate(slow_s + 1.0, slow_s + 3.0), 0.88 * rate) << "11.2 of 12";
}

TEST_F(TwelveWorkers, OneThatJoinsInMidFrameHelpsAtOnce) {
  Emulation emulation(&costs_, 12, kMessage_s, kPerTile_s);
  emulation.schedule().Leave(2);
  const double rate = SteadyRate(&emulation), join_s = emulation.now_s() + 1e-3;
  emulation.RunUntil(join_s);
  emulation.Join(2);
  emulation.RunUntil(join_s + 3.0);
  EXPECT_GE(emulation.Rate(join_s + 1.0, join_s + 3.0), 1.06 * rate) << "12 instead of 11";
}

TEST_F(TwelveWorkers, TwoAreNearlyTwiceAsFastAsOne) {
  Emulation one(&costs_, 1, kMessage_s, kPerTile_s), two(&costs_, 2, kMessage_s, kPerTile_s);
  EXPECT_GE(SteadyRate(&two), 1.95 * SteadyRate(&one));
}

}  // namespace
}  // namespace tiles

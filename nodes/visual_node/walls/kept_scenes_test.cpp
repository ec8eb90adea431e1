#include "nodes/visual_node/walls/kept_scenes.hpp"

#include <gtest/gtest.h>

namespace visual_node {
namespace {

// States of one millisecond each, as they arrive. The tick is the clock.
class Stream {
 public:
  explicit Stream(KeptScenes* kept) : kept_(kept) {}
  void RunTo(std::uint64_t tick) {
    for (; tick_ < tick; ++tick_) {
      scene_.time_ns = static_cast<std::int64_t>(tick_ + 1) * 1'000'000;
      kept_->Keep(tick_ + 1, scene_);
    }
  }

 private:
  KeptScenes* kept_;
  view::Scene scene_;
  std::uint64_t tick_ = 0;
};

TEST(KeptScenes, AWallDrawsTheNamedStateHoweverLateItIs) {
  KeptScenes kept;
  Stream stream(&kept);
  view::Scene drawn;
  for (const std::uint64_t late_ms : {1, 255, 257, 1000, 1100, 60'000}) {
    const std::uint64_t begin = kept.newest_tick();
    stream.RunTo(begin + 400);
    const std::uint64_t named = begin + 396;
    kept.Pin(named);
    stream.RunTo(begin + 400 + late_ms);
    EXPECT_EQ(kept.Take(named, &drawn), named) << late_ms << " ms late";
    EXPECT_EQ(drawn.time_ns, static_cast<std::int64_t>(named) * 1'000'000);
  }
}

TEST(KeptScenes, TheNamedStateStaysThoughItIsNamedBeforeItArrives) {
  KeptScenes kept;
  Stream stream(&kept);
  stream.RunTo(100);
  kept.Pin(120);
  stream.RunTo(2000);
  view::Scene drawn;
  EXPECT_EQ(kept.Take(120, &drawn), 120u);
}

TEST(KeptScenes, HasAllOthersOfTheLastQuarterOfASecondBesideTheNamedOne) {
  KeptScenes kept;
  Stream stream(&kept);
  stream.RunTo(100);
  kept.Pin(40);
  stream.RunTo(1000);
  for (std::uint64_t tick = 748; tick <= 1000; tick += 4) EXPECT_TRUE(kept.ticks().Has(tick)) << tick;
  EXPECT_FALSE(kept.ticks().Has(40)) << "it is not one that the next frame could be of";
  view::Scene late;
  EXPECT_EQ(kept.Take(100, &late), 100u) << "it was said to be kept, 0.9 s ago";
  kept.Pin(1000);
  stream.RunTo(3000);
  view::Scene drawn;
  EXPECT_NE(kept.Take(40, &drawn), 40u) << "another is named: it is forgotten";
}

TEST(KeptScenes, TakesTheNearestWhenItHasNotTheNamedOne) {
  KeptScenes kept;
  view::Scene scene, drawn;
  EXPECT_EQ(kept.Take(8, &drawn), 0u) << "nothing is there yet";
  for (const std::uint64_t tick : {8, 20, 24}) kept.Keep(tick, scene);
  EXPECT_EQ(kept.Take(12, &drawn), 8u);
  EXPECT_EQ(kept.Take(0, &drawn), 24u) << "the newest";
}

}  // namespace
}  // namespace visual_node

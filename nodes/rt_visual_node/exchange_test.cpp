// Viewer and workers on a real bus. Workers are threads of this test, each with its own end of the bus.

#include "nodes/rt_visual_node/exchange.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <list>

#include "bus/membership/registry.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/testing/own_network.hpp"
#include "core/clock.hpp"
#include "nodes/rt_worker/worker.hpp"
#include "tiles/frame.hpp"
#include "view/conformance/cast_ids.hpp"
#include "view/conformance/testing/known_scene.hpp"

namespace rt_visual_node {
namespace {

constexpr std::uint64_t kSession = 11;
constexpr int kWidth = 192, kHeight = 108;
constexpr std::int64_t kPatience_ns = 20 * core::kNanosecondsPerSecond;  // of a busy machine

class ExchangeTest : public testing::Test {
 protected:
  void SetUp() override { Open(); }
  void Open() {
    auto registry =
        bus::Registry::Create({.endpoint = "tcp://127.0.0.1:0", .session = kSession, .is_encrypted = false});
    ASSERT_TRUE(registry) << registry.error().detail;
    registry_ = std::move(*registry);
    exchange_ = std::make_unique<Exchange>(Options("visual_node"));
    const auto started = exchange_->Start();
    ASSERT_TRUE(started) << started.error().detail;
  }
  bus::NodeOptions Options(const std::string& name) {
    bus::NodeOptions options;
    options.name = name;
    options.registry = registry_->endpoint();
    options.session = kSession;
    options.is_encrypted = false;
    options.sends_goodbye = false;  // a worker that ends here is as good as killed
    return options;
  }

  struct RunningWorker {
    std::unique_ptr<rt_worker::Drawer> drawer;
    std::unique_ptr<bus::Node> node;
    std::unique_ptr<rt_worker::Worker> worker;
    std::atomic<bool> stop{false};
    std::thread thread;
    ~RunningWorker() { Stop(); }
    void Stop() {
      stop.store(true);
      if (thread.joinable()) thread.join();
    }
    void Run() {
      stop.store(false);
      thread = std::thread([this] { worker->Run(stop); });
    }
  };
  RunningWorker& StartWorker(std::size_t seat) {
    RunningWorker& worker = workers_.emplace_back();
    auto drawer = rt_worker::Drawer::Create(scene_, view::MeshOfBody);
    EXPECT_TRUE(drawer);
    worker.drawer = std::make_unique<rt_worker::Drawer>(std::move(*drawer));
    worker.node = *bus::Node::Create(Options(tiles::WorkerName("visual_node", seat)));
    worker.worker = std::make_unique<rt_worker::Worker>("visual_node", seat, worker.drawer.get(), worker.node.get());
    EXPECT_TRUE(worker.node->Start());
    worker.Run();
    return worker;
  }

  // Every body has moved since the frame before.
  Wish NextWish() {
    view::Scene moved = scene_;
    ++step_;
    for (view::Instance& instance : moved.instances) {
      instance.X_WM.translation += 0.3 * glm::dvec3(std::sin(1.3 * step_), std::cos(0.7 * step_), 0.0);
    }
    return {.frame = tiles::EncodeFrame(moved, view::LightOf(moved.space), view::KnownCamera(), kWidth, kHeight),
            .scene = moved,
            .camera = view::KnownCamera()};
  }
  // The next complete frame. Null: there was none in time.
  std::unique_ptr<Drawn> Draw() {
    exchange_->Want(NextWish());
    return exchange_->Take(core::MonotonicNow_ns() + kPatience_ns);
  }
  // How many frames are complete within a time.
  int CountFrames(double seconds) {
    int count = 0;
    const std::int64_t end_ns = core::MonotonicNow_ns() + static_cast<std::int64_t>(1e9 * seconds);
    while (core::MonotonicNow_ns() < end_ns) {
      exchange_->Want(NextWish());
      if (exchange_->Take(std::min(end_ns, core::MonotonicNow_ns() + 5'000'000)) != nullptr) ++count;
    }
    return count;
  }
  void WaitForWorkers(std::size_t count) {
    const std::int64_t end_ns = core::MonotonicNow_ns() + kPatience_ns;
    do {
      ASSERT_LT(core::MonotonicNow_ns(), end_ns);
      ASSERT_NE(Draw(), nullptr);
    } while (exchange_->figures().workers != count);
  }
  // Against a picture that is traced as a whole.
  void ExpectIsOfItsOwnScene(const Drawn& drawn) {
    if (tracer_ == nullptr) {
      auto tracer = raytrace::Tracer::Create(scene_, view::MeshOfBody);
      ASSERT_TRUE(tracer);
      tracer_ = std::move(*tracer);
    }
    const view::Scene& scene = drawn.wish.scene;
    tracer_->Update(scene, view::LightOf(scene.space));
    const raytrace::LitTile whole = tracer_->Draw(raytrace::Eye::Of(view::KnownCamera(), kWidth, kHeight),
                                                  {0, 0, kWidth, kHeight}, tiles::QualityOf(drawn.wish.frame));
    int other_depths = 0;
    for (std::size_t i = 0; i < drawn.canvas.depth.size(); ++i) {
      const int difference = drawn.canvas.depth[i] - tiles::PackDepth(whole.depth_m.values[i]);
      if (std::abs(difference) > 2) ++other_depths;
    }
    EXPECT_EQ(other_depths, 0) << "a part of the picture is of another scene";
  }

  view::Scene scene_ = view::KnownScene();
  std::unique_ptr<bus::Registry> registry_;
  std::unique_ptr<Exchange> exchange_;
  std::unique_ptr<raytrace::Tracer> tracer_;
  std::list<RunningWorker> workers_;
  int step_ = 0;
};

// Tiles lie across the border between both eyes' parts.
TEST_F(ExchangeTest, APictureOfTwoEyesIsThatOfEach) {
  view::Viewing viewing;
  viewing.stereo = view::Stereo::kSideBySide;
  const std::vector<view::Frustum> eyes = view::FrustaOf(viewing, view::KnownCamera(), 2 * kWidth, kHeight);
  const std::vector<tiles::Tile> parts = tiles::StackParts({{kWidth, kHeight}, {kWidth, kHeight}});
  const core::RayFrame frame =
      tiles::EncodeFrame(scene_, view::LightOf(scene_.space), {{eyes[0], parts[0]}, {eyes[1], parts[1]}});
  StartWorker(1);
  StartWorker(2);
  WaitForWorkers(2);
  exchange_->Want({.frame = frame, .scene = scene_, .camera = view::KnownCamera(), .parts = parts, .number = 1});
  std::unique_ptr<Drawn> drawn;
  do {
    drawn = exchange_->Take(core::MonotonicNow_ns() + kPatience_ns);
    ASSERT_NE(drawn, nullptr);
  } while (drawn->wish.number != 1);
  auto tracer = raytrace::Tracer::Create(scene_, view::MeshOfBody);
  ASSERT_TRUE(tracer);
  (*tracer)->Update(scene_, view::LightOf(scene_.space));
  int other_depths = 0, num_hits = 0;
  for (std::size_t eye = 0; eye < 2; ++eye) {
    const auto whole = (*tracer)->Draw(raytrace::Eye::Of(eyes[eye], kWidth, kHeight), {0, 0, kWidth, kHeight});
    for (std::size_t i = 0; i < whole.depth_m.values.size(); ++i) {
      const std::uint16_t seen = drawn->canvas.depth[eye * whole.depth_m.values.size() + i];
      if (seen != 0) ++num_hits;
      if (std::abs(seen - tiles::PackDepth(whole.depth_m.values[i])) > 2) ++other_depths;
    }
  }
  EXPECT_GT(num_hits, kWidth * kHeight / 10);
  EXPECT_LE(other_depths, 4) << "edges of bodies, rounded otherwise in the message";
}

TEST_F(ExchangeTest, NoPictureMixesTheScenesOfTwoFrames) {
  StartWorker(1);
  StartWorker(2);
  WaitForWorkers(2);
  // As fast as they come, so that two are in flight.
  int count = 0;
  for (int i = 0; i < 400 && count < 12; ++i) {
    exchange_->Want(NextWish());
    const auto drawn = exchange_->Take(core::MonotonicNow_ns() + 5'000'000);
    if (drawn == nullptr) continue;
    ++count;
    ExpectIsOfItsOwnScene(*drawn);
  }
  EXPECT_EQ(count, 12);
}

TEST_F(ExchangeTest, EveryFrameIsCompleteThoughAWorkerDiesInItsMiddle) {
  StartWorker(1);
  RunningWorker& second = StartWorker(2);
  WaitForWorkers(2);
  exchange_->Want(NextWish());
  second.Stop();
  second.node.reset();
  for (int i = 0; i < 5; ++i) {
    const auto drawn = Draw();
    ASSERT_NE(drawn, nullptr);
    ExpectIsOfItsOwnScene(*drawn);
  }
  WaitForWorkers(1);
}

TEST_F(ExchangeTest, AWorkerThatStandsStillIsDoneWithoutAndWelcomeAgain) {
  StartWorker(1);
  RunningWorker& second = StartWorker(2);
  WaitForWorkers(2);
  second.Stop();  // its end of the bus goes on
  EXPECT_GT(CountFrames(1.0), 0);
  EXPECT_GT(exchange_->figures().reissued, 0u);
  const std::uint64_t before = second.worker->num_tiles();
  second.Run();
  const std::int64_t end_ns = core::MonotonicNow_ns() + kPatience_ns;
  while (second.worker->num_tiles() < before + 20 && core::MonotonicNow_ns() < end_ns) ASSERT_NE(Draw(), nullptr);
  EXPECT_GE(second.worker->num_tiles(), before + 20);
}

TEST_F(ExchangeTest, AWorkerThatJoinsTakesPart) {
  StartWorker(3);
  ASSERT_NE(Draw(), nullptr);
  RunningWorker& late = StartWorker(16);
  WaitForWorkers(2);
  const std::int64_t end_ns = core::MonotonicNow_ns() + kPatience_ns;
  while (late.worker->num_tiles() == 0 && core::MonotonicNow_ns() < end_ns) ASSERT_NE(Draw(), nullptr);
  EXPECT_GT(late.worker->num_tiles(), 0u);
}

TEST_F(ExchangeTest, WithoutWorkersItSaysSoAndAFrameWaitsForTheFirst) {
  EXPECT_FALSE(exchange_->has_workers());
  exchange_->Want(NextWish());
  EXPECT_EQ(exchange_->Take(core::MonotonicNow_ns() + 50'000'000), nullptr);
  StartWorker(1);
  const auto drawn = exchange_->Take(core::MonotonicNow_ns() + kPatience_ns);
  ASSERT_NE(drawn, nullptr);
  ExpectIsOfItsOwnScene(*drawn);
}

TEST_F(ExchangeTest, APictureOfWhatStandsStillBecomesBetterAndThenRests) {
  StartWorker(1);
  const Wish wish = NextWish();
  std::uint32_t sample = 0;
  const std::int64_t end_ns = core::MonotonicNow_ns() + kPatience_ns;
  while (sample < tiles::Refinement::kMost && core::MonotonicNow_ns() < end_ns) {
    exchange_->Want(wish);
    if (const auto drawn = exchange_->Take(core::MonotonicNow_ns() + 5'000'000)) sample = drawn->wish.frame.sample;
  }
  EXPECT_EQ(sample, tiles::Refinement::kMost);
  exchange_->Want(wish);
  EXPECT_EQ(exchange_->Take(core::MonotonicNow_ns() + 50'000'000), nullptr);
}

// Everything on a network of its own that loses 1 % of all packets.
class LossyLink : public ExchangeTest {
 protected:
  void SetUp() override {}

  // The longest time between two complete frames [s].
  double LongestGap_s(double seconds) {
    double longest_s = 0.0;
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    std::int64_t last_ns = begin_ns;
    while (last_ns - begin_ns < static_cast<std::int64_t>(1e9 * seconds)) {
      if (Draw() == nullptr) return seconds;
      const std::int64_t now_ns = core::MonotonicNow_ns();
      longest_s = std::max(longest_s, 1e-9 * static_cast<double>(now_ns - last_ns));
      last_ns = now_ns;
    }
    return longest_s;
  }
  // Accounts of viewer and workers that do not close.
  std::vector<std::string> OpenAccounts() {
    bus::testing::Books books;
    const auto add = [&](const bus::Node& node) { books[node.name()] = {node.instance(), node.Accounts()}; };
    add(exchange_->node());
    for (const RunningWorker& worker : workers_) add(*worker.node);
    return bus::testing::OpenAccounts(books);
  }
};

TEST_F(LossyLink, FreezesNoPictureAndItsBooksAreExact) {
  const std::string why = bus::testing::OwnNetwork::Run([&](bus::testing::OwnNetwork& network) {
    Open();
    StartWorker(1);
    StartWorker(2);
    WaitForWorkers(2);
    ASSERT_TRUE(network.Lose(10));
    const double longest_s = LongestGap_s(4.0);
    RecordProperty("longest_gap_s", std::to_string(longest_s));
    EXPECT_LT(longest_s, 1.0);
    EXPECT_GT(exchange_->figures().frames, 20u);
    const std::int64_t end_ns = core::MonotonicNow_ns() + kPatience_ns;
    std::vector<std::string> open;
    do {
      open = OpenAccounts();
    } while (!open.empty() && core::MonotonicNow_ns() < end_ns);
    for (const std::string& account : open) ADD_FAILURE() << account;
    workers_.clear();
    exchange_.reset();
    registry_.reset();
  });
  if (!why.empty()) GTEST_SKIP() << why;
}

}  // namespace
}  // namespace rt_visual_node

#include "nodes/device_bridge/devices/replay_plugin.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <string>

#include "bus/log/recorder.hpp"
#include "bus/topics.hpp"
#include "bus/wire/codec.hpp"

namespace device_bridge {
namespace {

constexpr std::int64_t kBegin_ns = 5'000'000'000;
constexpr int kTicks = 100;  // of 1 ms, 0.2 mm each

// A recording of role `right`, whose hand is held until its last tenth.
class RecordedHand : public testing::Test {
 protected:
  RecordedHand() {
    auto recorder = std::move(*bus::log::Recorder::Create(file_, {}));
    bus::LatestCodec<core::DeviceState> codec;
    std::vector<std::uint8_t> bytes(2000);
    for (int tick = 0; tick < kTicks; ++tick) {
      core::DeviceState state;
      state.sample_ns = kBegin_ns + tick * 1'000'000;
      state.X_WD.translation.x = 2e-4 * tick;
      state.V_WD.linear_m_per_s.x = 0.2;
      state.opening_m = 0.03;
      state.is_engaged = tick < 90;
      bus::Observation seen;
      seen.writer = "device_bridge";
      seen.sequence = static_cast<std::uint64_t>(tick + 1);
      seen.received_ns = state.sample_ns;
      seen.topic = bus::DeviceStateTopic("right");
      seen.type = bus::MessageType::kDeviceState;
      const std::size_t size = codec.Encode(state, 0, 1000, bytes.data(), bytes.size());
      seen.payload.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_TRUE(recorder->Add(seen));
    }
    EXPECT_TRUE(recorder->Close(0, 0));
  }
  ~RecordedHand() override {
    if (device_ != nullptr) plugin_.close(device_);
    std::filesystem::remove(file_);
  }

  int Open(const std::string& address, const std::string& role) {
    oos_device_setting setting{};
    setting.role = role.c_str();
    setting.address = address.c_str();
    setting.why = why_.data();
    setting.why_size = static_cast<std::uint32_t>(why_.size());
    return plugin_.open(&setting, &device_);
  }
  oos_device_state At(std::int64_t time_ns) {
    oos_device_state state{};
    EXPECT_EQ(plugin_.step(device_, time_ns, nullptr, nullptr, &state), OOS_DEVICE_OK);
    return state;
  }

  const oos_device_plugin& plugin_ = ReplayPlugin();
  void* device_ = nullptr;
  std::array<char, 300> why_{};
  const std::filesystem::path file_ =
      std::filesystem::path(testing::TempDir()) / ("replay_plugin_" + std::to_string(getpid()) + ".mcap");
};

TEST_F(RecordedHand, MovesAsTheRecordedHandDidFromItsFirstStepOnAndThenStandsLetGo) {
  ASSERT_EQ(Open(file_.string() + ":right", "left"), OOS_DEVICE_OK);
  constexpr std::int64_t kNow_ns = 77'000'000'000;  // another clock than the recording's
  EXPECT_EQ(At(kNow_ns).X_BD[4], 0.0);
  const oos_device_state in_it = At(kNow_ns + 50'400'000);
  EXPECT_DOUBLE_EQ(in_it.X_BD[4], 0.01);
  EXPECT_DOUBLE_EQ(in_it.V_BD[3], 0.2);
  EXPECT_DOUBLE_EQ(in_it.opening_m, 0.03);
  EXPECT_NE(in_it.flags & OOS_DEVICE_IS_ENGAGED, 0U);
  EXPECT_EQ(At(kNow_ns + 95'000'000).flags & OOS_DEVICE_IS_ENGAGED, 0U) << "as it was recorded";
  const oos_device_state over = At(kNow_ns + 500'000'000);
  EXPECT_DOUBLE_EQ(over.X_BD[4], 2e-4 * (kTicks - 1));
  EXPECT_EQ(over.V_BD[3], 0.0);
  EXPECT_EQ(over.flags & OOS_DEVICE_IS_ENGAGED, 0U);
  EXPECT_GT(At(kNow_ns + 501'000'000).sequence, over.sequence) << "it goes on giving samples: it is not lost";
}

TEST_F(RecordedHand, SaysWhatIsMissingInARecording) {
  EXPECT_EQ(Open(file_.string(), "left"), OOS_DEVICE_BAD_SETTING);
  EXPECT_NE(std::string(why_.data()).find("device/left/state"), std::string::npos) << why_.data();
  EXPECT_EQ(Open("/no/such.mcap", "right"), OOS_DEVICE_BAD_SETTING);
  EXPECT_NE(std::string(why_.data()).find("/no/such.mcap"), std::string::npos) << why_.data();
}

}  // namespace
}  // namespace device_bridge

#include "tools/web_bridge/scene_stream/stream.hpp"

#include <chrono>
#include <cstring>

#include "tools/web_bridge/scene_stream/assets.hpp"
#include "tools/web_bridge/scene_stream/records.hpp"

namespace scene_stream {

Stream::Stream(const scene::Scenario& scenario, int file, const space::AirFromSpace& air)
    : scenario_(scenario),
      file_(file),
      air_(air),
      blocks_([this](std::uint32_t number, const std::string& floats) {
        std::string bytes(sizeof number, '\0');
        std::memcpy(bytes.data(), &number, sizeof number);
        if (auto written = WriteRecord(file_, RecordKind::kBlock, bytes + floats); !written) block_result_ = written;
      }),
      maker_(air_, &blocks_),
      structures_(scenario_) {}

core::Result<void> Stream::Begin(const view::Scene& scene, double recording_s) {
  auto assets = MakeAssets(scenario_, scene, air_);
  if (!assets) return tl::unexpected(assets.error());
  assets->set_recording_s(recording_s);
  return WriteRecord(file_, RecordKind::kAssets, assets->SerializeAsString());
}

core::Result<void> Stream::Send(const view::Scene& scene, const view::Choices& choices, const Moment& moment,
                                std::int64_t now_ns) {
  if (!IsWritable(file_)) return {};
  next_ns_ = now_ns + period_ns_;
  view::Scene shown = scene;
  structures_.AddTo(choices, &shown);
  if (const std::uint64_t version = FrameMaker::VersionOfSheets(shown); version != sheets_version_) {
    sheets_version_ = version;
    if (!shown.sheets.empty()) {
      auto written = WriteRecord(file_, RecordKind::kSheets, FrameMaker::Sheets(shown).SerializeAsString());
      if (!written) return written;
    }
  }
  oos::SceneFrame frame = maker_.Make(shown, choices);
  blocks_.Age();
  if (!block_result_) return block_result_;
  frame.set_at_s(moment.at_s);
  frame.set_is_playing(moment.is_playing);
  frame.set_state_age_ms(moment.state_age_ms);
  frame.set_sent_ns(std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count());
  return WriteRecord(file_, RecordKind::kFrame, frame.SerializeAsString());
}

}  // namespace scene_stream

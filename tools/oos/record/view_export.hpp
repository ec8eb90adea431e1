#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bus/log/mcap_writer.hpp"
#include "core/result.hpp"
#include "proto/foxglove.pb.h"
#include "scene/scenario.hpp"
#include "view/recorded_feed.hpp"
#include "view/scene_mirror.hpp"

namespace oos {

// Derives channels for 3D viewers from the messages of a run, in the order of their times:
//
//   /scene/models     foxglove.SceneUpdate      the objects' meshes, once; each in its object's frame
//   /scene/lamps      foxglove.SceneUpdate      lamps, when their colours change
//   /scene/contacts   foxglove.SceneUpdate      contact forces as arrows, 30 Hz
//   /scene/sheets     foxglove.SceneUpdate      deformable sheets, 30 Hz
//   /tf               foxglove.FrameTransforms  frames of all objects in "world", 60 Hz
//   /log              foxglove.Log              events
class ViewExport {
 public:
  static constexpr std::int64_t kFrames_ns = 16'666'667;
  static constexpr std::int64_t kOverlays_ns = 33'333'333;

  ViewExport(const scene::Scenario& scenario, bus::log::McapWriter* to);

  // Errors: a mesh that cannot be read; kIo.
  core::Result<void> Begin(std::int64_t now_ns);
  core::Result<void> Take(const bus::log::Channel& channel, const bus::log::Message& message);

  [[nodiscard]] std::uint64_t num_messages() const { return num_messages_; }

 private:
  struct Output {
    std::uint16_t channel = 0;
    std::uint32_t sequence = 0;
  };
  Output AddOutput(const std::string& topic, const google::protobuf::Message& prototype);
  core::Result<void> Write(Output* output, const google::protobuf::Message& message, std::int64_t now_ns);
  core::Result<void> WriteFrames(std::int64_t now_ns);
  core::Result<void> WriteContacts(std::int64_t now_ns);
  core::Result<void> WriteSheets(std::int64_t now_ns);
  core::Result<void> WriteLamps(std::int64_t now_ns);
  core::Result<void> WriteEvent(const bus::log::Message& message);

  const scene::Scenario& scenario_;
  bus::log::McapWriter* to_;
  view::SceneMirror mirror_;
  std::map<std::string, std::uint16_t> schemas_;
  Output models_, lamps_, contacts_, sheets_, frames_, log_;
  std::map<std::uint32_t, foxglove::SceneEntity> lamp_entities_;  // by instance
  std::vector<glm::vec3> lamp_colors_;                            // as written
  std::vector<std::uint64_t> sheet_versions_;
  bool had_arrows_ = true;
  view::RecordedFeed feed_;
  std::int64_t next_frame_ns_ = 0;
  std::int64_t next_overlay_ns_ = 0;
  std::uint64_t num_messages_ = 0;
};

}  // namespace oos

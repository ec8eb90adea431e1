#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "proto/web_scene.pb.h"
#include "tools/web_bridge/scene_stream/point_blocks.hpp"
#include "view/appearance/environment_light.hpp"
#include "view/choices.hpp"
#include "view/scene.hpp"

namespace scene_stream {

// Turns moments of a scene into messages for the page.
class FrameMaker {
 public:
  FrameMaker(const space::AirFromSpace& air, PointBlocks* blocks) : air_(air), blocks_(blocks) {}

  oos::SceneFrame Make(const view::Scene& scene, const view::Choices& choices);

  // Nothing has changed since the last Sheets if this is the same.
  static std::uint64_t VersionOfSheets(const view::Scene& scene);
  static oos::SceneSheets Sheets(const view::Scene& scene);

 private:
  void AddSky(const view::Scene& scene, oos::SceneSky* sky);
  void AddLooks(const view::Scene& scene, oos::SceneFrame* frame) const;
  void AddOverlays(const view::Scene& scene, oos::SceneFrame* frame);
  void PutPoints(const view::SharedPoints& points, oos::ScenePoints* message);

  const space::AirFromSpace& air_;
  PointBlocks* blocks_;
  view::EnvironmentLight irradiance_of_;
  std::array<glm::vec3, 9> irradiance_{};
  bool is_irradiance_known_ = false;
};

// What is on, by the names of view::SetChoice.
std::vector<std::string> NamesOf(const view::Choices& choices, const std::vector<std::string>& objects);

}  // namespace scene_stream

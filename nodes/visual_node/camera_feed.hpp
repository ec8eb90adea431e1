#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/messages/camera.hpp"
#include "core/result.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "view/choices.hpp"
#include "view/stereo.hpp"

namespace visual_node {

// Pictures of a scenario's cameras beside the main one: an inset in the window, and topics camera/<viewer>/<camera>.
// They are drawn seldom and small, because each costs as much as its share of the main picture.
class CameraFeed {
 public:
  static constexpr int kTopicWidth = 192, kTopicHeight = 108;  // 62 kB: a value of a STATE topic has 64 KiB at most
  static constexpr double kMostPerSecond = 5.0;

  explicit CameraFeed(Renderer* renderer) : renderer_(renderer) {}

  // The parameter of a camera's rate: image.<camera>.rate_hz.
  static std::string RateName(const std::string& camera) { return "image." + camera + ".rate_hz"; }

  // Index of the first camera that is mounted on an object; -1: none.
  static int MountedCamera(const view::Assets& assets);

  // What the cameras see whose pictures are due. Index of `rates_hz`: Assets::cameras; 0: none are wanted.
  struct Seen {
    std::size_t camera = 0;
    core::CameraImage image;
  };
  core::Result<std::vector<Seen>> Take(const view::Scene& scene, const std::vector<double>& rates_hz, const Look& look,
                                       std::int64_t now_ns);

  // Draws the mounted camera's picture into the lower right corner of `target`, at most kMostPerSecond anew. `aspect`:
  // width over height of the picture as it is shown.
  core::Result<void> DrawInset(const view::Scene& scene, const Look& look, std::int64_t now_ns, double aspect,
                               const RenderTarget& target);

 private:
  Renderer* renderer_;
  std::unique_ptr<RenderTarget> small_;
  std::unique_ptr<RenderTarget> inset_;
  std::vector<std::int64_t> next_ns_;  // by camera
  std::int64_t next_inset_ns_ = 0;
};

// The inset of a picture that is kept, where the choices want it and both eyes have one picture.
core::Result<void> AddInset(Renderer& renderer, const view::Scene& scene, const view::Choices& choices,
                            view::Stereo stereo, const RenderTarget& target);

}  // namespace visual_node

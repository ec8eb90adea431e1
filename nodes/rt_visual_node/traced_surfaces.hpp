#pragma once

#include <cstdint>
#include <memory>

#include "core/result.hpp"
#include "nodes/rt_visual_node/exchange.hpp"
#include "nodes/visual_node/surfaces.hpp"
#include "tiles/frame.hpp"

namespace rt_visual_node {

// Surfaces that workers trace.
class TracedSurfaces final : public visual_node::Surfaces {
 public:
  TracedSurfaces(const bus::NodeOptions& options, tiles::Mirrors mirrors) : exchange_(options), mirrors_(mirrors) {}

  ~TracedSurfaces() override;

  core::Result<void> Start() { return exchange_.Start(); }
  void Offer(const View& view, double scale) override;
  const Picture* Take() override;
  const Picture* Paint(const View& view, double scale, bool is_kept) override;
  [[nodiscard]] bool is_alone() const override { return !exchange_.has_workers(); }

 private:
  [[nodiscard]] Wish WishFor(const View& view, double scale) const;
  static Picture PictureOf(const Drawn& drawn);

  Exchange exchange_;
  tiles::Mirrors mirrors_;
  std::unique_ptr<Drawn> drawn_;
  std::unique_ptr<Drawn> kept_;
  std::uint64_t num_painted_ = 0;
  // What was offered last, over the picture of the scene as it was drawn last.
  view::Scene offered_;
  scene::Camera offered_camera_;
  std::uint64_t offered_digest_ = 0;
  std::int64_t still_since_ns_ = 0;
  std::int64_t shown_ns_ = 0;
  std::int64_t last_end_ns_ = 0;
  Picture picture_;
};

}  // namespace rt_visual_node

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

  core::Result<void> Start() { return exchange_.Start(); }
  void Offer(const view::Scene& scene, const view::EnvironmentLight& light, const scene::Camera& placed, int width,
             int height) override;
  const Picture* Take() override;
  [[nodiscard]] bool is_alone() const override { return !exchange_.has_workers(); }
  [[nodiscard]] Exchange::Figures figures() const { return exchange_.figures(); }

 private:
  Exchange exchange_;
  tiles::Mirrors mirrors_;
  std::unique_ptr<Drawn> drawn_;
  std::int64_t last_end_ns_ = 0;
  Picture picture_;
};

}  // namespace rt_visual_node

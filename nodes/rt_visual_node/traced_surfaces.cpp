#include "nodes/rt_visual_node/traced_surfaces.hpp"

#include <algorithm>
#include <utility>

#include "core/clock.hpp"

namespace rt_visual_node {
namespace {

constexpr std::int64_t kPatience_ns = 5'000'000;  // then the window looks after its keys

}  // namespace

void TracedSurfaces::Offer(const view::Scene& scene, const view::EnvironmentLight& light, const scene::Camera& placed,
                           int width, int height) {
  Wish wish{tiles::EncodeFrame(scene, light, placed, width, height), scene, placed};
  wish.frame.mirrors = static_cast<std::uint8_t>(mirrors_);
  exchange_.Want(std::move(wish));
}

const visual_node::Surfaces::Picture* TracedSurfaces::Take() {
  auto drawn = exchange_.Take(core::MonotonicNow_ns() + kPatience_ns);
  if (drawn == nullptr) return nullptr;
  drawn_ = std::move(drawn);
  // Frames overlap, so their own time is longer than that after which the next one comes.
  const std::int64_t work_ns = drawn_->end_ns - std::max(drawn_->begin_ns, std::exchange(last_end_ns_, drawn_->end_ns));
  picture_ = {&drawn_->wish.scene, &drawn_->wish.camera, &drawn_->canvas, drawn_->begin_ns, work_ns};
  return &picture_;
}

}  // namespace rt_visual_node

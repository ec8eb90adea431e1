#include "nodes/rt_visual_node/traced_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/clock.hpp"

namespace rt_visual_node {
namespace {

constexpr std::int64_t kPatience_ns = 5'000'000;      // then the window looks after its keys
constexpr std::int64_t kStillAfter_ns = 300'000'000;  // longer than between two messages of what moves
constexpr std::int64_t kRedraw_ns = 30'000'000;       // of what is drawn over a picture that stays
constexpr std::int64_t kPaint_ns = 5'000'000'000;     // for a picture that is kept, with few workers

}  // namespace

// Into the log of the node.
TracedSurfaces::~TracedSurfaces() {
  exchange_.Stop();
  const Exchange::Figures figures = exchange_.figures();
  const auto mean = [&](double sum) { return figures.frames == 0 ? 0.0 : sum / static_cast<double>(figures.frames); };
  std::printf(
      "%llu frames by %zu workers; a frame: %.1f tiles, %.1f ms of cores, %.0f kB; %llu tiles given out again, %llu "
      "answers of no use\n",
      static_cast<unsigned long long>(figures.frames), figures.workers, mean(static_cast<double>(figures.tiles)),
      1e3 * mean(figures.cost_s), 1e-3 * mean(static_cast<double>(figures.bytes)),
      static_cast<unsigned long long>(figures.reissued), static_cast<unsigned long long>(figures.unused));
}

Wish TracedSurfaces::WishFor(const View& view) const {
  Wish wish{tiles::EncodeFrame(view.scene, view.light, view.camera, view.width, view.height), view.scene, view.camera};
  wish.frame.mirrors = static_cast<std::uint8_t>(mirrors_);
  return wish;
}

// While nothing moves pictures have their full size, and become better.
void TracedSurfaces::Offer(const View& view, double scale) {
  Wish wish = WishFor(view);
  const std::int64_t now_ns = core::MonotonicNow_ns();
  const std::uint64_t digest = tiles::FrameDigest(wish.frame);
  if (std::exchange(offered_digest_, digest) != digest) still_since_ns_ = now_ns;
  offered_ = view.scene;
  offered_camera_ = view.camera;
  const bool is_still = now_ns - still_since_ns_ > kStillAfter_ns;
  if (!is_still && now_ns - still_since_ns_ > 0) return;  // it is in work, or drawn
  if (!is_still) {
    const auto scaled = [scale](std::uint32_t pixels) {
      return static_cast<std::uint32_t>(std::max(1L, std::lround(scale * pixels)));
    };
    const std::uint32_t height = wish.frame.height;
    wish.frame.width = scaled(wish.frame.width);
    wish.frame.height = scaled(height);
    wish.frame.focal_px *= static_cast<float>(wish.frame.height) / static_cast<float>(height);
  }
  exchange_.Want(std::move(wish));
}

const visual_node::Surfaces::Picture* TracedSurfaces::Take() {
  auto drawn = exchange_.Take(core::MonotonicNow_ns() + kPatience_ns);
  const std::int64_t now_ns = core::MonotonicNow_ns();
  if (drawn == nullptr) {
    // What explains the scene may change while nothing moves.
    const bool is_due =
        drawn_ != nullptr && now_ns - still_since_ns_ > kStillAfter_ns && now_ns - shown_ns_ > kRedraw_ns;
    if (!is_due) return nullptr;
    picture_ = {&offered_, &offered_camera_, &drawn_->canvas, now_ns, 0};
  } else {
    drawn_ = std::move(drawn);
    // Frames overlap, so their own time is longer than that after which the next one comes.
    const std::int64_t work_ns =
        drawn_->end_ns - std::max(drawn_->begin_ns, std::exchange(last_end_ns_, drawn_->end_ns));
    picture_ = {&drawn_->wish.scene, &drawn_->wish.camera, &drawn_->canvas, drawn_->begin_ns, work_ns};
  }
  shown_ns_ = now_ns;
  return &picture_;
}

const tiles::Canvas* TracedSurfaces::Paint(const View& view) {
  Wish wish = WishFor(view);
  wish.is_kept = true;
  wish.frame.mirrors = static_cast<std::uint8_t>(tiles::Mirrors::kAll);
  exchange_.Want(std::move(wish));
  for (const std::int64_t end_ns = core::MonotonicNow_ns() + kPaint_ns; core::MonotonicNow_ns() < end_ns;) {
    kept_ = exchange_.Take(end_ns);
    if (kept_ != nullptr && kept_->wish.is_kept) return &kept_->canvas;
    if (is_alone()) break;
  }
  return nullptr;
}

}  // namespace rt_visual_node

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
constexpr std::int64_t kShow_ns = 500'000'000;        // for one that others wait for, too

}  // namespace

// Into the log of the node.
TracedSurfaces::~TracedSurfaces() {
  exchange_.Stop();
  if (!exchange_.trouble().empty()) std::printf("no worker was reached: %s\n", exchange_.trouble().c_str());
  const Exchange::Figures figures = exchange_.figures();
  const auto mean = [&](double sum) { return figures.frames == 0 ? 0.0 : sum / static_cast<double>(figures.frames); };
  std::printf(
      "%llu of %llu frames complete, by %zu workers; a frame: %.1f tiles, %.1f ms of cores, %.0f kB; %llu tiles given "
      "out again, %llu "
      "answers of no use\n",
      static_cast<unsigned long long>(figures.frames), static_cast<unsigned long long>(figures.begun), figures.workers,
      mean(static_cast<double>(figures.tiles)), 1e3 * mean(figures.cost_s),
      1e-3 * mean(static_cast<double>(figures.bytes)), static_cast<unsigned long long>(figures.reissued),
      static_cast<unsigned long long>(figures.unused));
}

// The views of all eyes are parts of one picture.
Wish TracedSurfaces::WishFor(const View& view, double scale) const {
  const auto scaled = [scale](int pixels) { return std::max(1, static_cast<int>(std::lround(scale * pixels))); };
  std::vector<glm::ivec2> sizes_px;
  for (const visual_node::SeenView& seen : view.eyes) {
    sizes_px.emplace_back(scaled(seen.size_px.x), scaled(seen.size_px.y));
  }
  Wish wish{.frame = {},
            .scene = view.scene,
            .camera = view.camera,
            .viewing = view.viewing,
            .parts = tiles::StackParts(sizes_px)};
  std::vector<tiles::SeenPart> seen_parts;
  for (std::size_t i = 0; i < view.eyes.size(); ++i) seen_parts.push_back({view.eyes[i].eye, wish.parts[i]});
  wish.frame = tiles::EncodeFrame(view.scene, view.light, seen_parts);
  wish.frame.mirrors = static_cast<std::uint8_t>(mirrors_);
  return wish;
}

visual_node::Surfaces::Picture TracedSurfaces::PictureOf(const Drawn& drawn) {
  Picture picture{.scene = &drawn.wish.scene,
                  .camera = &drawn.wish.camera,
                  .viewing = &drawn.wish.viewing,
                  .surfaces = {},
                  .begin_ns = drawn.begin_ns,
                  .work_ns = drawn.end_ns - drawn.begin_ns};
  for (const tiles::Tile& part : drawn.wish.parts) picture.surfaces.push_back({&drawn.canvas, part});
  return picture;
}

// While nothing moves pictures have their full size, and become better.
void TracedSurfaces::Offer(const View& view, double scale) {
  Wish wish = WishFor(view, 1.0);
  const std::int64_t now_ns = core::MonotonicNow_ns();
  const std::uint64_t digest = tiles::FrameDigest(wish.frame);
  if (std::exchange(offered_digest_, digest) != digest) still_since_ns_ = now_ns;
  offered_ = view.scene;
  offered_camera_ = view.camera;
  const bool is_still = now_ns - still_since_ns_ > kStillAfter_ns;
  if (!is_still && now_ns - still_since_ns_ > 0) return;  // it is in work, or drawn
  exchange_.Want(is_still ? std::move(wish) : WishFor(view, scale));
}

const visual_node::Surfaces::Picture* TracedSurfaces::Take() {
  auto drawn = exchange_.Take(core::MonotonicNow_ns() + kPatience_ns);
  const std::int64_t now_ns = core::MonotonicNow_ns();
  if (drawn == nullptr) {
    // What explains the scene may change while nothing moves.
    const bool is_due =
        drawn_ != nullptr && now_ns - still_since_ns_ > kStillAfter_ns && now_ns - shown_ns_ > kRedraw_ns;
    if (!is_due) return nullptr;
    picture_ = PictureOf(*drawn_);
    picture_.scene = &offered_;
    picture_.camera = &offered_camera_;
    picture_.begin_ns = now_ns;
    picture_.work_ns = 0;
  } else {
    drawn_ = std::move(drawn);
    // Frames overlap, so their own time is longer than that after which the next one comes.
    picture_ = PictureOf(*drawn_);
    picture_.work_ns = drawn_->end_ns - std::max(drawn_->begin_ns, std::exchange(last_end_ns_, drawn_->end_ns));
  }
  shown_ns_ = now_ns;
  return &picture_;
}

const visual_node::Surfaces::Picture* TracedSurfaces::Paint(const View& view, double scale, bool is_kept) {
  Wish wish = WishFor(view, is_kept ? 1.0 : scale);
  wish.number = ++num_painted_;
  if (is_kept) wish.frame.mirrors = static_cast<std::uint8_t>(tiles::Mirrors::kAll);
  exchange_.Want(std::move(wish));
  const std::int64_t patience_ns = is_kept ? kPaint_ns : kShow_ns;
  for (const std::int64_t end_ns = core::MonotonicNow_ns() + patience_ns; core::MonotonicNow_ns() < end_ns;) {
    kept_ = exchange_.Take(end_ns);
    if (kept_ != nullptr && kept_->wish.number == num_painted_) {
      picture_ = PictureOf(*kept_);
      return &picture_;
    }
    if (is_alone()) break;
  }
  return nullptr;
}

}  // namespace rt_visual_node

#include "nodes/rt_worker/drawer.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

#include "core/clock.hpp"
#include "tiles/frame.hpp"
#include "tiles/pixels.hpp"

namespace rt_worker {
namespace {

// What the calling thread has used of a core.
std::int64_t CpuTime_ns() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return time.tv_sec * core::kNanosecondsPerSecond + time.tv_nsec;
}

bool IsInside(const core::RayJob& job, const core::RayFrame& frame) {
  const auto fits = [](std::uint64_t begin, std::uint64_t size, std::uint64_t all) { return begin + size <= all; };
  return fits(job.x, job.width, frame.width) && fits(job.y, job.height, frame.height) && job.width > 0 &&
         job.height > 0;
}

// What two rectangles have in common; without pixels: nothing.
tiles::Tile Overlap(const tiles::Tile& a, const tiles::Tile& b) {
  const int x = std::max(a.x, b.x), y = std::max(a.y, b.y);
  return {x, y, std::max(0, std::min(a.x + a.width, b.x + b.width) - x),
          std::max(0, std::min(a.y + a.height, b.y + b.height) - y)};
}

}  // namespace

core::Result<Drawer> Drawer::Create(const view::Scene& scene, const raytrace::MeshLoader& load_mesh) {
  Drawer drawer;
  drawer.scene_ = scene;
  auto tracer = raytrace::Tracer::Create(scene, load_mesh);
  if (!tracer) return tl::unexpected(tracer.error());
  drawer.tracer_ = std::move(*tracer);
  return drawer;
}

// A tile may lie on several parts of the picture, and on none.
void Drawer::DrawParts(const tiles::Tile& tile, const tiles::Quality& quality) {
  const auto num_pixels = static_cast<std::size_t>(tile.num_pixels());
  light_.assign(3 * num_pixels, 0.0f);
  depth_m_.assign(num_pixels, 0.0f);
  for (const tiles::SeenPart& part : parts_) {
    const tiles::Tile both = Overlap(tile, part.at);
    if (both.num_pixels() == 0) continue;
    const raytrace::LitTile lit =
        tracer_->Draw(raytrace::Eye::Of(part.eye, part.at.width, part.at.height),
                      {both.x - part.at.x, both.y - part.at.y, both.width, both.height}, quality);
    for (int row = 0; row < both.height; ++row) {
      const auto to = static_cast<std::ptrdiff_t>((both.y - tile.y + row) * tile.width + both.x - tile.x);
      const auto from = static_cast<std::ptrdiff_t>(row * both.width);
      std::copy_n(lit.light.values.begin() + 3 * from, 3 * both.width, light_.begin() + 3 * to);
      std::copy_n(lit.depth_m.values.begin() + from, both.width, depth_m_.begin() + to);
    }
  }
}

bool Drawer::Draw(const core::RayFrame& frame, const core::RayJob& job, core::RayTile* answer) {
  const std::int64_t cpu_ns = CpuTime_ns(), begin_ns = core::MonotonicNow_ns();
  if (!IsInside(job, frame)) return false;
  if (!has_frame_ || frame_ != frame.frame) {
    if (!tiles::ApplyFrame(frame, &scene_)) return false;
    tracer_->Update(scene_, tiles::LightOf(frame));
    parts_ = tiles::PartsOf(frame);
    frame_ = frame.frame;
    has_frame_ = true;
  }
  const tiles::Tile tile{static_cast<int>(job.x), static_cast<int>(job.y), static_cast<int>(job.width),
                         static_cast<int>(job.height)};
  DrawParts(tile, tiles::QualityOf(frame));
  answer->job = job.id;
  answer->frame = job.frame;
  answer->pixels = tiles::EncodePixels(tile, light_, depth_m_);
  answer->cost_ns = static_cast<std::uint64_t>(CpuTime_ns() - cpu_ns);
  answer->took_ns = static_cast<std::uint64_t>(core::MonotonicNow_ns() - begin_ns);
  return true;
}

}  // namespace rt_worker

#include "nodes/rt_worker/drawer.hpp"

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

raytrace::Eye EyeOf(const core::RayFrame& frame) {
  return {glm::vec3(frame.X_WE.translation), glm::mat3(glm::mat3_cast(frame.X_WE.rotation)), frame.focal_px,
          static_cast<int>(frame.width), static_cast<int>(frame.height)};
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

bool Drawer::Draw(const core::RayFrame& frame, const core::RayJob& job, core::RayTile* answer) {
  const std::int64_t cpu_ns = CpuTime_ns(), begin_ns = core::MonotonicNow_ns();
  if (!IsInside(job, frame)) return false;
  if (!has_frame_ || frame_ != frame.frame) {
    if (!tiles::ApplyFrame(frame, &scene_)) return false;
    tracer_->Update(scene_, tiles::LightOf(frame));
    frame_ = frame.frame;
    has_frame_ = true;
  }
  const tiles::Tile tile{static_cast<int>(job.x), static_cast<int>(job.y), static_cast<int>(job.width),
                         static_cast<int>(job.height)};
  const raytrace::LitTile lit = tracer_->Draw(EyeOf(frame), tile, tiles::QualityOf(frame));
  answer->job = job.id;
  answer->frame = job.frame;
  answer->pixels = tiles::EncodePixels(tile, lit.light.values, lit.depth_m.values);
  answer->cost_ns = static_cast<std::uint64_t>(CpuTime_ns() - cpu_ns);
  answer->took_ns = static_cast<std::uint64_t>(core::MonotonicNow_ns() - begin_ns);
  return true;
}

}  // namespace rt_worker

#include "nodes/visual_node/walls/kept_scenes.hpp"

namespace visual_node {

void KeptScenes::Keep(std::uint64_t tick, const view::Scene& scene) {
  if (tick == 0 || tick % KeptTicks::kTicksPerKept != 0) return;
  const std::scoped_lock lock(mutex_);
  if (ring_[newest_].tick == tick) return;
  newest_ = (newest_ + 1) % ring_.size();
  const bool is_pinned = pinned_tick_ != 0 && ring_[newest_].tick == pinned_tick_;
  if (is_pinned) newest_ = (newest_ + 1) % ring_.size();
  ring_[newest_].tick = tick;
  ring_[newest_].scene = scene;  // reuses its buffers
}

void KeptScenes::Pin(std::uint64_t tick) {
  const std::scoped_lock lock(mutex_);
  pinned_tick_ = tick;
}

KeptTicks KeptScenes::ticks() const {
  const std::scoped_lock lock(mutex_);
  const std::uint64_t newest = ring_[newest_].tick;
  KeptTicks ticks;
  for (const Kept& kept : ring_) {
    const bool is_earlier_run = kept.tick > newest;
    if (kept.tick != 0 && !is_earlier_run) ticks.Add(kept.tick);
  }
  return ticks;
}

std::uint64_t KeptScenes::newest_tick() const {
  const std::scoped_lock lock(mutex_);
  return ring_[newest_].tick;
}

std::uint64_t KeptScenes::Take(std::uint64_t tick, view::Scene* scene) const {
  const std::scoped_lock lock(mutex_);
  const auto distance = [&](const Kept& kept) { return kept.tick > tick ? kept.tick - tick : tick - kept.tick; };
  const Kept* nearest = &ring_[newest_];
  for (const Kept& kept : ring_) {
    if (tick != 0 && kept.tick != 0 && distance(kept) < distance(*nearest)) nearest = &kept;
  }
  if (nearest->tick != 0) *scene = nearest->scene;
  return nearest->tick;
}

}  // namespace visual_node

#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "nodes/visual_node/walls/kept_ticks.hpp"
#include "view/scene.hpp"

namespace visual_node {

// The newest states of a wall, as scenes, for frames of which the first wall names the state. The named one is not
// forgotten until another is named, so a wall can draw it however late it is. Any thread may call.
class KeptScenes {
 public:
  // `scene` shows the physics state of that tick. Only some ticks are kept (KeptTicks).
  void Keep(std::uint64_t tick, const view::Scene& scene);
  // The first wall has named that tick, which may not be here yet.
  void Pin(std::uint64_t tick);

  [[nodiscard]] KeptTicks ticks() const;
  [[nodiscard]] std::uint64_t newest_tick() const;  // 0: none
  // The scene of that state, or of the one nearest to it; tick 0: of the newest. Returns the scene's tick; 0: nothing
  // is kept yet, and `scene` is as it was.
  std::uint64_t Take(std::uint64_t tick, view::Scene* scene) const;

 private:
  struct Kept {
    std::uint64_t tick = 0;  // 0: empty
    view::Scene scene;
  };

  mutable std::mutex mutex_;
  // A second, four times what ticks() says: a wall may be named a state that it has said it keeps long ago. One more,
  // because the named one may be older than all others.
  static constexpr std::size_t kSize = 4 * KeptTicks::kMostKept + 1;

  std::vector<Kept> ring_{kSize};
  std::size_t newest_ = 0;
  std::uint64_t pinned_tick_ = 0;
};

}  // namespace visual_node

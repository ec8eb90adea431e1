#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/visual_node/draw/pasted.hpp"
#include "nodes/visual_node/draw/seen_view.hpp"
#include "scene/scenario.hpp"
#include "view/appearance/environment_light.hpp"
#include "view/scene.hpp"
#include "view/stereo.hpp"

namespace visual_node {

// Somebody else who draws what is opaque of a scene, and whose pictures come later than they were asked for. All calls
// come from the drawing thread.
class Surfaces {
 public:
  Surfaces() = default;
  Surfaces(const Surfaces&) = delete;
  Surfaces& operator=(const Surfaces&) = delete;
  virtual ~Surfaces() = default;

  // A scene, and how it is to be seen: `eyes` are what Composer::Views says of the other members.
  struct View {
    const view::Scene& scene;
    view::EnvironmentLight light;
    scene::Camera camera;  // in W
    view::Viewing viewing;
    std::vector<SeenView> eyes;
  };
  // The newest scene. While things move its picture may be smaller, at that share of width and height.
  virtual void Offer(const View& view, double scale) = 0;

  // A picture that is ready.
  struct Picture {
    const view::Scene* scene = nullptr;
    const scene::Camera* camera = nullptr;  // in W
    const view::Viewing* viewing = nullptr;
    std::vector<Pasted> surfaces{};  // of each eye's view
    std::int64_t begin_ns = 0;       // it was begun then
    std::int64_t work_ns = 0;        // what it took of the time of those who draw
  };
  // The newest picture that was not taken yet; valid until the next call. Waits a little for it; null: none has come.
  virtual const Picture* Take() = 0;

  // A picture of exactly this scene. Waits for it; null: nobody draws it. `is_kept`: in its full size with all that a
  // picture can have; else as those that are shown.
  virtual const Picture* Paint(const View& view, double scale, bool is_kept) = 0;

  // Nobody is there to draw; the viewer draws by itself then.
  [[nodiscard]] virtual bool is_alone() const = 0;
};

}  // namespace visual_node

#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/result.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/draw/seen_view.hpp"
#include "view/layout.hpp"
#include "view/stereo.hpp"

namespace visual_node {

// How a window is filled: by which cameras, and for which eyes.
struct Composition {
  view::Layout layout;
  view::Viewing viewing;

  // One view for one eye.
  [[nodiscard]] bool is_plain() const { return !layout.is_divided() && viewing.stereo == view::Stereo::kNone; }
};

// A place in a window, as the eye sees it whose picture is there.
struct Spot {
  view::Frustum eye;
  glm::ivec2 size_px{0};  // of the view
  glm::dvec2 at_px{0.0};  // in the view, from its top left corner
};

// Draws pictures that are made of several: views beside each other, and what both eyes see. Captions are drawn over the
// whole window, labels in each view; both have no depth of their own but that of their place.
class Composer {
 public:
  static core::Result<Composer> Create();

  // What the layout's first view shows; the others are the scene's cameras of their names.
  struct Shown {
    const view::Scene& scene;
    const scene::Camera& steered;
    const Composition& composition;
  };

  // What is drawn for a window of that size: the views of the left eye, then those of the right one. Each is drawn
  // `samples` times as wide and high as it is shown.
  static std::vector<SeenView> Views(const Shown& shown, int width, int height, int samples = 1);

  // Draws the pictures of the eyes: of one on `target` itself, of two on targets of their own. `look.surfaces` are of
  // Views, in its order.
  core::Result<void> DrawEyes(Renderer& renderer, const Shown& shown, const Look& look, const RenderTarget& target,
                              int samples = 1);
  // Those that DrawEyes has drawn.
  [[nodiscard]] const std::vector<const RenderTarget*>& eyes() const { return drawn_; }
  // Makes the window's picture of them.
  void Join(view::Stereo stereo, const RenderTarget& target) const;

  // What is seen at a pixel of the window, from its top left corner. None: between two views.
  static std::optional<Spot> Find(const Shown& shown, int width, int height, const glm::dvec2& at_px);

 private:
  const RenderTarget& Target(std::size_t eye, const glm::ivec2& size_px);
  core::Result<void> DrawView(Renderer& renderer, const Shown& shown, std::size_t index, const view::Pane& pane,
                              const Look& look, std::size_t eye, int samples, const RenderTarget& target);

  GlProgram anaglyph_;
  GlProgram interlaced_;
  GlVertexArray nothing_;  // the core profile requires one, even when the shader generates its vertices
  std::vector<std::unique_ptr<RenderTarget>> eyes_;
  std::map<std::pair<int, int>, RenderTarget> views_;  // by size
  std::vector<const RenderTarget*> drawn_;
  std::vector<Box> taken_;  // by captions, in the window
};

// A picture that is kept has so many samples in each direction of a pixel.
constexpr int kSmoothSamples = 2;

// What others add to a picture: `surfaces` are Look's, drawn with so many samples; `add` draws over the picture, while
// the renderer's film is still that of the picture.
struct Pasting {
  std::span<const Pasted> surfaces = {};
  std::function<core::Result<void>(const RenderTarget&)> add = nullptr;
};

// A picture that is kept: with four samples a pixel.
core::Result<Image> RenderSmooth(Renderer& renderer, Composer& composer, const Composer::Shown& shown, int width,
                                 int height, const Pasting& pasting = {});

}  // namespace visual_node

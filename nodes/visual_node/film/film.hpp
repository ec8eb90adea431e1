#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/result.hpp"
#include "nodes/visual_node/film/darkroom.hpp"
#include "nodes/visual_node/gl/gl_objects.hpp"

namespace visual_node {

// What the scene is drawn on: unbounded light with depth (16-bit floats), from which a picture is developed: exposure,
// tone curve (view/appearance/tone_curve.hpp), sRGB, smooth edges, and the size of the target. Light is linear RGB, in
// units of a white wall that faces the sun. Alpha: 1 on bodies; 0 on stars and space, which the light meter and the
// smoothing leave out.
class Film {
 public:
  // `by_processor`: pictures are developed by it (darkroom.hpp), not by shaders.
  static core::Result<Film> Create(bool by_processor);

  // Binds the film and clears its depth. The former content is lost.
  void Begin(int width, int height);
  // Makes the picture and leaves the target bound.
  void Develop(float exposure, const RenderTarget& target);
  // The geometric mean of the luminance of what Begin's size shows; none when it shows only space. Waits for the
  // drawing.
  [[nodiscard]] std::optional<float> MeanLuminance();

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] GLuint framebuffer() const { return light_framebuffer_.id(); }
  [[nodiscard]] GLuint depth() const { return depth_.id(); }
  // Four floats for each pixel, the lowest row first. Waits for the drawing.
  [[nodiscard]] std::vector<float> ReadLight() const;

 private:
  void Resize(int width, int height);
  void DevelopByShaders(float exposure, const RenderTarget& target);
  void DevelopByProcessor(float exposure, const RenderTarget& target);
  // Once for each picture, when all of it is drawn. Waits for the drawing.
  void ReadLightBits();

  bool by_processor_ = false;
  Darkroom darkroom_;
  std::vector<std::uint16_t> light_bits_;  // read for it
  bool is_read_ = false;                   // since Begin
  GlProgram develop_;
  GlProgram smooth_;
  GlProgram meter_;
  GlVertexArray nothing_;  // the core profile requires one, even when the shader generates its vertices
  GlTexture light_;
  GlTexture depth_;
  GlTexture developed_;
  GlTexture smoothed_;
  GlTexture sums_;
  GlFramebuffer light_framebuffer_;
  GlFramebuffer developed_framebuffer_;
  GlFramebuffer smoothed_framebuffer_;
  GlFramebuffer sums_framebuffer_;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace visual_node
